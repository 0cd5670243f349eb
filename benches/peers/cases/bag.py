"""A model out of a bag beside `rosbags` and `mcap`, each with numpy.

The bag holds sensor_msgs/Imu at 100 Hz and std_msgs/Float64 at 25 Hz, not compressed. Each contender is a process of its own that
reads the two signals, puts them on a grid of 20 Hz (interpolation; mean over each interval) and fits a second-order
model by least squares. The coefficients must agree.
"""

import json
import struct
import subprocess
import sys
import tempfile
import time
from functools import cache
from pathlib import Path

import numpy

sys.path.append(str(Path(__file__).resolve().parents[1]))
from tools import Missing, OPTIONS, program  # noqa: E402

TITLE = "Model out of a bag"
NOTE = "100 MB, or what `--megabytes` says, of Imu and Float64 messages in an MCAP bag without compression; two fields are read, resampled to 20 Hz and fitted."
ROUNDS = 3
RATE = 20.0
FOLDERS, FOUND = [], []


def generate(path: Path, size: int) -> None:
    """Writes the bag. Payloads are made once and their numbers put in."""
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
        writer = Writer(file, chunk_size=1 << 20, compression=CompressionType.NONE)
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


@cache
def bag() -> Path:
    """Made once; the folder goes with the process."""
    folder = tempfile.TemporaryDirectory()
    FOLDERS.append(folder)
    path = Path(folder.name) / "large.mcap"
    generate(path, OPTIONS["megabytes"] * 1_000_000)
    return path


def contenders():
    bag()
    peer = [sys.executable, __file__]
    return {
        "planesman": ours,
        "rosbags": lambda: read([*peer, "rosbags", bag()]),
        "mcap": lambda: read([*peer, "mcap", bag()]),
    }


def ours() -> dict[str, float]:
    fit = [program("planesman"), "sysid", "fit", bag(), "--input", "/cmd:data", "--output", "/imu:angular_velocity.y"]
    fit += ["--rate", RATE, "--stamp", "log", "--json", "--quiet", "--method", "least_squares", "--order", 2, "--no-offset"]
    return read(fit)


def read(command: list) -> dict[str, float]:
    """Wall time [s] and peak resident memory [MB] of a process that prints the model."""
    with tempfile.TemporaryFile("w+") as output:
        begin = time.perf_counter()
        child = subprocess.Popen([str(part) for part in command], stdout=output, text=True)
        # The kernel's account at the end would count this process's own memory, of before the child became its program.
        peak = 0
        status = Path(f"/proc/{child.pid}/status")
        try:
            while child.poll() is None:
                lines = status.read_text().splitlines()
                peak = max([peak, *(int(line.split()[1]) for line in lines if line.startswith("VmHWM"))])
                time.sleep(0.01)
        finally:
            child.kill()
        elapsed = time.perf_counter() - begin
        output.seek(0)
        if child.returncode != 0:
            raise Missing(f"{command[0]} ended with {child.returncode}")
        found = json.loads(output.read())
    coefficients = found["model"]["den"][1:] + found["model"]["num"] if "model" in found else found["coefficients"]
    FOUND.append(coefficients)
    if not numpy.allclose(coefficients, FOUND[0], rtol=0, atol=1e-8):
        raise Missing(f"{coefficients} are not the coefficients that another contender found: {FOUND[0]}")
    return {"time [s]": elapsed, "peak memory [MB]": peak / 1000}


if __name__ == "__main__":
    print(json.dumps({"coefficients": {"rosbags": with_rosbags, "mcap": with_mcap}[sys.argv[1]](Path(sys.argv[2]))}))
