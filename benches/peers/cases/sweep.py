"""A sweep of dives: cost against the number of cases."""

import tempfile
from pathlib import Path

from tools import program, timed

TITLE = "Sweep"
X = "dives"
POINTS = [30, 100, 300]
QUICK = [10]
ROUNDS = 3
NOTE = "dives of 90 s with a Kalman filter, each with its own noise, on all cores; starting the program and checking the cases is in the time."


def contenders():
    return {"planesman": lambda dives: {"a dive [ms]": sweep(dives) / dives * 1e3}}


def sweep(dives: int, *prefix: str) -> float:
    """The wall time [s]."""
    with tempfile.TemporaryDirectory() as folder:
        command = [*prefix, program("planesman"), "sweep", "dive", "--set", "depth_controller.feedback.source=kalman"]
        command += ["--vary", "depth_controller.depth.p=0.8", "--seeds", dives, "--out", Path(folder) / "sweep"]
        taken = timed(command)
        rows = len((Path(folder) / "sweep/cases.csv").read_text().splitlines()) - 1
    if rows != dives:
        raise AssertionError(f"{rows} of {dives} dives are there")
    return taken
