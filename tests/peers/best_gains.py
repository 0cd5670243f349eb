#!/usr/bin/env python3
"""The best gains that scipy's differential evolution finds: PID controllers of ten sampled plants, and the dive loop of `brunner` for ten
sets of limits. The result is the file best_gains.json, which tests/program/best_gains.rs compares with `planesman`.

    best_gains.py record            computes all cases, in two minutes on two cores, and writes best_gains.json
    best_gains.py check NAME...     evaluates the recorded gains of these cases again and prints one JSON object a case

A plant is num/den in s, held over a tick, behind so many ticks of dead time. Its controller is evaluated at the ticks by backward differences
(`planesman tune --help`): C = kp + ki T/(1 - q) + kd (1 - q)/(filter + T - filter q) with q = 1/z. The cost is the integrated absolute error after a
unit step of the load at the input, the limits are phase margin (deg), gain margin to either side (dB) and sensitivity peak.

The dive loop is that of sampled_margins.py at each speed (m/s). The cost is the largest ITAE U^2 of a depth step over the speeds, the limits are
those that `planesman design optimise` names.

Each search runs from three seeds; a last one refines the best of them within 10 % on a finer grid of frequencies.
"""

import json
import sys
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import numpy as np
import scipy
from sampled_margins import TICK, sampled, vehicle
from scipy.optimize import differential_evolution
from scipy.signal import cont2discrete, lfilter

RECORD = Path(__file__).with_suffix(".json")
SEEDS = (1, 2, 3)
COARSE, FINE = 500, 4000
FOOT = 0.3048

#       name              num           den                      delay, ticks  tick, s
PLANTS = {
    "oscillating": ([1.0], [0.25, 0.2, 1.0], 4, 0.05),
    "two lags": ([2.0], [5.0, 6.0, 1.0], 6, 0.05),
    "three lags": ([1.0], [1.0, 3.0, 3.0, 1.0], 4, 0.1),
    "lag": ([2.0], [4.0, 1.0], 10, 0.1),
    "damped, late": ([1.0], [1.0, 0.6, 1.0], 10, 0.1),
    "integrator": ([-0.5], [1.0, 0.0], 5, 0.1),
    "motor": ([3.0], [0.5, 1.0, 0.0], 3, 0.05),
    "unstable": ([1.0], [5.0, -1.0], 2, 0.1),
    "inverse response": ([-0.5, 1.0], [2.0, 3.0, 1.0], 2, 0.1),
    "fast mode": ([1.0], [0.04, 0.08, 1.0], 3, 0.02),
}

# The bandwidth of the actuator first_order of `planesman`, rad/s.
OMEGA = 67.8

#       name          speeds             phase  gain  overshoot  bandwidth
DIVES = {
    "help's example": ([0.3048, 0.6096], 45.0, 8.0, 5.0),
    "1 ft/s": ([0.3048], 45.0, 6.0, 5.0),
    "all default speeds": ([0.1524, 0.3048, 0.6096, 0.9144], 45.0, 6.0, 5.0),
    "first order": ([0.3048, 0.9144], 75.0, 6.0, 2.0, OMEGA),
    "2 ft/s": ([0.6096], 45.0, 6.0, 5.0),
    "2 ft/s, 60 deg": ([0.6096], 60.0, 8.0, 10.0),
    "3 ft/s": ([0.9144], 45.0, 6.0, 5.0),
    "0.5 ft/s": ([0.1524], 45.0, 6.0, 5.0),
    "0.4 m/s, 70 deg": ([0.4], 70.0, 10.0, 1.0),
    "3 ft/s, 20 %": ([0.9144], 50.0, 10.0, 20.0),
}


def margins(loop):
    """Phase margin (rad), the factors by which the gain may grow and to which it may fall, and the sensitivity peak, between the points of an open loop."""
    size, turned = np.abs(loop), loop[1:] / loop[:-1]
    over = np.nonzero((size[:-1] - 1) * (size[1:] - 1) <= 0)[0]
    share = np.log(size[over]) / np.log(size[over] / size[over + 1])
    phase = np.min(np.abs(np.angle(-loop[over] * turned[over] ** share)), initial=np.pi)
    real = np.nonzero((loop.imag[:-1] * loop.imag[1:] < 0) & (loop.real[:-1] < 0) & (loop.real[1:] < 0))[0]
    share = loop.imag[real] / (loop.imag[real] - loop.imag[real + 1])
    factors = 1 / (size[real] ** (1 - share) * size[real + 1] ** share)
    if loop[-1].real < 0:
        factors = np.append(factors, 1 / size[-1])
    # The peak of a parabola through the highest point and its neighbours.
    s = 1 / np.abs(1 + loop)
    k = np.argmax(s)
    peak = s[k]
    if 0 < k < len(s) - 1 and (bend := s[k - 1] - 2 * s[k] + s[k + 1]) < 0:
        peak -= (s[k + 1] - s[k - 1]) ** 2 / (8 * bend)
    return phase, np.min(factors[factors >= 1], initial=np.inf), np.max(factors[factors < 1], initial=0), peak


def grid(tick, count):
    nyquist = np.pi / tick
    return np.append(np.geomspace(1e-4, 0.9999, count) * nyquist, nyquist)


class Pid:
    """A plant, and controllers kp, ki, kd, filter."""

    def __init__(self, num, den, delay, tick, count=COARSE):
        self.tick = tick
        num, self.a, _ = cont2discrete((num, den), tick, method="zoh")
        num = np.trim_zeros(np.where(np.abs(num.ravel()) < 1e-13, 0, num.ravel()), "f")
        # In powers of q: at least a tick from input to output.
        self.b = np.concatenate([np.zeros(len(self.a) - len(num) + delay), num])
        self.sign = np.sign(np.sum(self.b))
        self.limits = {"phase": 45.0, "gain": 6.0, "ms": 1.6}
        self.ticks = int(min(20000, 400 / tick))
        self.look(count)

    def look(self, count):
        """At so many frequencies."""
        self.w = grid(self.tick, count)
        self.q = np.exp(-1j * self.w * self.tick)
        self.plant = np.polyval(self.b[::-1], self.q) / np.polyval(self.a[::-1], self.q)

    def bounds(self):
        """About a rule of thumb: a controller at the plant's limit of stability. Of the logarithms of kp, ki and kd, and the filter's root."""
        inner = self.plant * self.sign
        turn = np.nonzero(inner.imag[:-1] * inner.imag[1:] <= 0)[0]
        at = turn[0] if len(turn) else len(inner) - 2
        ku, tu = 1 / max(abs(inner[at]), 1e-9), 2 * np.pi / self.w[at]
        middle = np.log([0.4 * ku, 0.6 * ku / tu, 0.06 * ku * tu])
        return [(m - 4, m + 4) for m in middle] + [(0, np.sqrt(tu))]

    def gains(self, x):
        return np.append(self.sign * np.exp(x[:3]), x[3] ** 2)

    def margins(self, gains):
        kp, ki, kd, tau = gains
        control = kp + ki * self.tick / (1 - self.q) + kd * (1 - self.q) / (tau + self.tick - tau * self.q)
        return margins(self.plant * control)

    def closed(self, gains):
        kp, ki, kd, tau = gains
        one, lag = np.array([1.0, -1.0]), np.array([tau + self.tick, -tau])
        den = np.convolve(one, lag)
        num = kp * den + kd * np.convolve(one, one) + np.append(ki * self.tick * lag, 0)
        own, through = np.convolve(self.a, den), np.convolve(self.b, num)
        length = max(len(own), len(through))
        own, through = (np.append(c, np.zeros(length - len(c))) for c in (own, through))
        return np.convolve(self.b, den), own + through

    def cost(self, gains):
        """By how much the limits are missed, and the error."""
        num, den = self.closed(gains)
        radius = np.max(np.abs(np.roots(den)))
        if not radius < 1:
            return 10 + radius, 0.0
        phase, up, down, ms = self.margins(gains)
        gain = 10 ** (self.limits["gain"] / 20)
        missed = max(0, 1 - phase / np.radians(self.limits["phase"])) + max(0, 1 - up / gain) + max(0, 1 - 1 / max(down * gain, 1e-9)) + max(0, ms / self.limits["ms"] - 1)
        if missed > 0:
            return missed, 0.0
        return 0.0, self.tick * np.sum(np.abs(lfilter(num, den, np.ones(self.ticks))))

    def described(self):
        return {"a": list(self.a), "b": list(self.b), "tick": self.tick, "ticks": self.ticks}


class Dive:
    """The vehicle at speeds, in m and s: x = (w, q, theta, z) of each, and the planes where they lag; gains Kpz, Kdz, Kpy, Kr."""

    def __init__(self, speeds, phase, gain, overshoot, lag=None, count=COARSE):
        self.speeds, self.lag = speeds, lag
        self.limits = {"phase": phase, "gain": gain, "overshoot": overshoot, "step": 0.9144, "pitch": 45.0, "planes": 30.0, "duration": 120.0}
        self.systems = []
        for speed in speeds:
            # Rates and depth in m; depth rate is w - U theta.
            rows = np.array([[0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, FOOT], [FOOT, 0, -speed, 0]])
            a, b = vehicle(speed / FOOT)
            if lag:
                a = np.block([[a, b[:, None]], [np.zeros((1, 4)), np.array([[-lag]])]])
                b, rows = np.array([0, 0, 0, 0, lag]), np.hstack([rows, np.zeros((4, 1))])
            self.systems.append((*sampled(a, b, np.array([[0.0, 0.0], [0.0, 1.0]])), rows))
        self.look(count)

    def look(self, count):
        at = np.exp(1j * grid(TICK, count) * TICK)
        self.outputs = [np.linalg.solve(at[:, None, None] * np.eye(len(b)) - a, b[None, :, None])[:, :, 0] @ rows.T for a, b, rows in self.systems]

    def bounds(self):
        return [(np.log(1e-3), np.log(1e2))] * 4

    def gains(self, x):
        return np.exp(x)

    def law(self, gains):
        """delta = kpy (kpz (zc - z) - kdz z' + theta) + kr q"""
        kpz, kdz, kpy, kr = gains
        return np.array([kr, kpy, -kpy * kpz, -kpy * kdz])

    def margins(self, gains):
        each = np.array([margins(-outputs @ self.law(gains)) for outputs in self.outputs])
        return np.min(each[:, 0]), np.min(each[:, 1]), np.max(each[:, 2]), np.max(each[:, 3])

    def cost(self, gains):
        limits = self.limits
        asked = gains[0] * limits["step"]
        missed = max(0, asked / np.radians(limits["pitch"]) - 1) + max(0, gains[2] * asked / np.radians(limits["planes"]) - 1)
        if missed > 0:
            return 100 + missed, 0.0
        law, poles = self.law(gains), []
        for a, b, rows in self.systems:
            poles.append(np.linalg.eig(a + np.outer(b, law @ rows)))
        radius = max(np.max(np.abs(it[0])) for it in poles)
        if not radius < 1:
            return 10 + radius, 0.0
        phase, up, down, _ = self.margins(gains)
        gain = 10 ** (limits["gain"] / 20)
        missed = max(0, 1 - phase / np.radians(limits["phase"])) + max(0, 1 - up / gain) + max(0, 1 - 1 / max(down * gain, 1e-9))
        if missed > 0:
            return missed, 0.0
        worst, count = 0.0, int(round(limits["duration"] / TICK)) + 1
        times = TICK * np.arange(count)
        for speed, (a, b, rows), (values, vectors) in zip(self.speeds, self.systems, poles):
            # The depth after a unit step of the setpoint, from rest: the sum of powers of each pole.
            parts = np.linalg.solve(vectors, b * gains[0] * gains[2]) * (rows[2] @ vectors)
            depth = np.real((1 - np.exp(np.outer(np.arange(count), np.log(values.astype(complex))))) @ (parts / (1 - values)))
            missed += max(0, 100 * (np.max(depth) - 1) / limits["overshoot"] - 1)
            error = times * np.abs(1 - depth)
            worst = max(worst, TICK * (np.sum(error) - 0.5 * error[-1]) * speed**2)
        return missed, worst

    def described(self):
        return {"speeds": self.speeds, "lag": self.lag, "systems": [{"a": a.tolist(), "b": b.tolist(), "rows": rows.tolist()} for a, b, rows in self.systems], "tick": TICK}


def case(name, count=COARSE):
    return Pid(*PLANTS[name], count) if name in PLANTS else Dive(*DIVES[name], count=count)


def told(it, gains):
    missed, cost = it.cost(gains)
    phase, up, down, ms = it.margins(gains)
    decibels = 20 * np.log10([min(up, 1e6), 1 / max(down, 1e-6)])
    return {"gains": list(gains), "cost": cost, "missed": missed, "phase": float(np.degrees(phase)), "gain": float(min(decibels)), "ms": float(ms)}


def search(name):
    it = case(name)

    def value(x):
        missed, cost = it.cost(it.gains(x))
        return 1e6 * (1 + missed) if missed > 0 else min(cost, 1e5)

    found = [differential_evolution(value, it.bounds(), seed=seed, popsize=15, maxiter=200, tol=1e-5, polish=False) for seed in SEEDS]
    best = min(found, key=lambda it: it.fun)
    it.look(FINE)
    near = [(max(x - 0.1, low), min(x + 0.1, high)) for x, (low, high) in zip(best.x, it.bounds())]
    fine = differential_evolution(value, near, seed=SEEDS[0], popsize=10, maxiter=80, tol=1e-6, polish=False)
    print(name, [f"{it.fun:.6g}" for it in found], f"{fine.fun:.6g}", it.gains(fine.x), flush=True)
    return {"name": name, **it.described(), "limits": it.limits, "seeds": [it.fun for it in found], "best": told(it, it.gains(fine.x))}


def main():
    if sys.argv[1:2] == ["record"]:
        with ProcessPoolExecutor() as pool:
            found = list(pool.map(search, [*PLANTS, *DIVES]))
        RECORD.write_text(json.dumps({"scipy": scipy.__version__, "search": "differential_evolution", "pid": found[: len(PLANTS)], "dive": found[len(PLANTS) :]}, indent=1) + "\n")
        return
    record = json.loads(RECORD.read_text())
    for name in sys.argv[2:]:
        recorded = next(it for it in record["pid"] + record["dive"] if it["name"] == name)
        print(json.dumps({"recorded": recorded["best"], "again": told(case(name, FINE), np.array(recorded["best"]["gains"]))}))


if __name__ == "__main__":
    main()
