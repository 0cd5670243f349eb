#!/usr/bin/env python3
"""Finds the way of a recorded vehicle by its sensors alone, and says how far from `odom` it ends and how far the covariances let it.

    dead_reckoning.py BAG.mcap

Position: the Doppler log's velocity, turned by the orientation of `imu` and integrated by trapezoids, from the first true position on. Depth:
`depth_pressure` in fresh water of 999.835 kg/m^3 at 9.81456 m/s^2. The covariance of the position is propagated from those of the messages, to
first order. `odom`, `map` and east, north, up have to be the same axes. Also the squares of the sensors' errors against `odom`, each by its own covariance,
averaged: about 1.

Prints one JSON object.
"""

import json
import sys

import numpy
from mcap_ros2.reader import read_ros2_messages
from numpy.typing import NDArray

Numbers = NDArray[numpy.float64]


def nanoseconds(message) -> int:  # type: ignore[no-untyped-def]
    return int(message.header.stamp.sec) * 1_000_000_000 + int(message.header.stamp.nanosec)


def xyz(vector) -> Numbers:  # type: ignore[no-untyped-def]
    return numpy.array([vector.x, vector.y, vector.z])


def rotation(q) -> Numbers:  # type: ignore[no-untyped-def]
    """The matrix of a quaternion message."""
    x, y, z, w = q.x, q.y, q.z, q.w
    return numpy.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )


def cross(v: Numbers) -> Numbers:
    return numpy.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])


def by_stamp(topic: str) -> dict:  # type: ignore[type-arg]
    found = read_ros2_messages(sys.argv[1], topics=[f"/auv/{topic}"])
    return {nanoseconds(it.ros_msg): it.ros_msg for it in found}


odom, imu, dvl, usbl = by_stamp("odom"), by_stamp("imu"), by_stamp("dvl"), by_stamp("usbl")
pressure = by_stamp("depth_pressure")

# Of each measurement of the log the velocity east, north, up, and its covariance.
stamps = sorted(dvl)
velocities, covariances = [], []
velocity_errors = []
for stamp in stamps:
    turned = rotation(imu[stamp].orientation)
    twist = dvl[stamp].twist
    velocity = turned @ xyz(twist.twist.linear)
    of_log = numpy.reshape(twist.covariance, (6, 6))[:3, :3]
    of_attitude = numpy.reshape(imu[stamp].orientation_covariance, (3, 3))
    lever = cross(velocity)
    velocities.append(velocity)
    covariances.append(turned @ of_log @ turned.T + lever @ of_attitude @ lever.T)
    error = xyz(twist.twist.linear) - xyz(odom[stamp].twist.twist.linear)
    velocity_errors.append(error * error / numpy.diag(of_log))

start = xyz(odom[stamps[0]].pose.pose.position)
position, settled = start.copy(), numpy.zeros((3, 3))
half = 0.0
largest = 0.0
for k in range(1, len(stamps)):
    step = (stamps[k] - stamps[k - 1]) * 1e-9
    position = position + 0.5 * step * (velocities[k - 1] + velocities[k])
    # A measurement counts for half of the steps on both its sides.
    settled = settled + ((half + 0.5 * step) ** 2) * covariances[k - 1]
    half = 0.5 * step
    covariance = settled + half * half * covariances[k]
    error = position - xyz(odom[stamps[k]].pose.pose.position)
    largest = max(largest, float(numpy.max(numpy.abs(error) / numpy.sqrt(numpy.diag(covariance)))))
end = xyz(odom[stamps[-1]].pose.pose.position)

weight = 999.835 * 9.81456
depths = [
    (
        ((it.fluid_pressure - 101_325.0) / weight + odom[stamp].pose.pose.position.z) / (it.variance**0.5 / weight)
    )
    ** 2
    for stamp, it in pressure.items()
]
fixes = [
    (xyz(it.pose.pose.position) - xyz(odom[stamp].pose.pose.position)) ** 2 / it.pose.covariance[0]
    for stamp, it in usbl.items()
]
print(
    json.dumps(
        {
            "way": float(sum(numpy.linalg.norm(v) for v in velocities) * (stamps[-1] - stamps[0]) * 1e-9 / len(stamps)),
            "end": list(end),
            "error": list(position - end),
            "deviation": list(numpy.sqrt(numpy.diag(covariance))),
            "normalised": float((position - end) @ numpy.linalg.solve(covariance, position - end)),
            "largest": largest,
            "dvl": [float(numpy.mean(velocity_errors)), 3 * len(stamps)],
            "depth": [float(numpy.mean(depths)), len(depths)],
            "usbl": [float(numpy.mean(fixes)), 3 * len(fixes)],
        }
    )
)
