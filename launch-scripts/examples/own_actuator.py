#!/usr/bin/env python3
"""An actuator of one's own, in rclpy, in place of `dha_actuator`:

    planesman node plant_sim &
    planesman node depth_controller &
    python3 launch-scripts/examples/own_actuator.py --ros-args -r __ns:=/auv -p rate:=0.2

It answers each `plane_command` with a `sensor_msgs/JointState` on `planes` that carries the command's stamp: the angle at which
`plant_sim` holds the planes over that tick. The planes go where they are asked to, at most `rate` fast. A stamp that comes
again is answered again, and moves nothing.
"""

import sys

import rclpy
from planesman_msgs.msg import PlaneCommand
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node
from sensor_msgs.msg import JointState


class OwnActuator(Node):
    def __init__(self):
        super().__init__("own_actuator")
        self.declare_parameter("rate", 0.2)  # rad/s
        self.declare_parameter("tick", 0.05)  # s, from one command to the next
        self.answered = None  # the stamp; lockstep begins with 0
        self.answer = JointState(name=["dive_planes"], position=[0.0], velocity=[0.0])
        self.planes = self.create_publisher(JointState, "planes", 10)
        self.create_subscription(PlaneCommand, "plane_command", self.on_command, 10)

    def on_command(self, command: PlaneCommand) -> None:
        if command.header.stamp != self.answered:
            self.answered = command.header.stamp
            tick = self.get_parameter("tick").value
            largest = self.get_parameter("rate").value * tick
            step = max(-largest, min(largest, command.dive_planes - self.answer.position[0]))
            self.answer.position[0] += step
            self.answer.velocity[0] = step / tick
        self.answer.header = command.header
        self.planes.publish(self.answer)


def main() -> int:
    rclpy.init(args=sys.argv)
    executor = SingleThreadedExecutor()
    executor.add_node(OwnActuator())
    try:
        while rclpy.ok():
            executor.spin_once(timeout_sec=1.0)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    return 0


if __name__ == "__main__":
    sys.exit(main())
