"""What was measured on, and which versions."""

import datetime
import os
import platform
import re
import subprocess
from importlib import metadata
from pathlib import Path

import tools

PEERS = ["scipy", "control", "padasip", "sippy_unipi", "sysidentpy", "rosbags", "mcap", "mcap-ros2-support", "numpy"]


def first_line(*command: str) -> str:
    try:
        done = subprocess.run(command, cwd=tools.ROOT, capture_output=True, text=True)
    except FileNotFoundError:
        return "not there"
    return done.stdout.splitlines()[0] if done.stdout else "unknown"


def machine() -> dict[str, str]:
    model = re.search(r"model name\s*: (.*)", Path("/proc/cpuinfo").read_text())
    megabytes = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") / 1e6
    return {
        "machine": f"{model[1] if model else platform.machine()}, {len(os.sched_getaffinity(0))} cores, {megabytes / 1000:.0f} GB",
        "kernel": f"{platform.system()} {platform.release()}",
        "date": datetime.datetime.now(datetime.UTC).strftime("%Y-%m-%d %H:%M UTC"),
        "load average before": " ".join(f"{load:.1f}" for load in os.getloadavg()),
    }


def versions() -> dict[str, str]:
    own = [":!benches/peers/results.*", ":!benches/peers/plots"]
    changed = first_line("git", "status", "--porcelain", "--untracked-files=no", "--", ".", *own) != "unknown"
    commit = first_line("git", "rev-parse", "--short=10", "HEAD")
    cyclone = first_line("dpkg-query", "--show", "--showformat=${Version}\n", "cyclonedds-tools")
    rclpy = [path.name.split("-")[1].removesuffix(".dist") for path in (tools.ROOT / ".ros/lib").glob("python*/site-packages/ros_jazzy_rclpy-*.dist-info")]
    peers = {name: metadata.version(name) for name in PEERS}
    return {
        "planesman": commit + (", with changes" if changed else ""),
        "compilers": f"{first_line('rustc', '--version')}; {first_line('g++', '--version')}",
        "peers": ", ".join(f"{name} {version}" for name, version in peers.items())
        + f", Cyclone DDS {cyclone}, rclpy {rclpy[0] if rclpy else 'not there'}, Python {platform.python_version()}",
    }
