#!/usr/bin/env python3
"""A vehicle of one's own, in rclpy, in place of `plant_sim`, in lockstep with our controller and actuator:

    planesman node depth_controller --ros-args -p lockstep:=true -p use_sim_time:=true -p depth_setpoint:=0.914 &
    planesman node dha_actuator --ros-args -p lockstep:=true -p use_sim_time:=true &
    python3 launch-scripts/examples/own_plant.py --ros-args -r __ns:=/auv -p duration:=60.0

In each tick it publishes `/clock` and `state` with the tick's stamp, and waits for the `plane_motion` that bears that stamp: the
plane angle over the tick. Then it moves on. Without an answer for a second it says the same again: a node may have come
late, or a message may be lost; our nodes answer a stamp again with the same bytes. A member such as `recorder` or `sysid` with `answer:=true`
is waited for in the same way: for its `tick_answer` with that stamp.

The vehicle is Brunner's (NPS thesis, 1988) with the pitch dynamics of Table 3, a damped inertia, at constant speed.
"""

import math
import sys
from time import monotonic

import rclpy
from planesman_msgs.msg import PlaneMotion, VehicleState
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node
from rosgraph_msgs.msg import Clock

PLANE, DAMPING = 0.2333, 0.1
"""K/J, 1/s^2 per rad, and B/J, 1/s, at 1 ft/s."""
AGAIN_AFTER = 1.0
"""s of the machine's time."""


class OwnPlant(Node):
    def __init__(self):
        super().__init__("own_plant")
        self.declare_parameter("tick", 0.05)  # s
        self.declare_parameter("speed", 0.3048)  # m/s
        self.declare_parameter("duration", 60.0)  # s
        self.tick = round(self.get_parameter("tick").value * 1e9)
        self.ticks = round(self.get_parameter("duration").value * 1e9 / self.tick)
        self.k = 0
        self.state = VehicleState()
        self.state.header.frame_id = "map_ned"
        self.state.surge = self.get_parameter("speed").value
        self.clock = self.create_publisher(Clock, "/clock", 10)
        self.states = self.create_publisher(VehicleState, "state", 10)
        self.create_subscription(PlaneMotion, "plane_motion", self.on_motion, 10)
        self.create_timer(0.1, self.on_timer)
        self.say()

    def say(self) -> None:
        stamp = self.state.header.stamp
        stamp.sec, stamp.nanosec = divmod(self.k * self.tick, 1_000_000_000)
        self.clock.publish(Clock(clock=stamp))
        self.states.publish(self.state)
        self.said = monotonic()

    def on_timer(self) -> None:
        if monotonic() - self.said >= AGAIN_AFTER:
            self.say()

    def on_motion(self, motion: PlaneMotion) -> None:
        if motion.header.stamp != self.state.header.stamp or self.is_done():
            return
        # The samples are evenly spaced over the tick, the first at its begin.
        state, planes = self.state, motion.dive_planes
        step = self.tick * 1e-9 / (len(planes) - 1)
        for before, after in zip(planes, planes[1:]):
            acceleration = -PLANE * (before + after) / 2 - DAMPING * state.pitch_rate
            state.depth_rate = -state.surge * math.sin(state.pitch)
            state.depth += step * state.depth_rate
            state.pitch += step * state.pitch_rate
            state.pitch_rate += step * acceleration
        state.dive_planes = planes[-1]
        self.k += 1
        if self.is_done():
            self.get_logger().info(f"flown: {self.k} ticks, depth {state.depth:.3f} m")
        else:
            self.say()

    def is_done(self) -> bool:
        return self.k >= self.ticks


def main() -> int:
    rclpy.init(args=sys.argv)
    executor = SingleThreadedExecutor()
    plant = OwnPlant()
    executor.add_node(plant)
    try:
        while rclpy.ok() and not plant.is_done():
            executor.spin_once(timeout_sec=1.0)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    return 0


if __name__ == "__main__":
    sys.exit(main())
