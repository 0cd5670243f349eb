#!/usr/bin/env python3
"""A depth controller of one's own, in rclpy, in place of `depth_controller`:

    planesman node plant_sim &
    planesman node dha_actuator &
    python3 launch-scripts/examples/own_controller.py --ros-args -r __ns:=/auv -p depth:=0.914

It answers each `state` with a `plane_command` that carries the state's stamp; that stamp is all that lockstep
(`plant_sim` with `time:=lockstep`, `dha_actuator` with `lockstep:=true`) asks of it. With `-p feedback:=estimate` it answers each
`estimate` instead, as own_estimator.py publishes it. The control law is Brunner's (NPS thesis, 1988,
program T6): depth error and rate to a dive angle, dive angle and pitch rate to the planes. Pitch is bow up
positive, depth and planes are positive down.
"""

import sys

import rclpy
from planesman_msgs.msg import MotionEstimate, PlaneCommand, VehicleState
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node


class OwnController(Node):
    def __init__(self):
        super().__init__("own_controller")
        feedback = self.declare_parameter("feedback", "state").value  # state or estimate
        for name, value in {
            "depth": 0.0,  # m, positive down
            "depth_p": 0.82,  # rad/m
            "depth_d": 1.97,  # rad s/m
            "pitch_p": 0.7,  # rad/rad
            "pitch_rate": 2.0,  # s
            "pitch_limit": 0.785,  # rad
            "plane_limit": 0.524,  # rad
        }.items():
            self.declare_parameter(name, value)
        self.command = self.create_publisher(PlaneCommand, "plane_command", 10)
        kind = {"state": VehicleState, "estimate": MotionEstimate}[feedback]
        self.create_subscription(kind, feedback, self.on_state, 10)

    def on_state(self, state: VehicleState | MotionEstimate) -> None:
        def parameter(name: str) -> float:
            return self.get_parameter(name).value

        def bounded(value: float, limit: float) -> float:
            return max(-limit, min(limit, value))

        error = parameter("depth") - state.depth
        dive_angle = parameter("depth_p") * error - parameter("depth_d") * state.depth_rate
        pitch_error = bounded(-dive_angle, parameter("pitch_limit")) - state.pitch
        planes = -parameter("pitch_p") * pitch_error + parameter("pitch_rate") * state.pitch_rate
        planes = bounded(planes, parameter("plane_limit"))
        self.command.publish(PlaneCommand(header=state.header, dive_planes=planes))


def main() -> int:
    rclpy.init(args=sys.argv)
    executor = SingleThreadedExecutor()
    executor.add_node(OwnController())
    try:
        # Not `spin()`: where no state comes any more, it sometimes misses SIGTERM and Ctrl-C.
        while rclpy.ok():
            executor.spin_once(timeout_sec=1.0)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    return 0


if __name__ == "__main__":
    sys.exit(main())
