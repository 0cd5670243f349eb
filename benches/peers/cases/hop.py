"""A message of 100 bytes from process to process over DDS, beside Cyclone DDS and rclpy on Fast DDS."""

import itertools
import json
import os
import re
import subprocess
from statistics import median

from tools import HERE, Missing, OPTIONS, ROOT, cpu, output, program, running

TITLE = "DDS hop, 100 bytes"
RATE = 1000
NOTE = (
    "two processes on loopback, reliable. The latency is half a round trip. CPU is of both processes by the scheduler's account, of a publisher with 1000 messages a second. "
    "Cyclone's are `ddsperf` in C, which has no parameters, log or diagnostics; ours has those of every node, rclpy's those of its node."
)
ROUNDS = 4
DOMAINS = itertools.count(1)


def contenders():
    rclpy = [ROOT / ".ros/bin/python", HERE / "rclpy_hop.py"]
    return {
        "planesman": lambda: measure([program("hop")]),
        "Cyclone DDS": cyclone,
        "rclpy on Fast DDS": lambda: measure(rclpy),
    }


def duration() -> int:
    return 1 if OPTIONS["quick"] else 3


def environment() -> dict[str, str]:
    return {**os.environ, "ROS_DOMAIN_ID": str(next(DOMAINS)), "RMW_IMPLEMENTATION": "rmw_fastrtps_cpp"}


def costs(middle: float, late: float, each: float) -> dict[str, float]:
    return {"latency, median [us]": middle, "latency, 99 % [us]": late, f"CPU a message, at {RATE} Hz [us]": each}


def measure(command: list) -> dict[str, float]:
    """Of a program with the commands `ping SECONDS`, `pong`, `pub RATE` and `sub`."""
    if not os.path.exists(command[0]):
        raise Missing(f"there is no {command[0]}; tests/ros/install.sh makes it")
    where = environment()
    with running([*command, "pong"], env=where):
        found = json.loads(output([*command, "ping", duration()], env=where, timeout=60).splitlines()[-1])
    return costs(found["median"], found["p99"], cpu_a_message([*command, "pub", RATE], [*command, "sub"], environment()))


def cyclone() -> dict[str, float]:
    domain = next(DOMAINS)
    # Line by line, though it is no terminal.
    ddsperf = ["stdbuf", "--output=L", "ddsperf", "-i", domain]
    with running([*ddsperf, "pong"]):
        text = output([*ddsperf, "-D", duration() + 2, "ping", "size", 100], timeout=60)
    # The first line has the start in it.
    lines = re.findall(r" 50% ([\d.]+)us .* 99% ([\d.]+)us", text)[1:]
    if not lines:
        raise Missing(f"ddsperf printed no latency: {text.strip()[-200:]}")
    middle, late = (median(float(line[i]) for line in lines) for i in (0, 1))
    ddsperf[-1] = next(DOMAINS)
    return costs(middle, late, cpu_a_message([*ddsperf, "pub", f"{RATE}Hz", "size", 100], [*ddsperf, "sub"], os.environ))


def cpu_a_message(publisher: list, subscriber: list, where) -> float:
    """CPU of both processes over the messages received [us], from the subscriber's second line with messages on."""
    with running(subscriber, env=where, stdout=subprocess.PIPE) as sub, running(publisher, env=where) as pub:
        account = []
        while len(account) < 2 + duration():
            line = sub.stdout.readline()
            if not line:
                raise Missing(f"{subscriber[0]} sub ended")
            total = re.search(r"total (\d+)", line)
            if total and int(total[1]) > 0:
                account.append((int(total[1]), cpu(sub.pid) + cpu(pub.pid)))
    (first, before), (last, after) = account[1], account[-1]
    # rclpy does not reach the rate on a loaded machine.
    if last - first < 0.25 * RATE * duration():
        raise Missing(f"only {last - first} messages arrived in {duration()} s")
    return (after - before) / (last - first) * 1e6
