"""The default of `sysid fit` on public data sets, beside ARX, N4SID and output error of other packages: `run --sets FOLDER`.

FOLDER holds the sets as their sources name them: DaISy's `dryer.dat`, `heating_system.dat` and so on (De Moor B.L.R.
(ed.), DaISy: Database for the Identification of Systems, ESAT/STADIUS, KU Leuven), `gas.csv` (Box and Jenkins, series
J), sysidentpy's `buck_id.csv`, `f-16.txt`, `x_cc.csv`, `y_cc.csv`, `tanque.csv` and `SNLS80mV.csv` of the nonlinear
benchmarks. A set that is not there is left out.

Every model is fitted to the first 70 % of a set and simulated over the last 30 % from a state fitted there; the fit is
100 (1 - |y - yhat| / |y - mean y|) %. Shown are the fits and the seconds. ARX: least squares, orders 1-8, delays 0-8,
least BIC. N4SID: SIPPY, horizon 20, orders 1-10, least BIC. OE: SIPPY, order 3, delay 1. The sets marked `last` were
not looked at while the default was designed.
"""

import contextlib
import io
import json
import tempfile
import time
import warnings
from pathlib import Path

import numpy
from scipy.signal import lfilter, ss2tf

from tools import output, program, say

SHARE = 0.7
# name: file, separator, lines to skip, sampling interval s, column of the input and of the output, every so many rows
SETS = {
    "dryer": ("dryer.dat", None, 0, 0.08, 0, 1, 1),
    "heating": ("heating_system.dat", None, 0, 2.0, 1, 2, 1),
    "exchanger": ("exchanger.dat", None, 0, 1.0, 1, 2, 1),
    "cstr": ("cstr.dat", None, 0, 6.0, 1, 3, 1),
    "cdplayer 2-2": ("CD_player_arm.dat", None, 0, 1 / 2048, 1, 3, 1),
    "gas": ("gas.csv", ",", 1, 9.0, 1, 2, 1),
    "ball and beam": ("ballbeam.dat", None, 0, 0.1, 0, 1, 1),
    "robot arm": ("robot_arm.dat", None, 0, 1.0, 0, 1, 1),
    "industrial dryer 1-1": ("dryer2.dat", None, 0, 10.0, 1, 4, 1),
    "evaporator 1-1": ("evaporator.dat", None, 0, 1.0, 0, 3, 1),
    "evaporator 3-3": ("evaporator.dat", None, 0, 1.0, 2, 5, 1),
    "wall": ("thermic_res_wall.dat", None, 0, 1.0, 0, 2, 1),
    "cdplayer 1-1": ("CD_player_arm.dat", None, 0, 1 / 2048, 0, 2, 1),
    "power plant 1-1": ("powerplant.dat", None, 0, 1228.8, 1, 6, 1),
    "glass furnace 1-1": ("glassfurnace.dat", None, 0, 1.0, 1, 4, 1),
    "f-16": ("f-16.txt", ",", 0, 0.0025, 0, 2, 1),
    "coupled drives": (("x_cc.csv", "y_cc.csv"), None, 0, 0.01, 0, 1, 500),
}
LAST = {
    "flutter": ("flutter.dat", None, 0, 1.0, 0, 1, 1),
    "steam generator 1-1": ("steamgen.dat", None, 0, 3.0, 1, 5, 1),
    "steam generator 3-4": ("steamgen.dat", None, 0, 3.0, 3, 8, 1),
    "winding 5-1": ("winding.dat", None, 0, 0.1, 4, 5, 1),
    "winding 3-2": ("winding.dat", None, 0, 0.1, 2, 6, 1),
    "pH": ("pHdata.dat", None, 0, 10.0, 2, 3, 1),
    "buck converter": ("buck_id.csv", ",", 1, 1e-5, 1, 2, 1),
    "tanks": ("tanque.csv", ",", 1, 4.0, 0, 2, 1),
    "cstr concentration": ("cstr.dat", None, 0, 6.0, 1, 2, 1),
    "silverbox": ("SNLS80mV.csv", ",", 2, 1.0, 0, 1, 1),
    "glass furnace 2-3": ("glassfurnace.dat", None, 0, 1.0, 2, 6, 1),
}


def signals(folder, entry):
    """Sampling interval, input and output; None when a file is not there."""
    names, separator, skipped, interval, u, y, stride = entry
    names = names if isinstance(names, tuple) else (names,)
    if not all((folder / name).exists() for name in names):
        return None
    tables = [numpy.genfromtxt(folder / name, delimiter=separator, skip_header=skipped) for name in names]
    table = tables[0] if len(tables) == 1 else numpy.column_stack(tables)
    rows = numpy.all(numpy.isfinite(table[:, [u, y]]), axis=1)
    return interval, table[rows][::stride, u], table[rows][::stride, y]


def judged(model, u, y):
    """The fit, %, of a simulation whose initial state is fitted; num and den in falling powers of z."""
    num, den, input_level, offset = model
    order = len(den) - 1
    with numpy.errstate(all="ignore"):
        left = y - offset - lfilter(num, den, u - input_level)
        columns = numpy.zeros((len(y), order))
        for i in range(order):
            impulse = numpy.zeros(len(y))
            impulse[i] = 1.0
            columns[:, i] = lfilter([1.0], den, impulse)
        if not (numpy.all(numpy.isfinite(left)) and numpy.all(numpy.abs(columns) < 1e150)):
            return -numpy.inf
        columns /= numpy.linalg.norm(columns, axis=0)
        left -= columns @ numpy.linalg.lstsq(columns, left, rcond=1e-9)[0]
    return 100 * (1 - numpy.linalg.norm(left) / numpy.linalg.norm(y - y.mean()))


def ours(interval, u, y):
    with tempfile.TemporaryDirectory() as folder:
        table, model = Path(folder) / "part.csv", Path(folder) / "model.json"
        time_ = numpy.arange(len(u)) * interval
        numpy.savetxt(table, numpy.column_stack([time_, u, y]), delimiter=",", fmt="%.12g", header="time,u,y", comments="")
        command = [program("planesman"), "sysid", "fit", table, "-i", "u", "-o", "y", "--model", model]
        output(command)
        found = json.loads(model.read_text())
    num, den = found["num"], found["den"]
    return [0.0] * (len(den) - len(num)) + num, den, 0.0, found["offset"]


def arx(_, u, y):
    level, mean = u.mean(), y.mean()
    u, y = u - level, y - mean
    first, best = 16, None
    for order in range(1, 9):
        for delay in range(9):
            past = [-y[first - i : len(y) - i] for i in range(1, order + 1)]
            past += [u[first - delay - j : len(u) - delay - j] for j in range(order)]
            rows = numpy.column_stack(past)
            theta = numpy.linalg.lstsq(rows, y[first:], rcond=None)[0]
            variance = numpy.mean((y[first:] - rows @ theta) ** 2)
            bic = len(rows) * numpy.log(variance) + 2 * order * numpy.log(len(rows))
            if best is None or bic < best[0]:
                best = bic, order, delay, theta
    _, order, delay, theta = best
    size = max(order, delay + order - 1) + 1
    num, den = numpy.zeros(size), numpy.zeros(size)
    den[0], den[1 : order + 1] = 1.0, theta[:order]
    num[delay : delay + order] = theta[order:]
    return num, den, level, mean


def sippy(u, y, *args, **options):
    from sippy_unipi import system_identification

    with warnings.catch_warnings(), contextlib.redirect_stdout(io.StringIO()):
        warnings.simplefilter("ignore")
        return system_identification(y, u, *args, **options)


def n4sid(_, u, y):
    level, mean = u.mean(), y.mean()
    found = sippy(u - level, y - mean, "N4SID", IC="BIC", SS_f=20, SS_orders=[1, 10])
    num, den = ss2tf(found.A, found.B, found.C, found.D)
    return num[0], den, level, mean


def output_error(_, u, y):
    level, mean, by = u.mean(), y.mean(), y.std() / u.std()
    found = sippy((u - level) / u.std(), (y - mean) / y.std(), "OE", OE_orders=[3, 3, 1], max_iterations=200).G
    num, den = (numpy.ravel(numpy.squeeze(numpy.array(part, dtype=float))) for part in (found.num, found.den))
    return numpy.r_[numpy.zeros(len(den) - len(num)), num] * by, den, level, mean


def table(folder: Path) -> str:
    """Fits and times on the sets that are there, as Markdown."""
    contenders = {"ours": ours, "ARX": arx, "N4SID": n4sid, "OE": output_error}
    lines = ["## Public data sets", "", "| set | samples | " + " | ".join(f"{name} | s" for name in contenders) + " |"]
    lines.append("|---" * (2 + 2 * len(contenders)) + "|")
    counts = {"within": 0, "better": 0, "sets": 0}
    for name, entry in {**SETS, **LAST}.items():
        data = signals(folder, entry)
        if data is None:
            continue
        interval, u, y = data
        fitted = int(SHARE * len(u))
        cells, fits = [], {}
        for contender, fit in contenders.items():
            start = time.perf_counter()
            try:
                fits[contender] = judged(fit(interval, u[:fitted], y[:fitted]), u[fitted:], y[fitted:])
                text = f"{fits[contender]:.1f}"
            except Exception as reason:  # a peer that fails is a result
                text = type(reason).__name__
            cells.append(f"{text} | {time.perf_counter() - start:.1f}")
        best = max([fit for contender, fit in fits.items() if contender != "ours"], default=-numpy.inf)
        counts["sets"] += 1
        counts["within"] += fits.get("ours", -numpy.inf) >= best - 1
        counts["better"] += fits.get("ours", -numpy.inf) > best
        mark = ", last" if name in LAST else ""
        lines.append(f"| {name}{mark} | {len(u)} | " + " | ".join(cells) + " |")
        say(lines[-1])
    lines += ["", f"Of {counts['sets']} sets ours is best or within a point on {counts['within']}, better than all on {counts['better']}."]
    return "\n".join(lines) + "\n"
