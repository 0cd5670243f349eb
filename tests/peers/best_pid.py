#!/usr/bin/env python3
"""The best PID controller of a sampled plant, by scipy's differential evolution, beside one that is given.

    best_pid.py '{"num": [1], "den": [0.25, 0.2, 1], "delay": 4, "tick": 0.05, "phase": 45, "gain": 6, "ms": 1.6, "given": [kp, ki, kd, filter]}'

The plant is num/den in s, held over a tick, and behind so many ticks of dead time. The controller is evaluated at the ticks by backward differences,
u = kp e + ki T sum(e) - kd dy / (filter + T) ..., as `planesman tune` says. Least is the integrated absolute error after a unit step of the load at the
input; limits are the phase margin (deg), the gain margin to either side (dB) and the sensitivity peak. Prints one JSON object: of both controllers the
error, the margins and the gains.
"""

import json
import sys

import numpy as np
from scipy.optimize import differential_evolution
from scipy.signal import cont2discrete, lfilter

FREQUENCIES = 1500
TICKS = 20000


class Loop:
    def __init__(self, case: dict):
        self.tick = case["tick"]
        num, den, _ = cont2discrete((case["num"], case["den"]), self.tick, method="zoh")
        num = np.trim_zeros(np.where(np.abs(num.ravel()) < 1e-13, 0, num.ravel()), "f")
        # In powers of 1/z: at least a tick between input and output.
        lead = len(den) - len(num) + case["delay"]
        self.a, self.b = den, np.concatenate([np.zeros(lead), num])
        nyquist = np.pi / self.tick
        self.w = np.concatenate([np.geomspace(1e-4, 0.9999, FREQUENCIES) * nyquist, [nyquist]])
        self.q = np.exp(-1j * self.w * self.tick)
        self.plant = np.polyval(self.b[::-1], self.q) / np.polyval(self.a[::-1], self.q)
        self.limits = np.radians(case["phase"]), 10 ** (case["gain"] / 20), case["ms"]
        self.ticks = int(min(TICKS, case.get("duration", 400) / self.tick))

    def controller(self, gains):
        kp, ki, kd, tau = gains
        # kp + ki T / (1 - q) + kd (1 - q) / (tau + T - tau q)
        lag = np.array([tau + self.tick, -tau])
        one = np.array([1.0, -1.0])
        num = kp * np.convolve(one, lag)
        num[:2] += ki * self.tick * lag
        num += kd * np.convolve(one, one)
        return num, np.convolve(one, lag)

    def margins(self, gains):
        num, den = self.controller(gains)
        loop = self.plant * np.polyval(num[::-1], self.q) / np.polyval(den[::-1], self.q)
        ms = np.max(1 / np.abs(1 + loop))
        size = np.abs(loop)
        phase, gain = np.pi, np.inf
        for k in np.nonzero((size[:-1] - 1) * (size[1:] - 1) <= 0)[0]:
            share = np.log(size[k]) / (np.log(size[k]) - np.log(size[k + 1]))
            at = loop[k] ** (1 - share) * loop[k + 1] ** share if abs(np.angle(loop[k + 1] / loop[k])) < 1 else loop[k]
            phase = min(phase, abs(np.angle(-at)))
        turns = np.nonzero((loop.imag[:-1] * loop.imag[1:] <= 0) & (loop.real[:-1] < 0) & (loop.real[1:] < 0))[0]
        for k in turns:
            share = loop.imag[k] / (loop.imag[k] - loop.imag[k + 1]) if loop.imag[k] != loop.imag[k + 1] else 0
            at = abs(loop[k]) + share * (abs(loop[k + 1]) - abs(loop[k]))
            gain = min(gain, max(at, 1 / at))
        if loop[-1].real < 0:
            gain = min(gain, max(abs(loop[-1]), 1 / abs(loop[-1])))
        return phase, gain, ms

    def closed(self, gains):
        num, den = self.controller(gains)
        through, own = np.convolve(self.b, num), np.convolve(self.a, den)
        own = np.concatenate([own, np.zeros(max(0, len(through) - len(own)))])
        own[: len(through)] += through
        return np.convolve(self.b, den), own

    def cost(self, gains):
        """(missed, error)"""
        num, den = self.closed(gains)
        radius = np.max(np.abs(np.roots(den)))
        if not radius < 1:
            return 10 + radius, np.inf
        phase, gain, ms = self.margins(gains)
        least, up, most = self.limits
        missed = max(0, 1 - phase / least) + max(0, 1 - gain / up) + max(0, ms / most - 1)
        if missed > 0:
            return missed, np.inf
        y = lfilter(num, den, np.ones(self.ticks))
        return 0.0, self.tick * np.sum(np.abs(y))

    def best(self, sign, guess):
        """Over logarithms of kp, ki and kd, and the filter's time constant."""
        span = 4.0
        middle = np.log(np.abs(guess[:3]))
        bounds = [(m - span, m + span) for m in middle] + [(0, 3 * guess[2] / guess[0])]
        gains = lambda x: np.concatenate([sign * np.exp(x[:3]), [max(x[3], 0)]])

        def cost(x):
            missed, error = self.cost(gains(x))
            return 1e6 * (1 + missed) if missed > 0 else min(error, 1e5)

        found = differential_evolution(cost, bounds, seed=3, popsize=12, maxiter=150, tol=1e-6, polish=False)
        return gains(found.x)


def main() -> None:
    case = json.loads(sys.argv[1])
    loop = Loop(case)
    given = np.array(case["given"])

    def told(gains):
        missed, error = loop.cost(gains)
        phase, gain, ms = loop.margins(gains)
        return {"missed": missed, "error": error if np.isfinite(error) else None, "gains": list(gains),
                "phase": float(np.degrees(phase)), "gain": float(20 * np.log10(gain)), "ms": float(ms)}

    # The search begins about a rule of thumb, not about what is given: a controller at the plant's limit of stability.
    sign = np.sign(np.sum(loop.b))
    inner = loop.plant * sign
    turn = np.nonzero((inner.imag[:-1] < 0) & (inner.imag[1:] >= 0) | (inner.imag[:-1] > 0) & (inner.imag[1:] <= 0))[0]
    at = turn[0] if len(turn) else len(inner) - 2
    ku, tu = 1 / max(abs(inner[at]), 1e-9), 2 * np.pi / loop.w[at]
    guess = np.array([0.4 * ku, 0.6 * ku / tu, 0.06 * ku * tu, 0])
    print(json.dumps({"given": told(given), "best": told(loop.best(sign, guess))}))


if __name__ == "__main__":
    main()
