"""A sweep of dives on one core and on more."""

import os

from cases.sweep import sweep
from tools import OPTIONS

TITLE = "Sweep on some of the cores"
X = "cores"
CORES = sorted(os.sched_getaffinity(0))
POINTS = [2**k for k in range(10) if 2**k < len(CORES)] + [len(CORES)]
QUICK = POINTS
ROUNDS = 3
NOTE = "`taskset` gives the program its cores. The share of linear compares with one core in the same round, and 100 % is linear."


def contenders():
    return {"planesman": on}


def on(cores: int) -> dict[str, float]:
    dives = 20 if OPTIONS["quick"] else 200
    one = sweep(dives, "taskset", "--cpu-list", str(CORES[0]))
    several = sweep(dives, "taskset", "--cpu-list", ",".join(map(str, CORES[:cores]))) if cores > 1 else one
    return {"dives a second": dives / several, "share of linear [%]": 100 * one / several / cores}
