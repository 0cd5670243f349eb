#!/usr/bin/env python3
"""Fits a model to a bag of a gigabyte: `sysid fit` beside `rosbags` + numpy and `mcap` + numpy, in one run.

    gigabyte.py [--megabytes 1000] [--compression none]

The bag holds sensor_msgs/Imu at 100 Hz and std_msgs/Float64 at 25 Hz. Each contender is a process of its own that
reads the two signals, puts them on a grid of 20 Hz (interpolation; mean over each interval) and fits a second-order
model by least squares. Told are wall time, the largest resident memory, and the coefficients, which must agree.
Build the program first: `cargo build --release`.
"""

import argparse
import json
import struct
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy

RATE = 20.0
ROOT = Path(__file__).resolve().parents[3]


def generate(path: Path, size: int, compression: str) -> int:
    """Writes the bag; returns its messages. Payloads are made once and their numbers put in."""
    from mcap.writer import CompressionType, Writer
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_JAZZY)
    imu, number = store.types["sensor_msgs/msg/Imu"], store.types["std_msgs/msg/Float64"]
    time_, header = store.types["builtin_interfaces/msg/Time"], store.types["std_msgs/msg/Header"]
    vector, quaternion = store.types["geometry_msgs/msg/Vector3"], store.types["geometry_msgs/msg/Quaternion"]
    random = numpy.random.default_rng(1988)
    covariance = random.normal(size=9)
    mark = 123456.789

    def message(sec: int) -> bytearray:
        filled = imu(
            header=header(stamp=time_(sec=sec, nanosec=0), frame_id="imu_link"),
            orientation=quaternion(x=0.1, y=0.2, z=0.3, w=0.9),
            orientation_covariance=covariance,
            angular_velocity=vector(x=0.01, y=mark, z=0.02),
            angular_velocity_covariance=covariance,
            linear_acceleration=vector(x=0.1, y=0.2, z=9.81),
            linear_acceleration_covariance=covariance,
        )
        return bytearray(store.serialize_cdr(filled, imu.__msgtype__))

    payload = message(1)
    place = payload.index(struct.pack("<d", mark))
    command = bytearray(store.serialize_cdr(number(data=mark), number.__msgtype__))
    count = int(size / (len(payload) + 31))
    x = v = u = 0.0
    noise = random.normal(0.0, 0.002, count)
    with path.open("wb") as file:
        writer = Writer(file, chunk_size=1 << 20, compression=CompressionType[compression.upper()])
        writer.start(profile="ros2")
        channels = {}
        for topic, kind in [("/imu", imu), ("/cmd", number)]:
            text, _ = store.generate_msgdef(kind.__msgtype__, ros_version=2)
            schema = writer.register_schema(kind.__msgtype__, "ros2msg", text.encode())
            channels[topic] = writer.register_channel(topic, "cdr", schema)
        for k in range(count):
            stamp = 1_700_000_000_000_000_000 + k * 10_000_000
            if k % 4 == 0:
                if k % 80 == 0:
                    u = float(random.choice([-0.2, 0.0, 0.3]))
                struct.pack_into("<d", command, 4, u)
                writer.add_message(channels["/cmd"], stamp, bytes(command), stamp)
            v += 0.01 * (4.0 * (u - x) - 1.6 * v)
            x += 0.01 * v
            struct.pack_into("<iI", payload, 4, stamp // 10**9, stamp % 10**9)
            struct.pack_into("<d", payload, place, x + noise[k])
            writer.add_message(channels["/imu"], stamp, bytes(payload), stamp)
        writer.finish()
    return count + (count + 3) // 4


def least_squares(ut: list[int], u: list[float], yt: list[int], y: list[float]) -> list[float]:
    begin = yt[0]
    times = (numpy.array(ut) - begin) * 1e-9
    seconds = (numpy.array(yt) - begin) * 1e-9
    integral = numpy.concatenate([[0.0], numpy.cumsum(numpy.array(u)[:-1] * numpy.diff(times))])
    grid = numpy.arange(0, numpy.floor(min(seconds[-1], times[-1]) * RATE) + 1) / RATE
    outputs = numpy.interp(grid, seconds, y)
    inputs = numpy.diff(numpy.interp(numpy.append(grid, grid[-1] + 1 / RATE), times, integral)) * RATE
    rows = numpy.column_stack([-outputs[1:-1], -outputs[:-2], inputs[1:-1], inputs[:-2]])
    theta, *_ = numpy.linalg.lstsq(rows, outputs[2:], rcond=None)
    return theta.tolist()


def with_rosbags(path: Path) -> list[float]:
    from rosbags.highlevel import AnyReader

    ut, u, yt, y = [], [], [], []
    with AnyReader([path]) as reader:
        for connection, stamp, payload in reader.messages():
            message = reader.deserialize(payload, connection.msgtype)
            if connection.topic == "/imu":
                yt.append(stamp)
                y.append(message.angular_velocity.y)
            else:
                ut.append(stamp)
                u.append(message.data)
    return least_squares(ut, u, yt, y)


def with_mcap(path: Path) -> list[float]:
    from mcap.reader import make_reader
    from mcap_ros2.decoder import DecoderFactory

    ut, u, yt, y = [], [], [], []
    with path.open("rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        for _, channel, raw, message in reader.iter_decoded_messages():
            if channel.topic == "/imu":
                yt.append(raw.log_time)
                y.append(message.angular_velocity.y)
            else:
                ut.append(raw.log_time)
                u.append(message.data)
    return least_squares(ut, u, yt, y)


def measure(command: list[str]) -> tuple[float, float, str]:
    """Wall time in s, peak resident memory in MB, output."""
    with tempfile.TemporaryFile("w+") as output:
        begin = time.perf_counter()
        child = subprocess.Popen(command, stdout=output, text=True)
        # The kernel's account at the end would count this process's own memory, of before the child became its program.
        peak = 0
        status = Path(f"/proc/{child.pid}/status")
        while child.poll() is None:
            lines = status.read_text().splitlines()
            peak = max([peak, *(int(line.split()[1]) for line in lines if line.startswith("VmHWM"))])
            time.sleep(0.01)
        elapsed = time.perf_counter() - begin
        if child.returncode != 0:
            sys.exit(f"{command} failed")
        output.seek(0)
        return elapsed, peak / 1000, output.read()


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--megabytes", type=int, default=1000)
    parser.add_argument("--compression", choices=["none", "lz4", "zstd"], default="none")
    parser.add_argument("--peer", choices=["rosbags", "mcap"], help=argparse.SUPPRESS)
    parser.add_argument("--bag", type=Path, help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.peer:
        print(json.dumps({"rosbags": with_rosbags, "mcap": with_mcap}[arguments.peer](arguments.bag)))
        return
    with tempfile.TemporaryDirectory() as folder:
        bag = Path(folder) / "gigabyte.mcap"
        messages = generate(bag, arguments.megabytes * 1_000_000, arguments.compression)
        size = bag.stat().st_size / 1e6
        print(f"{messages} messages, {size:.0f} MB as {arguments.compression}, {arguments.megabytes} MB unpacked")
        program = str(ROOT / "target/release/planesman")
        fit = [program, "sysid", "fit", str(bag), "--input", "/cmd:data", "--output", "/imu:angular_velocity.y"]
        fit += ["--rate", str(RATE), "--stamp", "log", "--json", "--quiet"]
        fit += ["--method", "least_squares", "--order", "2", "--no-offset"]
        peer = [sys.executable, __file__, "--bag", str(bag), "--peer"]
        times = {}
        # What else the machine does changes within minutes: ours is measured on both sides of the others.
        for name, command in [
            ("sysid fit", fit),
            ("sysid topics", [program, "sysid", "topics", str(bag), "--quiet"]),
            ("rosbags + numpy", [*peer, "rosbags"]),
            ("sysid fit, again", fit),
            ("mcap + numpy", [*peer, "mcap"]),
            ("sysid fit, at last", fit),
        ]:
            seconds, memory, output = measure(command)
            times[name] = seconds
            found = ""
            if "fit" in name:
                model = json.loads(output)["model"]
                found = model["den"][1:] + model["num"]
            elif "numpy" in name:
                found = json.loads(output)
            rate = arguments.megabytes / seconds
            print(f"{name:18} {seconds:8.2f} s {rate:8.1f} MB/s {memory:6.0f} MB resident  {found}", flush=True)
        ours = [seconds for name, seconds in times.items() if "fit" in name]
        for name, seconds in times.items():
            if "numpy" in name:
                print(f"{name} takes {seconds / max(ours):.0f} to {seconds / min(ours):.0f} times as long as sysid fit")


if __name__ == "__main__":
    main()
