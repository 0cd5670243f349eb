#!/usr/bin/env python3
"""A trained policy, in rclpy, in place of `depth_controller`. Vehicle and gains are those of an environment of `planesman.gym` (docs/gym.md):

    planesman node plant_sim --ros-args -r __ns:=/auv -p vehicle:=lauv -p speed:=1.5 -p time:=lockstep &
    planesman node dha_actuator --ros-args -r __ns:=/auv -p lockstep:=true -p model:=ideal &
    python3 launch-scripts/examples/policy_controller.py --ros-args -r __ns:=/auv -p depth:=10.0

It answers each `state` with a `plane_command` that bears the state's stamp, which is all that lockstep asks of it; with `-p feedback:=estimate`
each `estimate`. `-p policy:=FILE.json` flies another policy: what python/notebooks/learn_a_policy.ipynb writes.
"""

import sys
from pathlib import Path

import rclpy
from planesman_msgs.msg import MotionEstimate, PlaneCommand, VehicleState
from policy import Policy
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node

TRAINED = Path(__file__).resolve().parent / "lauv_depth_policy.json"


class PolicyController(Node):
    def __init__(self):
        super().__init__("policy_controller")
        self.policy = Policy(self.declare_parameter("policy", str(TRAINED)).value)
        feedback = self.declare_parameter("feedback", "state").value  # state or estimate
        self.declare_parameter("depth", 0.0)  # m, positive down
        self.declare_parameter("thrust", 9.0 / 14.0)  # share of the most; held in training
        self.command = self.create_publisher(PlaneCommand, "plane_command", 10)
        kind = {"state": VehicleState, "estimate": MotionEstimate}[feedback]
        self.create_subscription(kind, feedback, self.on_state, 10)

    def on_state(self, state: VehicleState | MotionEstimate) -> None:
        depth = self.get_parameter("depth").value
        inputs = self.policy(
            {
                "depth_error": depth - state.depth,
                "depth_rate": state.depth_rate,
                "pitch": state.pitch,
                "pitch_rate": state.pitch_rate,
            }
        )
        thrust = self.get_parameter("thrust").value
        self.command.publish(PlaneCommand(header=state.header, dive_planes=inputs["stern_planes"], thrust=thrust))


def main() -> int:
    rclpy.init(args=sys.argv)
    executor = SingleThreadedExecutor()
    executor.add_node(PolicyController())
    try:
        # Not `spin()`: where no state comes any more, it sometimes misses SIGTERM and Ctrl-C.
        while rclpy.ok():
            executor.spin_once(timeout_sec=1.0)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    return 0


if __name__ == "__main__":
    sys.exit(main())
