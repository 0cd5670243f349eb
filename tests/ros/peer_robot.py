#!/usr/bin/env python3
"""A robot of another make, in rclpy: `fins` (std_msgs/Float64, rad) drive the pitch rate in `imu` (sensor_msgs/Imu).

    peer_robot.py --domain 0 --timeout 60

y[k] = 1.6 y[k-1] - 0.68 y[k-2] + 0.05 u[k-1] every 50 ms, u a square wave of random length. Ends after --timeout seconds, or
when it is killed.
"""

import random
import sys

import ros
import arguments
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import Imu
from std_msgs.msg import Float64

TICK = 0.05
"""s"""


def main() -> int:
    args = arguments.parser(__doc__, timeout=60.0).parse_args()
    chance = random.Random(1988)
    y, before, u = 0.0, 0.0, 0.1

    with ros.node(args.domain) as node:
        fins = node.create_publisher(Float64, "/fins", 10)
        imu = node.create_publisher(Imu, "/imu", qos_profile_sensor_data)

        def tick() -> None:
            nonlocal y, before, u
            said = Imu()
            said.header.stamp = node.get_clock().now().to_msg()
            said.angular_velocity.y = y
            imu.publish(said)
            if chance.random() < 0.1:
                u = -u
            fins.publish(Float64(data=u))
            y, before = 1.6 * y - 0.68 * before + 0.05 * u, y

        node.create_timer(TICK, tick)
        ros.spin_until(node, lambda: False, args.timeout)
    return 0


if __name__ == "__main__":
    sys.exit(main())
