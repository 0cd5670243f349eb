#!/usr/bin/env python3
"""Writes a split rosbag2 bag with `rosbags`, of messages that are not this project's, and fits models to it with numpy.

    make_imu_bag.py BAG none|lz4|zstd

The bag, in three files, holds sensor_msgs/Imu on /imu (about 100 Hz; stamps shaken by up to 2 ms; nothing for two
seconds and a half) and std_msgs/Float64 on /cmd (about 25 Hz). The second file's payloads are big endian. A
second-order system with noise answers the command, as `angular_velocity.y` and, half of it, as pitch in a
quaternion that also yaws.

Prints as JSON what numpy's least squares finds for each, `[a1, a2, b1, b2]`, on the samples that linear
interpolation (of the answer) and the mean over each interval (of the command, held from sample to sample) give on a
grid of 20 Hz from the first Imu message, in two segments: before the pause and after.
"""

import argparse
import json
from pathlib import Path

import lz4.frame
import numpy
from numpy.typing import NDArray
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore
from ruamel.yaml import YAML

Numbers = NDArray[numpy.float64]

RATE = 20.0
START = 1_700_000_000_000_000_000
"""Of the Imu messages, ns; commands begin a second before and end a second after."""
LENGTH = 90.0
PAUSE = (31.0, 33.5)
STORE = get_typestore(Stores.ROS2_JAZZY)
IMU = STORE.types["sensor_msgs/msg/Imu"]
FLOAT = STORE.types["std_msgs/msg/Float64"]
HEADER = STORE.types["std_msgs/msg/Header"]
TIME = STORE.types["builtin_interfaces/msg/Time"]
VECTOR = STORE.types["geometry_msgs/msg/Vector3"]
QUATERNION = STORE.types["geometry_msgs/msg/Quaternion"]


def stamps(random: numpy.random.Generator, begin: float, end: float, period: float) -> NDArray[numpy.int64]:
    """Instants from START, ns, that follow `period` but for a shake."""
    regular = numpy.arange(begin, end, period)
    shaken = regular + random.uniform(-0.002, 0.002, regular.size)
    return numpy.round(shaken * 1e9).astype(numpy.int64)


def answer(times: NDArray[numpy.int64], commands: Numbers, at: NDArray[numpy.int64]) -> Numbers:
    """x'' = 4 (u - x) - 1.6 x', u held from command to command, in steps of a millisecond."""
    step = 1_000_000
    fine = numpy.arange(times[0], at[-1] + step, step)
    held = commands[numpy.searchsorted(times, fine, side="right") - 1]
    course = numpy.zeros(fine.size)
    x = v = 0.0
    for k, u in enumerate(held):
        course[k] = x
        v += 1e-3 * (4.0 * (u - x) - 1.6 * v)
        x += 1e-3 * v
    return numpy.interp(at, fine, course)


def imu(stamp: int, rate: float, pitch: float) -> object:
    yaw = 0.3
    orientation = QUATERNION(
        x=-numpy.sin(pitch / 2) * numpy.sin(yaw / 2),
        y=numpy.sin(pitch / 2) * numpy.cos(yaw / 2),
        z=numpy.cos(pitch / 2) * numpy.sin(yaw / 2),
        w=numpy.cos(pitch / 2) * numpy.cos(yaw / 2),
    )
    covariance = numpy.zeros(9)
    return IMU(
        header=HEADER(stamp=TIME(sec=stamp // 10**9, nanosec=stamp % 10**9), frame_id="imu"),
        orientation=orientation,
        orientation_covariance=covariance,
        angular_velocity=VECTOR(x=0.0, y=rate, z=0.0),
        angular_velocity_covariance=covariance,
        linear_acceleration=VECTOR(x=0.0, y=0.0, z=9.81),
        linear_acceleration_covariance=covariance,
    )


def write(folder: Path, compression: str, messages: list[tuple[int, str, object]]) -> None:
    """Three bags' files and accounts become those of one, as a recorder that splits leaves them."""
    yaml = YAML(typ="safe")
    parts = []
    third = len(messages) // 3 + 1
    for number in range(3):
        part = folder.parent / f"{folder.name}_{number}"
        writer = Writer(part, version=9, storage_plugin=StoragePlugin.MCAP)
        if compression == "zstd":
            writer.set_compression(CompressionMode.STORAGE, CompressionFormat.ZSTD)
        with writer:
            if compression == "lz4":
                writer.storage.compression = "lz4"
                writer.storage.compressor = lz4.frame.compress
            topics = {
                "/imu": writer.add_connection("/imu", IMU.__msgtype__, typestore=STORE),
                "/cmd": writer.add_connection("/cmd", FLOAT.__msgtype__, typestore=STORE),
            }
            for stamp, topic, message in messages[number * third : (number + 1) * third]:
                kind = topics[topic].msgtype
                payload = STORE.serialize_cdr(message, kind, little_endian=number != 1)
                writer.write(topics[topic], stamp, payload)
        account = yaml.load(part / "metadata.yaml")["rosbag2_bagfile_information"]
        folder.mkdir(exist_ok=True)
        (part / f"{part.name}.mcap").rename(folder / f"{part.name}.mcap")
        parts.append(account)
    whole = parts[0]
    for account in parts[1:]:
        whole["message_count"] += account["message_count"]
        whole["relative_file_paths"] += account["relative_file_paths"]
        whole["files"] += account["files"]
        pairs = zip(whole["topics_with_message_count"], account["topics_with_message_count"], strict=True)
        for ours, theirs in pairs:
            ours["message_count"] += theirs["message_count"]
    yaml.dump({"rosbag2_bagfile_information": whole}, folder / "metadata.yaml")


def fit(
    commanded: NDArray[numpy.int64], commands: Numbers, measured: NDArray[numpy.int64], values: Numbers
) -> list[float]:
    """Least squares of y_k = -a1 y_(k-1) - a2 y_(k-2) + b1 u_(k-1) + b2 u_(k-2)."""
    times = (commanded - measured[0]) * 1e-9
    integral = numpy.concatenate([[0.0], numpy.cumsum(commands[:-1] * numpy.diff(times))])
    rows, outputs = [], []
    pause = numpy.argmax(numpy.diff(measured)) + 1
    for begin, end in [(0, pause), (pause, measured.size)]:
        part = (measured[begin:end] - measured[0]) * 1e-9
        grid = numpy.arange(numpy.ceil(part[0] * RATE), numpy.floor(part[-1] * RATE) + 1) / RATE
        y = numpy.interp(grid, part, values[begin:end])
        edges = numpy.append(grid, grid[-1] + 1 / RATE)
        u = numpy.diff(numpy.interp(edges, times, integral)) * RATE
        rows.append(numpy.column_stack([-y[1:-1], -y[:-2], u[1:-1], u[:-2]]))
        outputs.append(y[2:])
    theta, *_ = numpy.linalg.lstsq(numpy.concatenate(rows), numpy.concatenate(outputs), rcond=None)
    return theta.tolist()


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("bag", type=Path)
    parser.add_argument("compression", choices=["none", "lz4", "zstd"])
    arguments = parser.parse_args()
    random = numpy.random.default_rng(1988)

    commanded = stamps(random, -1.0, LENGTH + 1.0, 0.04)
    commands = numpy.repeat(random.choice([-0.2, 0.0, 0.3], commanded.size // 20 + 1), 20)[: commanded.size]
    measured = stamps(random, 0.0, LENGTH, 0.01)
    seconds = measured * 1e-9
    measured = measured[(seconds < PAUSE[0]) | (seconds > PAUSE[1])]
    rates = answer(commanded, commands, measured) + random.normal(0.0, 0.002, measured.size)
    pitches = 0.5 * rates

    messages = [(START + int(t), "/cmd", FLOAT(data=float(u))) for t, u in zip(commanded, commands, strict=True)]
    messages += [
        (START + int(t), "/imu", imu(START + int(t) - 3_000_000, float(rate), float(pitch)))
        for t, rate, pitch in zip(measured, rates, pitches, strict=True)
    ]
    messages.sort(key=lambda message: message[0])
    write(arguments.bag, arguments.compression, messages)
    found = {
        "messages": {"/imu": measured.size, "/cmd": commanded.size},
        "angular_velocity.y": fit(commanded, commands, measured, rates),
        "orientation.pitch": fit(commanded, commands, measured, pitches),
    }
    print(json.dumps(found))


if __name__ == "__main__":
    main()
