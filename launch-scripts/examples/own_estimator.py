#!/usr/bin/env python3
"""An estimator of one's own, in rclpy: pitch and depth from gyro and pressure, published as `estimate`.

    planesman node plant_sim --ros-args -p time:=lockstep -p 'lockstep.gates:=[estimate]' &
    planesman node depth_controller --ros-args -p lockstep:=true -p use_sim_time:=true &
    planesman node dha_actuator --ros-args -p lockstep:=true -p use_sim_time:=true &
    python3 launch-scripts/examples/own_estimator.py --ros-args -r __ns:=/auv -p reliable_sensors:=true

The plant's sensors are best effort in real time, so that a reliable subscription would get nothing, and reliable in lockstep, where a lost
message would cost a second: `reliable_sensors` says which.

The pitch is the gyro's rate, integrated, and drawn towards the slope of the path; the depth is the pressure's, its rate a filtered
difference. An estimate is published once both instruments of one stamp have come, in any order, and bears that stamp: so it does
not depend on which message is faster. A stamp that comes again is answered again with the same estimate.
"""

import sys

import rclpy
from planesman_msgs.msg import MotionEstimate
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import QoSProfile, qos_profile_sensor_data
from sensor_msgs.msg import FluidPressure, Imu

SURFACE = 101_325.0
"""Pa."""
WEIGHT = 999.835 * 9.81456
"""Pa/m, of fresh water."""
TIME_CONSTANT = 0.5
"""s, of the depth rate's filter."""
PULL = 0.1
"""1/s, of the pitch towards the path's slope."""


class OwnEstimator(Node):
    def __init__(self):
        super().__init__("own_estimator")
        self.declare_parameter("tick", 0.05)  # s
        self.declare_parameter("speed", 0.3048)  # m/s
        reliable = self.declare_parameter("reliable_sensors", False).value  # as plant_sim offers them
        sensors = QoSProfile(depth=10) if reliable else qos_profile_sensor_data
        self.rates, self.depths = {}, {}
        self.last = MotionEstimate(source=MotionEstimate.SOURCE_INTEGRATOR, depth_measured=True)
        self.is_first = True
        self.estimate = self.create_publisher(MotionEstimate, "estimate", 10)
        self.create_subscription(Imu, "imu", self.on_imu, sensors)
        self.create_subscription(FluidPressure, "depth_pressure", self.on_pressure, sensors)

    def on_imu(self, imu: Imu) -> None:
        # In base_link (forward, left, up) a turn about y is bow down.
        self.rates[time_of(imu)] = -imu.angular_velocity.y
        self.answer(imu)

    def on_pressure(self, pressure: FluidPressure) -> None:
        self.depths[time_of(pressure)] = (pressure.fluid_pressure - SURFACE) / WEIGHT
        self.answer(pressure)

    def answer(self, message) -> None:
        stamp = time_of(message)
        if stamp not in self.rates or stamp not in self.depths:
            return
        rate, depth = self.rates.pop(stamp), self.depths.pop(stamp)
        last = self.last
        if self.is_first or time_of(last) < stamp:
            tick = self.get_parameter("tick").value
            slope = -last.depth_rate / self.get_parameter("speed").value
            if not self.is_first:
                last.depth_rate += tick / TIME_CONSTANT * ((depth - last.depth) / tick - last.depth_rate)
                last.pitch += tick * (rate + PULL * (slope - last.pitch))
            last.depth, last.pitch_rate = depth, rate
            last.header.stamp = message.header.stamp
            last.header.frame_id = "map_ned"
            self.is_first = False
        self.estimate.publish(last)


def time_of(message) -> tuple[int, int]:
    return message.header.stamp.sec, message.header.stamp.nanosec


def main() -> int:
    rclpy.init(args=sys.argv)
    executor = SingleThreadedExecutor()
    executor.add_node(OwnEstimator())
    try:
        while rclpy.ok():
            executor.spin_once(timeout_sec=1.0)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    return 0


if __name__ == "__main__":
    sys.exit(main())
