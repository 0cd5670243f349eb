"""The default of `sysid fit` on public data sets, beside five peers: `run --sets FOLDER`, or alone:

    target/peers/bin/python benches/peers/public_sets.py FOLDER [--program target/release/planesman] [--to benches/peers/sets.md]

FOLDER holds the sets as their sources name them: DaISy's `dryer.dat`, `heating_system.dat` and so on (De Moor B.L.R.
(ed.), DaISy: Database for the Identification of Systems, ESAT/STADIUS, KU Leuven), `gas.csv` (Box and Jenkins, series
J), sysidentpy's `buck_id.csv`, `f-16.txt`, `x_cc.csv`, `y_cc.csv`, `tanque.csv` and `SNLS80mV.csv` of the nonlinear
benchmarks. A set that is not there is left out. Every `.csv` with columns `time`, `u` and `y`, else `u2` and `y2`, is a set, too.

Every model is fitted to the first 70 % of a set and simulated over the last 30 %; the fit is 100 (1 - |y - yhat| / |y - mean y|) %. It is
judged twice: from a state fitted to all of the last 30 %, and from one fitted to its first tenth, which free motion cannot flatter.

ARX: least squares, orders 1-8, delays 0-8, least BIC. ARX-CV: the same by an inner validation (the last 30 % of what is fitted, from a
state fitted there). N4SID: SIPPY, horizon 20, orders 1-10, inner validation. OE: output error by SciPy's least_squares over the poles, all
else by linear least squares, from ARX and Steiglitz and McBride's iteration; orders 1-8, delays 0-4 and 6, inner validation on 12,000 samples at
most. BJ: the same, with an autoregression of the residual of order 4 as noise model, three rounds. The sets marked `last` were not looked at while the default was designed.
"""

import argparse
import contextlib
import io
import json
import tempfile
import time
import warnings
from pathlib import Path

import numpy
from scipy.optimize import least_squares
from scipy.signal import lfilter, ss2tf

from tools import OPTIONS, output, program, say

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


def own_form(path):
    """Input and output of a table of columns time, u..., y...; None for another."""
    names = path.open().readline().strip().split(",")
    if names[0] != "time":
        return None
    table = numpy.genfromtxt(path, delimiter=",", skip_header=1)
    pairs = [pair for pair in (("u", "y"), ("u2", "y2")) if set(pair) <= set(names)]
    if not pairs:
        return None
    u, y = map(names.index, pairs[0])
    return float(numpy.median(numpy.diff(table[:, 0]))), table[:, u], table[:, y]


def motions(den, count):
    """Free motions of a denominator as columns of length 1."""
    order = len(den) - 1
    columns = numpy.zeros((count, order))
    for i in range(order):
        impulse = numpy.zeros(count)
        impulse[i] = 1.0
        columns[:, i] = lfilter([1.0], den, impulse)
    return columns


def judged(model, u, y, first):
    """The fits, %, of a simulation of the samples from `first` on: with the initial state fitted to all of them, and to a tenth."""
    num, den, input_level, offset = model
    with numpy.errstate(all="ignore"):
        left = (y - offset - lfilter(num, den, u - input_level))[first:]
        columns = motions(den, len(left))
        if not (numpy.all(numpy.isfinite(left)) and numpy.all(numpy.abs(columns) < 1e150)):
            return -numpy.inf, -numpy.inf
        columns /= numpy.linalg.norm(columns, axis=0)
        spread = numpy.linalg.norm(y[first:] - y[first:].mean())
        fits = []
        for count in (len(left), len(left) // 10):
            state = numpy.linalg.lstsq(columns[:count], left[:count], rcond=1e-9)[0]
            fits.append(100 * (1 - numpy.linalg.norm(left - columns @ state) / spread))
    return tuple(fits)


def ours(interval, u, y):
    with tempfile.TemporaryDirectory() as folder:
        table, model = Path(folder) / "part.csv", Path(folder) / "model.json"
        time_ = numpy.arange(len(u)) * interval
        numpy.savetxt(table, numpy.column_stack([time_, u, y]), delimiter=",", fmt="%.12g", header="time,u,y", comments="")
        command = [program("planesman"), "sysid", "fit", table, "-i", "u", "-o", "y", "--model", model]
        output(command)
        found = json.loads(model.read_text())
    num, den = found["num"], found["den"]
    den = den + [0.0] * (len(num) - len(den))
    return [0.0] * (len(den) - len(num)) + num, den, found.get("input_level", 0.0), found["offset"]


def arx_of(u, y, order, delay, first):
    """Denominator, numerator and the variance left, of signals about their means."""
    past = [-y[first - i : len(y) - i] for i in range(1, order + 1)]
    past += [u[first - delay - j : len(u) - delay - j] for j in range(order)]
    rows = numpy.column_stack(past)
    theta = numpy.linalg.lstsq(rows, y[first:], rcond=None)[0]
    size = max(order, delay + order - 1) + 1
    num, den = numpy.zeros(size), numpy.zeros(size)
    den[0], den[1 : order + 1] = 1.0, theta[:order]
    num[delay : delay + order] = theta[order:]
    return num, den, numpy.mean((y[first:] - rows @ theta) ** 2)


def arx(_, u, y):
    level, mean = u.mean(), y.mean()
    u, y = u - level, y - mean
    first, best = 16, None
    for order in range(1, 9):
        for delay in range(9):
            num, den, variance = arx_of(u, y, order, delay, first)
            bic = (len(y) - first) * numpy.log(variance) + 2 * order * numpy.log(len(y) - first)
            if best is None or bic < best[0]:
                best = bic, num, den
    return best[1], best[2], level, mean


def by_inner_validation(fit, choices, u, y, most=None):
    """The model of the choice that simulates the last 30 % (of the first samples) best when fitted to the rest, fitted to everything."""
    whole, (u, y) = (u, y), (u[:most], y[:most])
    inner = int(SHARE * len(u))
    best = None
    for choice in choices:
        try:
            found = judged(fit(u[:inner], y[:inner], *choice), u, y, inner)[0]
        except Exception:  # one that cannot be fitted is not chosen
            continue
        if numpy.isfinite(found) and (best is None or found > best[0]):
            best = found, choice
    return fit(*whole, *best[1])


def arx_cv(_, u, y):
    def fit(u, y, order, delay):
        level, mean = u.mean(), y.mean()
        num, den, _ = arx_of(u - level, y - mean, order, delay, 16)
        return num, den, level, mean

    return by_inner_validation(fit, [(order, delay) for order in range(1, 9) for delay in range(9)], u, y)


def sippy(u, y, *args, **options):
    from sippy_unipi import system_identification

    with warnings.catch_warnings(), contextlib.redirect_stdout(io.StringIO()):
        warnings.simplefilter("ignore")
        return system_identification(y, u, *args, **options)


def n4sid(_, u, y):
    def fit(u, y, order):
        level, mean = u.mean(), y.mean()
        found = sippy(u - level, y - mean, "N4SID", SS_fixed_order=order, SS_f=20)
        num, den = ss2tf(found.A, found.B, found.C, found.D)
        return num[0], den, level, mean

    return by_inner_validation(fit, [(order,) for order in range(1, 11)], u, y)


def output_error_of(u, y, order, delay, noise):
    """Output error by variable projection: the poles are searched, numerator, offset and initial state are linear."""
    level, mean, by = u.mean(), y.mean(), y.std() / u.std()
    u, y = (u - level) * by, y - mean
    count = len(y)
    shifted = numpy.r_[numpy.zeros(delay), u][:count]

    def columns(den, whitening):
        through = lfilter([1.0], den, shifted)
        by_input = [numpy.r_[numpy.zeros(i), through[: count - i]] for i in range(order)]
        parts = numpy.column_stack([*by_input, numpy.ones(count), motions(den, count)])
        return lfilter(whitening, [1.0], parts, axis=0)

    def left(poles, whitening, target):
        den = numpy.r_[1.0, poles]
        if numpy.max(numpy.abs(numpy.roots(den)), initial=0.0) >= 0.99999:
            return numpy.full(count, 1e3)
        rows = columns(den, whitening)
        return target - rows @ numpy.linalg.lstsq(rows, target, rcond=1e-10)[0]

    with numpy.errstate(all="ignore"):
        starts = []
        _, den, _ = arx_of(u, y, order, delay, 16)
        den = den[: order + 1]
        for _ in range(8):
            starts.append(den[1:])
            num, den, _ = arx_of(lfilter([1.0], den, u), lfilter([1.0], den, y), order, delay, 16)
            den = den[: order + 1]
            if not numpy.all(numpy.isfinite(den)) or numpy.max(numpy.abs(numpy.roots(den)), initial=0.0) >= 1:
                break
        whitening, best = numpy.array([1.0]), None
        for _ in range(3 if noise else 1):
            target = lfilter(whitening, [1.0], y)
            trials = starts if best is None else [best]
            costs = [numpy.sum(left(start, whitening, target) ** 2) for start in trials]
            tried = [trials[i] for i in numpy.argsort(costs)[:2]]
            found = [least_squares(left, start, args=(whitening, target), max_nfev=25, x_scale="jac") for start in tried]
            best = min(found, key=lambda it: it.cost).x
            residual = left(best, numpy.array([1.0]), y)
            if noise:
                lags = numpy.column_stack([residual[4 - i : count - i] for i in range(1, 5)])
                whitening = numpy.r_[1.0, -numpy.linalg.lstsq(lags, residual[4:], rcond=None)[0]]
        target = lfilter(whitening, [1.0], y)
        den = numpy.r_[1.0, best]
        linear = numpy.linalg.lstsq(columns(den, whitening), target, rcond=1e-10)[0]
    num = numpy.r_[numpy.zeros(delay), linear[:order] * by]
    size = max(len(num), len(den))
    return numpy.r_[num, numpy.zeros(size - len(num))], numpy.r_[den, numpy.zeros(size - len(den))], level, mean + linear[order]


DELAYS = (0, 1, 2, 3, 4, 6)


def output_error(_, u, y, noise=False):
    choices = [(order, delay, noise) for order in range(1, 9) for delay in DELAYS]
    return by_inner_validation(output_error_of, choices, u, y, 12_000)


def box_jenkins(_, u, y):
    return output_error(_, u, y, True)


CONTENDERS = {"ours": ours, "ARX": arx, "ARX-CV": arx_cv, "N4SID": n4sid, "OE": output_error, "BJ": box_jenkins}


def sets(folder):
    """Name, whether it was kept apart, sampling interval, input and output of each set that is there."""
    own = {path.name: data for path in sorted(folder.glob("*.csv")) if (data := own_form(path)) is not None}
    for name, entry in {**SETS, **LAST}.items():
        if entry[0] not in own and (data := signals(folder, entry)) is not None:
            yield name, name in LAST, data
    for name, data in own.items():
        yield Path(name).stem, False, data


def table(folder: Path) -> str:
    """Fits and times on the sets that are there, as Markdown."""
    lines = ["## Public data sets", "", "Fits in % of the last 30 %, from a state fitted to all of it, and to its first tenth; seconds.", ""]
    lines += ["| set | samples | " + " | ".join(f"{name} | s" for name in CONTENDERS) + " |", "|---" * (2 + 2 * len(CONTENDERS)) + "|"]
    sums, counts = {name: [] for name in CONTENDERS}, [0, 0, 0, 0]
    for name, is_last, (interval, u, y) in sets(folder):
        fitted = int(SHARE * len(u))
        cells, fits = [], {}
        for contender, fit in CONTENDERS.items():
            start = time.perf_counter()
            try:
                fits[contender] = judged(fit(interval, u[:fitted], y[:fitted]), u, y, fitted)
                text = " / ".join(f"{it:.1f}" for it in fits[contender])
            except Exception as reason:  # a peer that fails is a result
                fits[contender], text = (-numpy.inf, -numpy.inf), type(reason).__name__
            sums[contender].append(numpy.clip(fits[contender], 0, 100))
            cells.append(f"{text} | {time.perf_counter() - start:.1f}")
        counts[0] += 1
        for i in range(2):
            counts[1 + i] += fits["ours"][i] >= max(it[i] for it in fits.values()) - 1
        counts[3] += fits["ours"][0] < max(it[0] for it in fits.values()) - 5
        lines.append(f"| {name}{', last' if is_last else ''} | {len(u)} | " + " | ".join(cells) + " |")
        say(lines[-1])
    means = {name: numpy.mean(values, axis=0) for name, values in sums.items()}
    lines.append("| mean, clipped to 0..100 | | " + " | ".join(f"{of[0]:.1f} / {of[1]:.1f} |" for of in means.values()) + " |")
    lines += ["", f"Of {counts[0]} sets ours is best or within a point on {counts[1]}, from a state of the first tenth on {counts[2]}; more than 5 points behind on {counts[3]}."]
    return "\n".join(lines) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--program", default=str(Path(__file__).resolve().parents[2] / "target/release/planesman"))
    parser.add_argument("--to", type=Path, default=Path(__file__).resolve().parent / "sets.md")
    options = parser.parse_args()
    OPTIONS["programs"] = {"planesman": options.program}
    options.to.write_text(table(options.folder))


if __name__ == "__main__":
    main()
