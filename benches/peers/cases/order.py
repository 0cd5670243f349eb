"""A model of given order by the subspace method, beside SIPPY."""

import time

import public_sets
import simulated
from tools import program, timed

TITLE = "Subspace method"
X = "order"
POINTS = [2, 4, 6, 8, 10]
QUICK = [2]
ROUNDS = 3
SAMPLES, ORDER = 10_000, 10
NOTE = "N4SID of given order on 10 000 samples of a plant of order 10; ours is the program, from a CSV file to a model with its verdict."


def contenders():
    return {"planesman": ours, "SIPPY": sippy}


def ours(order: int) -> dict[str, float]:
    table = simulated.table(SAMPLES, ORDER)
    fit = [program("planesman"), "sysid", "fit", table, "--input", "u", "--output", "y", "--method", "n4sid", "--order", order]
    return {"time [s]": timed(fit)}


def sippy(order: int) -> dict[str, float]:
    u, y, _ = simulated.record(SAMPLES, ORDER)
    start = time.perf_counter()
    public_sets.sippy(u, y, "N4SID", SS_f=20, SS_fixed_order=order)
    return {"time [s]": time.perf_counter() - start}
