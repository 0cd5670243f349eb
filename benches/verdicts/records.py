"""Records of a situation, computed by NumPy and SciPy from a seed, and the least squares of the true structure on them."""

import zlib
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import least_squares
from scipy.signal import cont2discrete, lfilter

from situations import LENGTH, PLANTS, Plant

SUBSTEPS = 20
"""Of the integration of dry friction, in a sample."""
AWAY = 0.2
"""How far from the truth the oracle begins, as a share of each parameter."""


def slowest(den):
    """The longest time constant (s) by the real parts of the poles; of an integrator alone one second, of a static gain 0."""
    rates = np.abs(np.real(np.roots(den)))
    rates = rates[rates > 1e-9]
    if len(rates):
        return 1.0 / rates.min()
    return 1.0 if len(den) > 1 else 0.0


def interval_of(situation):
    """The sampling interval, s: longer in short records, so that they show the dynamics."""
    return PLANTS[situation.plant].interval * min(4.0, max(1.0, LENGTH / situation.samples / 2))


def sampled(num, den, interval, delay=0):
    """`b` and `a` in powers of `z^-1` of a transfer function whose input is held."""
    if len(den) == 1:
        return np.r_[np.zeros(delay), num[0] / den[0]], np.ones(1)
    b, a, _ = cont2discrete((num, den), interval, method="zoh")
    return np.r_[np.zeros(delay), b[0]], a


def curved(kind, parameters, x):
    """What a static curve makes of a signal; parameters as in a model file."""
    of = parameters.get
    if kind == "dead zone":
        return np.maximum(x - of("upper"), 0) + np.minimum(x - of("lower"), 0)
    if kind == "saturation":
        return np.clip(x, of("lower", -np.inf), of("upper", np.inf))
    if kind == "square law":
        return x * np.abs(x) + of("linear", 0.0) * x
    if kind == "piecewise linear":
        count = sum(name.startswith("level") for name in parameters)
        slopes = [of(f"slope {i + 1}", 1.0) for i in range(count + 1)]
        bends = [(parameters[f"level {i + 1}"], slopes[i + 1] - slopes[i]) for i in range(count)]
        return slopes[0] * x + sum(by * np.maximum(x - level, 0) for level, by in bends)
    assert kind == "backlash", kind
    follower, played = 0.0, np.empty(len(x))
    for k, value in enumerate(x):
        follower = np.clip(follower, value - of("width") / 2, value + of("width") / 2)
        played[k] = follower
    return played


def with_dry_friction(plant, u, interval):
    """`T v' = K u - v - friction sign(v)`, by small steps that end at rest where friction holds."""
    constant, step = plant.den[0], interval / SUBSTEPS
    v, seen = 0.0, np.empty(len(u))
    for k, force in enumerate(u):
        seen[k] = v
        for _ in range(SUBSTEPS):
            free = v + step / constant * (plant.num[0] * force - v)
            by = step / constant * plant.friction
            v = np.sign(free) * max(abs(free) - by, 0.0)
    return seen


def simulate(plant: Plant, u, interval):
    """The output of a plant without its loop, from rest."""
    if plant.friction:
        return with_dry_friction(plant, u, interval)
    side, kind, parameters = plant.curve or ("", "", {})
    x = curved(kind, parameters, u) if side == "input" else u
    y = lfilter(*sampled(plant.num, plant.den, interval, plant.delay), x)
    return curved(kind, parameters, y) if side == "output" else y


def joined(*polynomials):
    """The sum of polynomials in `z^-1`."""
    total = np.zeros(max(map(len, polynomials)))
    for it in polynomials:
        total[: len(it)] += it
    return total


def in_loop(plant, r, d, interval, transfer=None):
    """Input and output of the plant with its controller, for a setpoint and a disturbance at the output."""
    b, a = transfer or sampled(plant.num, plant.den, interval, plant.delay)
    gain, integral = plant.controller
    c, e = ([gain + integral * interval, -gain], [1.0, -1.0]) if integral else ([gain], [1.0])
    closed = joined(np.convolve(a, e), np.convolve(b, c))
    y = lfilter(np.convolve(b, c), closed, r) + lfilter(np.convolve(a, e), closed, d)
    return lfilter(np.convolve(a, c), closed, r - d), y


def steps(count, spans, random):
    """Levels within +-1 that are held over spans of samples drawn by `spans()`."""
    values = []
    while len(values) < count:
        values += [random.uniform(-1, 1)] * max(1, int(spans()))
    return np.array(values[:count])


def input_of(kind, count, constant, random):
    """An input, or the setpoint of a loop, of size 1; `constant` is the slowest time constant in samples."""
    k = np.arange(count)
    start = int(count * random.uniform(0.1, 0.2))
    kind = kind.removeprefix("setpoint ")
    if kind in ("one step", "one setpoint step"):
        return np.where(k < start, 0.0, 1.0)
    if kind == "few steps":
        edges = np.sort(start + (count - start) * (np.arange(4) + random.uniform(-0.2, 0.2, 4)) / 4)
        levels = random.permutation([1.0, -1.0, 0.5, -0.4])
        return np.where(k < edges[0], 0.0, levels[np.searchsorted(edges, k, side="right") - 1])
    if kind in ("many steps", "steps"):
        return steps(count, lambda: constant * random.uniform(1, 4) + 1, random)
    if kind == "PRBS":
        hold = max(1, round(constant / 4))
        return np.repeat(random.choice([-1.0, 1.0], count // hold + 1), hold)[:count]
    if kind == "multisine":
        rates = np.geomspace(0.2, min(8, constant), 10) / constant
        return sum(np.sin(rate * k + random.uniform(0, 2 * np.pi)) for rate in rates) / 3
    if kind == "chirp":
        low, high = 0.1 / constant, min(10 / constant, 1.0)
        phase = low * count / np.log(high / low) * ((high / low) ** (k / count) - 1)
        return np.sin(phase)
    if kind == "ramps":
        knots = np.arange(0, count + 3 * constant, max(2, 3 * constant))
        return np.interp(k, knots, random.uniform(-1, 1, len(knots)))
    if kind == "smooth":
        rise = np.clip((k - start) / max(4.0, 5 * constant), 0, 1)
        return (3 - 2 * rise) * rise**2
    period = max(8, round(6 * constant))
    if kind == "triangle":
        return np.abs(4 * (k % period) / period - 2) - 1
    if kind == "square behind a servo":
        lag = np.exp(-3 / max(constant, 3))
        return lfilter([1 - lag], [1, -lag], np.where(k % period < period / 2, 1.0, -1.0))
    if kind.startswith("impulse"):
        return np.where(k == (0 if kind.endswith("row 1") else start), max(1.0, constant / 2), 0.0)
    assert kind == "feedback alone", kind
    return np.zeros(count)


def disturbance_of(kind, count, constant, random):
    """A disturbance at the output, with the share of the clean output's deviation that it has."""
    k, white = np.arange(count), random.normal(0, 1, count)
    if kind.startswith("AR"):
        pole = float(kind[3:-1])
        past = lfilter([1.0], [1.0, -pole], random.normal(0, 1, count + 200))[200:]
        return 0.05 * np.sqrt(1 - pole**2) * past
    sizes = {"none": 0.0, "white": 0.05, "white 15 %": 0.15, "no effect": 1.0}
    if kind in sizes:
        return sizes[kind] * white
    phase = random.uniform(0, 2 * np.pi)
    slow = {
        "sine": lambda: 0.3 * np.sin(random.uniform(0.7, 3) / max(constant, 3) * k + phase),
        "daily": lambda: 0.3 * np.sin(2 * np.pi / (0.9 * count) * k + phase),
        "unrecorded steps": lambda: 0.5 * lfilter([1 / (1 + constant / 2)], [1, -1 + 1 / (1 + constant / 2)], steps(count, lambda: count / 5, random)),
        "drift": lambda: k / count,
    }
    return slow[kind]() + 0.01 * white


@dataclass
class Record:
    """The columns as they are logged, and the setpoint."""

    columns: dict
    r: np.ndarray
    interval: float

    def csv(self):
        """The table's text."""
        rows = zip(*(column if name == "time" else [f"{it:.12g}" for it in column] for name, column in self.columns.items()))
        return "\n".join([",".join(self.columns), *map(",".join, rows)]) + "\n"


def logged(kind, columns, interval, random):
    """The columns as a logger of that kind writes them; time as text."""
    count = len(columns["y"])
    time, digits, y = np.arange(count) * interval, 9, columns["y"]
    if kind == "quantised":
        step = np.ptp(y) / 25
        columns = columns | {"y": np.round(y / step) * step}
    elif kind == "clipped":
        middle, size = (y.max() + y.min()) / 2, np.ptp(y) / 2
        columns = columns | {"y": np.clip(y, middle - 0.6 * size, middle + 0.6 * size)}
    elif kind == "digits lost":
        # Ten rows with one stamp from the middle on.
        time, digits = time + 10 ** np.ceil(np.log10(count)) * interval - time[count // 2], int(np.ceil(np.log10(count)))
    elif kind == "held":
        columns = columns | {"y": y[np.arange(count) // 3 * 3]}
    elif kind == "jitter":
        time = time + interval * random.uniform(0, 0.4, count)
    return {"time": [f"{it:.{digits}g}" for it in time], **columns}


def record(situation, seed):
    """The record of a situation."""
    plant, count, interval = PLANTS[situation.plant], situation.samples, interval_of(situation)
    random = np.random.default_rng(zlib.crc32(f"{situation} {seed}".encode()))
    constant = slowest(plant.den) / interval or 5.0
    r = input_of(situation.input, count, constant, random)
    unit = disturbance_of(situation.noise, count, constant, random)
    others = {}
    if plant.controller:
        _, clean = in_loop(plant, r, 0 * r, interval)
        u, y = in_loop(plant, r, (np.std(clean) or 1.0) * unit, interval)
    else:
        u, clean = r, 0 * r if situation.noise == "no effect" else simulate(plant, r, interval)
        if plant.other:
            others["v"] = input_of(situation.input, count, constant, random)
            clean = clean + lfilter(*sampled(*plant.other, interval), others["v"])
        y = clean + (np.std(clean) or 1.0) * unit
    return Record(logged(situation.log, {"u": u, **others, "y": y}, interval, random), r, interval)


def oracle(situation, rec, random):
    """The plant with the parameters that least squares finds from beside the truth, by the simulated error of the true structure: the
    true order, delay, curve and controller, zeros and integrators; the offset and the motion at the beginning are free. `None` of dry friction."""
    plant, interval = PLANTS[situation.plant], rec.interval
    if plant.friction:
        return None
    truth = [np.array(it, float) for it in (plant.num, plant.den, *plant.other)]
    # A denominator begins with a number that is known, or ends with 0, an integrator's; the rest is sought as factors.
    sought = [(i, k) for i, it in enumerate(truth) for k in range(i % 2, len(it)) if it[k]]
    inputs, y = [rec.columns[name] for name in "uv" if name in rec.columns], rec.columns["y"]

    def plant_of(theta):
        parts = [it.copy() for it in truth]
        for (i, k), factor in zip(sought, theta):
            parts[i][k] *= factor
        return replace(plant, num=parts[0], den=parts[1], other=tuple(parts[2:]))

    def errors(theta):
        found = plant_of(theta)
        b, a = sampled(found.num, found.den, interval, found.delay)
        free = [np.ones(len(y))]
        if plant.controller:
            output = in_loop(found, rec.r, 0 * rec.r, interval, (b, a))[1]
        else:
            output = simulate(found, inputs[0], interval)
            if found.other:
                output = output + lfilter(*sampled(*found.other, interval), inputs[1])
            if not plant.curve:
                free += [lfilter(np.eye(len(a))[i], a, np.eye(1, len(y))[0]) for i in range(len(a) - 1)]
        left = y - output
        if not np.all(np.isfinite(left)) or not np.all(np.isfinite(free)):
            return np.full(len(y), 1e6)
        # An offset and the motion of an integrator are alike.
        q, sizes, _ = np.linalg.svd(np.array(free).T, full_matrices=False)
        q = q[:, sizes > 1e-9 * sizes[0]]
        return left - q @ (q.T @ left)

    # No further from the truth than where as many poles are unstable.
    grow = lambda theta: sum(np.real(np.roots(plant_of(theta).den)) > 1e-9)
    away = AWAY * random.choice([-1.0, 1.0], len(sought))
    while grow(1 + away) != grow(np.ones(len(sought))):
        away = away / 2
    found = least_squares(errors, 1 + away, x_scale="jac", xtol=1e-9, ftol=1e-9, max_nfev=40)
    return plant_of(found.x)
