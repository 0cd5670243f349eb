"""What the cases share: options, programs, the cost of processes."""

import json
import math
import os
import re
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
OPTIONS: dict = {"quick": False, "programs": {}}
"""As `run` gives them."""

SECONDS = {"ns": 1e-9, "us": 1e-6, "ms": 1e-3, "s": 1.0}


class Missing(Exception):
    """A peer is not there, or a program did not print what it should have."""


def set_options(text: str) -> dict:
    OPTIONS.update(json.loads(text))
    return OPTIONS


def program(name: str) -> str:
    """The path of a program that `run` has built."""
    return OPTIONS["programs"][name]


def best(work: Callable[[], object], repetitions: int, clock: Callable[[], float] = time.perf_counter) -> float:
    """The shortest time of so many calls [s]: other load only adds time."""
    shortest = math.inf
    for _ in range(repetitions):
        start = clock()
        work()
        shortest = min(shortest, clock() - start)
    return shortest


def output(command: list, **options) -> str:
    """What a command prints. Its complaint is the error when it fails."""
    done = subprocess.run([str(part) for part in command], capture_output=True, text=True, **options)
    if done.returncode != 0:
        lines = (done.stderr.strip() or done.stdout.strip()).splitlines()
        raise Missing(f"{Path(command[0]).name} ended with {done.returncode}: {lines[-1] if lines else 'no word'}")
    return done.stdout


def timed(command: list, **options) -> float:
    """The wall time of a command [s]."""
    start = time.perf_counter()
    output(command, **options)
    return time.perf_counter() - start


def seconds(pattern: str, text: str) -> float:
    """The time behind `pattern` and a colon in `text`, a number with its unit [s]."""
    found = re.search(rf"{pattern}: ([\d.]+) (ns|us|ms|s)\b", text)
    if not found:
        raise Missing(f"no time for '{pattern}' was printed")
    return float(found[1]) * SECONDS[found[2]]


@contextmanager
def running(command: list, **options) -> Iterator[subprocess.Popen]:
    """A process that ends with the block; what it prints is dropped unless `stdout` says otherwise."""
    options = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL, **options}
    process = subprocess.Popen([str(part) for part in command], text=True, **options)
    try:
        yield process
    finally:
        process.terminate()
        try:
            process.wait(10)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
        if process.stdout:
            process.stdout.close()


def cpu(pid: int) -> float:
    """The CPU time of a process's threads so far by the scheduler's account [s], which counts nanoseconds and not ticks of 10 ms."""
    total = 0
    try:
        for task in os.listdir(f"/proc/{pid}/task"):
            total += int(Path(f"/proc/{pid}/task/{task}/schedstat").read_text().split()[0])
    except (FileNotFoundError, ProcessLookupError):
        pass  # It has just ended.
    return total * 1e-9


def memory(pid: int) -> float:
    """The resident memory of a process [MB], what it shares with others counted in shares."""
    try:
        text = Path(f"/proc/{pid}/smaps_rollup").read_text()
    except (FileNotFoundError, ProcessLookupError, PermissionError):
        return 0.0
    found = re.search(r"^Pss: +(\d+) kB", text, re.MULTILINE)
    return int(found[1]) * 1.024e-3 if found else 0.0


BEGAN = time.monotonic()


def say(text: str) -> None:
    print(f"[{time.monotonic() - BEGAN:4.0f} s] {text}", file=sys.stderr, flush=True)
