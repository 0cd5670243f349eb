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


def solve_dive(method, rtol):
    """Two calls, since the planes jump at 10 s."""
    how = {"method": method, "rtol": rtol, "atol": 0.01 * rtol}
    held = solve_ivp(rates, (0, 10), np.zeros(4), args=(PLANES,), **how)
    level = solve_ivp(rates, (10, 60), held.y[:, -1], args=(0.0,), **how)
    return held, level


def ends(solution):
    """Pitch [rad] and depth [m] after 10 and 60 s."""
    return np.array([leg.y[2:, -1] for leg in solution])


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

    exact = ends(solve_dive("DOP853", 3e-14))
    for method, rtol in [("DOP853", 1e-10), ("DOP853", 1e-8), ("RK45", 1e-10), ("LSODA", 1e-10)]:
        seconds, solution = best(lambda: solve_dive(method, rtol), 100)
        evaluations = sum(leg.nfev for leg in solution)
        pitch, depth = np.abs(ends(solution) - exact).max(axis=0) / np.abs(exact).max(axis=0)
        print(
            f"scipy solve_ivp ({method}, rtol {rtol:.0e}), dive of 60 s: {seconds * 1e3:.3f} ms, {evaluations} evaluations,"
            f" error {depth:.1e} of depth and {pitch:.1e} of pitch"
        )
    print(f"after 10 s: pitch {np.degrees(exact[0, 0]):.6f} deg, depth {exact[0, 1] / FOOT:.6f} ft")

    system = linear_system()
    times = np.arange(1200) * 0.05
    planes = np.where(times < 10, PLANES, 0.0)
    seconds, _ = best(lambda: linear_dive(system, times, planes), 200)
    print(f"python-control, linear dive of 60 s at 20 Hz: {seconds * 1e3:.3f} ms")


if __name__ == "__main__":
    main()
