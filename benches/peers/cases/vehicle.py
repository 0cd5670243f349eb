"""The vehicle beside scipy, a C++ program and python-control.

The problem is program T2 of Brunner 1988 in consistent units: the vehicle `brunner` at 1 ft/s, planes at 30 degrees for 10 s and then neutral,
until 60 s. The C++ program has the same equations, by Runge-Kutta of fourth order.
"""

import json
from functools import cache

import numpy as np
from scipy.integrate import solve_ivp

from tools import HERE, Missing, ROOT, best, output, program, seconds

TITLE = "Vehicle"
NOTE = (
    "program T2's dive in the vertical plane; ours also looks for surface, bottom and numbers that are not finite. scipy's rtol is 1e-10; the C++ program is Runge-Kutta of "
    "fourth order in 1200 steps, and in 60 000 where there is a state every millisecond. Python-control's dive is linear, at 20 Hz. Each round is the best of 50 or more."
)
DIVE, FINE, LINEAR = "dive of 60 s [ms]", "dive of 60 s, a state every ms [ms]", "linear dive of 60 s [ms]"

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
AFTER_10_S = (-51.387696, 5.014306)
"""Pitch [deg] and depth [ft], which all three nonlinear programs must reach."""


def contenders():
    return {
        "planesman": ours,
        "scipy DOP853": lambda: scipy("DOP853"),
        "scipy LSODA": lambda: scipy("LSODA"),
        "C++ RK4 at -O3": cpp,
        "python-control": python_control,
    }


def check(who: str, pitch: float, depth: float) -> None:
    if not np.allclose((pitch, depth), AFTER_10_S, rtol=0, atol=2e-6):
        raise Missing(f"{who} is at {pitch:.6f} deg and {depth:.6f} ft after 10 s, not at {AFTER_10_S}")


def ours() -> dict[str, float]:
    text = output([program("step")])
    return {
        DIVE: seconds("planesman_vehicle, dive of 60 s, a state every 0.05 s", text) * 1e3,
        FINE: seconds("planesman_vehicle, dive of 60 s, a state every 0.001 s", text) * 1e3,
        LINEAR: seconds(r"linear dive of 60 s[^:\n]*", text) * 1e3,
    }


@cache
def compiled() -> str:
    built = ROOT / "target/peers/rk4"
    output(["g++", "-O3", "-std=c++17", "-o", built, HERE / "rk4.cpp"])
    return str(built)


def cpp() -> dict[str, float]:
    coefficients = [HEAVE_INERTIA, PITCH_INERTIA, Z_W, Z_Q, Z_DELTA, M_W, M_Q, M_DELTA, RESTORING, SPEED, PLANES]
    times = {}
    for measure, steps in [(DIVE, 1200), (FINE, 60_000)]:
        found = json.loads(output([compiled(), steps, *map(repr, map(float, coefficients))]))
        check("C++", np.degrees(found["pitch"]), found["depth"] / FOOT)
        times[measure] = found["dive"] * 1e3
    return times


def rates(t, state, delta):
    """w', q', theta', z' of [w, q, theta, z]."""
    w, q, theta, _ = state
    return [
        (Z_W * w + Z_Q * q + Z_DELTA * delta) / HEAVE_INERTIA,
        (M_W * w + M_Q * q + M_DELTA * delta - RESTORING * np.sin(theta)) / PITCH_INERTIA,
        q,
        w * np.cos(theta) - SPEED * np.sin(theta),
    ]


def dive(method: str):
    """Two calls, since the planes jump at 10 s."""
    exact = {"method": method, "rtol": 1e-10, "atol": 1e-12}
    held = solve_ivp(rates, (0, 10), np.zeros(4), args=(PLANES,), **exact)
    solve_ivp(rates, (10, 60), held.y[:, -1], args=(0.0,), **exact)
    return held.y[:, -1]


def scipy(method: str) -> dict[str, float]:
    _, _, pitch, depth = dive(method)
    check(f"scipy's {method}", np.degrees(pitch), depth / FOOT)
    return {DIVE: best(lambda: dive(method), 50) * 1e3}


@cache
def linear_system():
    """The vehicle about level flight, through a zero-order hold of 0.05 s; depth out."""
    import control

    a = [
        [Z_W / HEAVE_INERTIA, Z_Q / HEAVE_INERTIA, 0, 0],
        [M_W / PITCH_INERTIA, M_Q / PITCH_INERTIA, -RESTORING / PITCH_INERTIA, 0],
        [0, 1, 0, 0],
        [1, 0, -SPEED, 0],
    ]
    b = [[Z_DELTA / HEAVE_INERTIA], [M_DELTA / PITCH_INERTIA], [0], [0]]
    return control.c2d(control.ss(a, b, [[0, 0, 0, 1]], [[0]]), 0.05, "zoh")


def python_control() -> dict[str, float]:
    import control

    times = np.arange(1200) * 0.05
    planes = np.where(times < 10, PLANES, 0.0)
    system = linear_system()
    return {LINEAR: best(lambda: control.forced_response(system, times, planes), 50) * 1e3}
