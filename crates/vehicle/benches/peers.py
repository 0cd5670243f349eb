"""The same dive with planesman_vehicle, scipy and python-control, in one run.

Usage, from the root of the workspace (numpy, scipy and control are needed):

    python crates/vehicle/benches/peers.py

The problem is program T2 of Brunner 1988 in consistent units: the vehicle at 1 ft/s, planes at 30
degrees for 10 s and then neutral, until 60 s. the vehicle crate's own bench is run first and its lines are
shown as they are. Times are the best of several rounds.
"""

import subprocess
import time

import control
import numpy as np
from scipy.integrate import solve_ivp

FOOT = 0.3048
POUND = 4.4482216152605
SLUG = 14.59390294
SPEED = FOOT
LENGTH, REFERENCE_MASS = 28 * 0.0254, 1.539 * SLUG
MASS = 0.609444 * SLUG
HEAVE_INERTIA = MASS + 0.65 * REFERENCE_MASS
PITCH_INERTIA = 0.072 * REFERENCE_MASS * LENGTH**2
Z_W = -1.295 * REFERENCE_MASS * SPEED / LENGTH
Z_Q = -0.20 * REFERENCE_MASS * SPEED + MASS * SPEED
Z_DELTA = 0.095 * REFERENCE_MASS * SPEED**2 / LENGTH
M_W = 0.088 * REFERENCE_MASS * SPEED
M_Q = -0.20 * REFERENCE_MASS * LENGTH * SPEED
M_DELTA = -0.184 * REFERENCE_MASS * SPEED**2
RESTORING = 19.6 * POUND * 0.1 * 0.0254
PLANES = np.radians(30.0)


def rates(t, state, delta):
    """w', q', theta', z' of [w, q, theta, z]."""
    w, q, theta, _ = state
    return [
        (Z_W * w + Z_Q * q + Z_DELTA * delta) / HEAVE_INERTIA,
        (M_W * w + M_Q * q + M_DELTA * delta - RESTORING * np.sin(theta)) / PITCH_INERTIA,
        q,
        w * np.cos(theta) - SPEED * np.sin(theta),
    ]


def solve_dive():
    """Two calls, since the planes jump at 10 s; tolerances for about the error of RK4 at 1 ms."""
    exact = {"method": "DOP853", "rtol": 1e-10, "atol": 1e-12}
    held = solve_ivp(rates, (0, 10), np.zeros(4), args=(PLANES,), **exact)
    level = solve_ivp(rates, (10, 60), held.y[:, -1], args=(0.0,), **exact)
    return held, level


def linear_dive(system, times, planes):
    """The linear vehicle sampled at 20 Hz, with python-control."""
    return control.forced_response(system, times, planes)


def linear_system():
    """The vehicle about level flight, through a zero-order hold of 0.05 s; depth out."""
    a = [
        [Z_W / HEAVE_INERTIA, Z_Q / HEAVE_INERTIA, 0, 0],
        [M_W / PITCH_INERTIA, M_Q / PITCH_INERTIA, -RESTORING / PITCH_INERTIA, 0],
        [0, 1, 0, 0],
        [1, 0, -SPEED, 0],
    ]
    b = [[Z_DELTA / HEAVE_INERTIA], [M_DELTA / PITCH_INERTIA], [0], [0]]
    return control.c2d(control.ss(a, b, [[0, 0, 0, 1]], [[0]]), 0.05, "zoh")


def best(work, rounds):
    """The shortest time of some rounds [s], and the last result."""
    shortest, result = np.inf, None
    for _ in range(rounds):
        start = time.perf_counter()
        result = work()
        shortest = min(shortest, time.perf_counter() - start)
    return shortest, result


def main():
    subprocess.run(["cargo", "bench", "--quiet", "-p", "planesman_vehicle", "--bench", "step"], check=True)

    seconds, (held, level) = best(solve_dive, 200)
    evaluations = held.nfev + level.nfev
    print(f"scipy solve_ivp (DOP853), dive of 60 s: {seconds * 1e3:.3f} ms, {evaluations} evaluations")
    print(f"after 10 s: pitch {np.degrees(held.y[2, -1]):.6f} deg, depth {held.y[3, -1] / FOOT:.6f} ft")

    system = linear_system()
    times = np.arange(1200) * 0.05
    planes = np.where(times < 10, PLANES, 0.0)
    seconds, _ = best(lambda: linear_dive(system, times, planes), 200)
    print(f"python-control, linear dive of 60 s at 20 Hz: {seconds * 1e3:.3f} ms")


if __name__ == "__main__":
    main()
