#!/usr/bin/env python3
"""The best gains of the dive loop of `brunner` with ideal planes, by scipy's differential evolution, beside gains that are given.

    best_dive_gains.py '{"speeds": [0.3048, 0.6096], "phase": 45, "gain": 8, "overshoot": 5, "step": 0.9144, "pitch_limit": 45, "planes_limit": 30,
                         "duration": 120, "given": [depth_p, depth_d, pitch_p, pitch_rate]}'

Units are SI and degrees; the vehicle and its sampling are those of sampled_margins.py. Least is the largest over the speeds of ITAE U^2 of a step of the
depth, within the limits that `planesman design optimise` names. Prints one JSON object: of both the worst ITAE U^2, by how much the limits are missed, the gains.
"""

import json
import sys

import numpy as np
from sampled_margins import TICK, sampled, vehicle
from scipy.optimize import differential_evolution

FOOT = 0.3048
FREQUENCIES = 400


class Speed:
    """The vehicle at a speed, in m and s: x = (w, q, theta, z)."""

    def __init__(self, speed: float):
        self.speed = speed
        a, b = vehicle(speed / FOOT)
        self.a, self.b = sampled(a, b, np.array([[0.0, 0.0], [0.0, 1.0]]))
        # Depth rate, from x in feet: w - U theta. Depth and its rate in m.
        self.rows = np.array([[0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, FOOT], [FOOT, 0, -speed, 0]])
        nyquist = np.pi / TICK
        self.w = np.concatenate([np.geomspace(1e-5, 0.9999, FREQUENCIES) * nyquist, [nyquist]])
        poles, vectors = np.linalg.eig(self.a)
        at = np.exp(1j * self.w * TICK)
        self.outputs = np.array([self.rows @ np.linalg.solve(z * np.eye(4) - self.a, self.b) for z in at])

    def law(self, gains):
        kpz, kdz, kpy, kr = gains
        # delta = kpy (kpz (zc - z) - kdz z' + theta) + kr q
        return np.array([kr, kpy, -kpy * kpz, -kpy * kdz])

    def cost(self, gains, limits):
        law = self.law(gains)
        closed = self.a + np.outer(self.b, law @ self.rows)
        poles, vectors = np.linalg.eig(closed)
        radius = np.max(np.abs(poles))
        if not radius < 1:
            return 10 + radius, np.inf
        loop = -self.outputs @ law
        size = np.abs(loop)
        phase = np.inf
        for k in np.nonzero((size[:-1] - 1) * (size[1:] - 1) <= 0)[0]:
            share = np.log(size[k]) / (np.log(size[k]) - np.log(size[k + 1]))
            phase = min(phase, abs(np.angle(-(loop[k] + share * (loop[k + 1] - loop[k])))))
        up, down = np.inf, 0.0
        for k in np.nonzero((loop.imag[:-1] * loop.imag[1:] <= 0) & (loop.real[:-1] < 0) & (loop.real[1:] < 0))[0]:
            share = loop.imag[k] / (loop.imag[k] - loop.imag[k + 1]) if loop.imag[k] != loop.imag[k + 1] else 0
            factor = 1 / (size[k] + share * (size[k + 1] - size[k]))
            up, down = (min(up, factor), down) if factor >= 1 else (up, max(down, factor))
        if loop[-1].real < 0:
            factor = -1 / loop[-1].real
            up, down = (min(up, factor), down) if factor >= 1 else (up, max(down, factor))
        most = 10 ** (limits["gain"] / 20)
        missed = max(0, 1 - phase / np.radians(limits["phase"])) + max(0, 1 - up / most) + max(0, 1 - 1 / (down * most) if down else 0)
        if missed > 0:
            return missed, np.inf
        # z of z' = closed x + b law_z zc, from rest.
        kpz, _, kpy, _ = gains
        driven = self.b * kpy * kpz
        parts = np.linalg.solve(vectors, driven)
        count = int(round(limits["duration"] / TICK)) + 1
        times = TICK * np.arange(count)
        # sum over j < k of poles^j
        sums = (1 - poles[None, :] ** np.arange(count)[:, None]) / (1 - poles)[None, :]
        depth = np.real(sums * parts @ (self.rows[2] @ vectors))
        overshoot = 100 * max(0, np.max(depth) - 1)
        missed = max(0, overshoot / limits["overshoot"] - 1)
        error = times * np.abs(1 - depth)
        return missed, TICK * (np.sum(error) - 0.5 * error[-1]) * self.speed**2


def main() -> None:
    case = json.loads(sys.argv[1])
    speeds = [Speed(it) for it in case["speeds"]]

    def cost(gains):
        """(missed, worst)"""
        asked = gains[0] * case["step"]
        missed = max(0, asked / np.radians(case["pitch_limit"]) - 1) + max(0, gains[2] * asked / np.radians(case["planes_limit"]) - 1)
        if missed > 1:
            return missed, np.inf
        each = [it.cost(gains, case) for it in speeds]
        return missed + sum(it[0] for it in each), max(it[1] for it in each)

    def value(logarithms):
        missed, worst = cost(np.exp(logarithms))
        return 1e6 * (1 + missed) if missed > 0 else worst

    bounds = [(np.log(1e-3), np.log(1e2))] * 4
    found = differential_evolution(value, bounds, seed=5, popsize=12, maxiter=80, tol=1e-5, polish=False)

    def told(gains):
        missed, worst = cost(np.array(gains))
        return {"missed": missed, "worst": worst, "gains": list(gains)}

    print(json.dumps({"given": told(case["given"]), "best": told(np.exp(found.x))}))


if __name__ == "__main__":
    main()
