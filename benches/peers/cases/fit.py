"""A model out of a record: of unknown order beside SIPPY, by least squares of given order beside sysidentpy."""

import json
import tempfile
import time
import warnings
from pathlib import Path

import numpy as np
from scipy.signal import lfilter

import public_sets
import simulated
from tools import program, timed

TITLE = "Model fit"
X = "samples"
POINTS = [1000, 10_000, 100_000]
ROUNDS = 3
ORDER = 3
NOTE = (
    "a plant of order 3, white noise of 10 % on its output. Ours is the program with its default, which cross-validates order, delay and kind of model, from a CSV file to "
    "a model with its verdict; SIPPY is N4SID, orders 1 to 10 by BIC; sysidentpy is FROLS with the six terms of order 3, ours then `--method least_squares --order 3`, "
    "both biased by such noise. The error is that of the simulated output on another record."
)
TIME, ERROR = "time [s]", "error [%]"
GIVEN = "order given, "


def contenders():
    return {"planesman": ours, "SIPPY N4SID": sippy, "sysidentpy FROLS": sysidentpy}


def ours(samples: int) -> dict[str, float]:
    given = fitted(samples, "--method", "least_squares", "--order", ORDER)
    return {**fitted(samples), **{GIVEN + measure: cost for measure, cost in given.items()}}


def fitted(samples: int, *options) -> dict[str, float]:
    table = simulated.table(samples, ORDER)
    with tempfile.TemporaryDirectory() as folder:
        model = Path(folder) / "model.json"
        taken = timed([program("planesman"), "sysid", "fit", table, "--input", "u", "--output", "y", "--model", model, *options])
        found = json.loads(model.read_text())
    num = np.r_[np.zeros(len(found["den"]) - len(found["num"])), found["num"]]
    return {TIME: taken, ERROR: simulated.error(lambda u, _: lfilter(num, found["den"], u) + found["offset"], ORDER)}


def sippy(samples: int) -> dict[str, float]:
    u, y, _ = simulated.record(samples, ORDER)
    start = time.perf_counter()
    num, den, level, mean = public_sets.n4sid(None, u, y)
    taken = time.perf_counter() - start
    return {TIME: taken, ERROR: simulated.error(lambda u, _: lfilter(num, den, u - level) + mean, ORDER)}


def sysidentpy(samples: int) -> dict[str, float]:
    from sysidentpy.basis_function import Polynomial
    from sysidentpy.model_structure_selection import FROLS
    from sysidentpy.parameter_estimation import LeastSquares

    u, y, _ = simulated.record(samples, ORDER)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        model = FROLS(
            order_selection=False, n_terms=2 * ORDER, ylag=ORDER, xlag=ORDER, estimator=LeastSquares(), basis_function=Polynomial(degree=1)
        )
        start = time.perf_counter()
        model.fit(X=u.reshape(-1, 1), y=y.reshape(-1, 1))
        taken = time.perf_counter() - start
        error = simulated.error(lambda u, clean: model.predict(X=u.reshape(-1, 1), y=clean[:ORDER].reshape(-1, 1)), ORDER)
    return {GIVEN + TIME: taken, GIVEN + ERROR: error}
