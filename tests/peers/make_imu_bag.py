#!/usr/bin/env python3
"""Writes a rosbag2 bag with `rosbags`, of messages that are not this project's, and fits a model to it with numpy.

    make_imu_bag.py BAG {none|lz4|zstd} {csv|bag}

The bag holds sensor_msgs/Imu on /imu (100 Hz, a period of five parts in a thousand, its stamps shaken by 1 ms) and
std_msgs/Float64 on /cmd (25 Hz), in three files. Between them is a second-order response with noise, and a gap.

Prints as JSON the least-squares fit of `angular_velocity.y` to the command by numpy, on the samples that linear
interpolation (of the one) and the mean over each interval (of the other) give on a grid of 20 Hz, as well as
pitch angles of the first messages by scipy's convention.
"""

import argparse
import json
import math
import shutil
from pathlib import Path

import numpy
from mcap.writer import CompressionType, Writer
from rosbags.rosbag2 import Reader
from rosbags.typesys import Stores, get_typestore

RATE = 20.0
START = 1_700_000_000_000_000_000
GAP = (31.0, 33.5)
STORE = get_typestore(Stores.ROS2_JAZZY)


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("bag", type=Path)
    parser.add_argument("compression", choices=["none", "lz4", "zstd"])
    arguments = parser.parse_args()
    random = numpy.random.default_rng(1988)
    command = commands(random)
    response = responses(command, random)
    write(arguments.bag, arguments.compression, command, response)
    print(json.dumps(fit(command, response)))


if __name__ == "__main__":
    main()
