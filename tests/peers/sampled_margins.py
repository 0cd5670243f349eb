#!/usr/bin/env python3
"""The margins of the sampled dive loop of `brunner`, computed from the thesis' numbers with scipy and python-control alone.

    sampled_margins.py FEET_PER_SECOND [--lag OMEGA] [--motion '[[time, share], ...]']

The vehicle's equations are those of `crates/vehicle/vehicle/vehicles/brunner.yaml`, in slugs and feet; the gains are program T6's. The plane command holds over a tick of
0.05 s. `--motion` is the planes' way after a unit step of the command at a tick, straight between its points, by default at once; `--lag` puts them behind a
lag of that bandwidth, rad/s. Prints one JSON object: the gain margin by the eigenvalues of the closed loop and its frequency, the phase margin,
the sensitivity peak.
"""

import argparse
import json

import control
import numpy as np
from scipy.linalg import expm
from scipy.optimize import brentq

TICK = 0.05
MASS, LENGTH, OWN_MASS, WEIGHT, ARM = 1.539, 28 / 12, 0.609444, 19.6, 0.1 / 12
KPZ, KDZ, KPY, KR = 0.25, 0.6, 0.7, 2.0


def vehicle(speed: float) -> tuple[np.ndarray, np.ndarray]:
    """x = (w, q, theta, z) in ft and s."""
    heave = OWN_MASS + 0.65 * MASS
    pitch = 0.072 * MASS * LENGTH**2
    a = np.zeros((4, 4))
    a[0, 0] = -1.295 * MASS * speed / LENGTH / heave
    a[0, 1] = (-0.2 * MASS + OWN_MASS) * speed / heave
    a[1] = [0.088 * MASS * speed / pitch, -0.2 * MASS * LENGTH * speed / pitch, -WEIGHT * ARM / pitch, 0]
    a[2, 1] = 1
    a[3] = [1, 0, -speed, 0]
    return a, np.array([0.095 * MASS * speed**2 / LENGTH / heave, -0.184 * MASS * speed**2 / pitch, 0, 0])


def sampled(a: np.ndarray, b: np.ndarray, motion: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """x and the past commands, from tick to tick: the response to a step of the command is integrated over each stretch of the motion."""
    n = len(b)
    ramp = np.zeros((n + 2, n + 2))
    ramp[:n, :n], ramp[:n, n], ramp[n, n + 1] = a, b, 1
    free, held = expm(a * TICK), expm(ramp * TICK)[:n, n]
    ticks = int(np.ceil(motion[-1, 0] / TICK - 1e-9))
    times = np.unique(np.round(np.concatenate([motion[:, 0], np.arange(ticks + 1) * TICK, [0.0]]), 12))
    share = lambda t: np.interp(t, motion[:, 0], motion[:, 1], left=0.0, right=1.0)
    x, steps = np.zeros(n), []
    for j in range(ticks):
        alone = free @ x
        inside = times[(times >= j * TICK - 1e-9) & (times <= (j + 1) * TICK + 1e-9)]
        for t0, t1 in zip(inside, inside[1:]):
            # The ends of a stretch, on its own side of a step.
            low, high = share(t0 + 1e-10), share(t1 - 1e-10)
            x = (expm(ramp * (t1 - t0)) @ np.concatenate([x, [low, (high - low) / (t1 - t0)]]))[:n]
        steps.append(x - alone)
    steps.append(held)
    inputs = np.diff(np.array([np.zeros(n), *steps]), axis=0)
    past = len(inputs) - 1
    whole, driven = np.zeros((n + past, n + past)), np.zeros(n + past)
    whole[:n, :n], driven[:n] = free, inputs[0]
    for j in range(past):
        whole[:n, n + j] = inputs[j + 1]
        if j:
            whole[n + j, n + j - 1] = 1
    if past:
        driven[n] = 1
    return whole, driven


def main() -> None:
    arguments = argparse.ArgumentParser()
    arguments.add_argument("speed", type=float)
    arguments.add_argument("--lag", type=float)
    arguments.add_argument("--motion", type=json.loads, default=[[0, 0], [0, 1]])
    given = arguments.parse_args()
    a, b = vehicle(given.speed)
    # L = -(delta_c by the law), so that 1 + L = 0 is the closed loop.
    law = np.array([KPY * KDZ, -KR, -KPY - KPY * KDZ * given.speed, KPY * KPZ])
    if given.lag:
        a = np.block([[a, b[:, None]], [np.zeros((1, 4)), np.array([[-given.lag]])]])
        b = np.array([0, 0, 0, 0, given.lag])
        law = np.append(law, 0)
    a, b = sampled(a, b, np.array(given.motion, dtype=float))
    law = np.append(law, np.zeros(len(b) - len(law)))
    radius = lambda factor: max(abs(np.linalg.eigvals(a - factor * np.outer(b, law)))) - 1
    factors = np.geomspace(1, 200, 4000)
    beyond = next(k for k, factor in enumerate(factors) if radius(factor) > 0)
    factor = brentq(radius, factors[beyond - 1], factors[beyond], xtol=1e-12)
    poles = np.linalg.eigvals(a - factor * np.outer(b, law))
    frequency = abs(np.angle(poles[np.argmax(abs(poles))])) / TICK
    loop = control.ss(a, b[:, None], law[None, :], 0, TICK)
    size = lambda w: abs(loop(np.exp(1j * w * TICK))) - 1
    grid = np.linspace(0.05, np.pi / TICK, 20000)
    response = loop(np.exp(1j * grid * TICK))
    crossings = [brentq(size, u, v) for u, v, p, q in zip(grid, grid[1:], abs(response) - 1, abs(response)[1:] - 1) if p * q < 0]
    phases = [np.angle(-loop(np.exp(1j * w * TICK))) for w in crossings]
    print(
        json.dumps(
            {
                "gain": [factor, frequency],
                "phase": [[w, phase] for w, phase in zip(crossings, phases)],
                "sensitivity": max(abs(1 / (1 + response))),
            }
        )
    )


if __name__ == "__main__":
    main()
