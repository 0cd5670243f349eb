"""Vehicles of six degrees of freedom beside scipy, numpy over all vehicles at once, and a C++ program.

The manoeuvre is that of crates/vehicle/vehicle/benches/six_dof.rs: 60 s in a steady current, inputs that jump every 10 s. The equations are written here anew, as matrices:
`M nu' = tau + u L nu + u^2 f - C_RB(nu) nu - C_A(nu_r) nu_r - (D + Q |nu_r|) nu_r - g + M_A nu_c'`, where lift and thrust of a segment, f and tau, are computed once.
"""

import json
import math
import re
import time
from functools import cache

import numpy as np
from scipy.integrate import solve_ivp

from tools import HERE, Missing, ROOT, best, output, program, seconds

TITLE = "Six degrees of freedom"
NOTE = (
    "60 s in a current with inputs that jump every 10 s. One vehicle to 1e-10, ours the best of 200 and scipy's CPU time the best of 3; 1024 vehicles by Runge-Kutta of fourth order at 20 ms, by CPU time: ours on two threads, eight in lanes, numpy over all "
    "vehicles, the C++ program one after the other. Errors are the largest of any number of the state at the jumps, relative where it is above 1, beside scipy at 1e-13."
)
COUNT, SEEN = 1024, (0, 511, 1023)
CURRENT = np.array([0.1, 0.2, 0.0])
SEGMENT, STEP, STEPS = 10.0, 0.02, 500
AGREED = 1e-5
"""Largest error that may be called the same motion: that of the fixed step."""


def skew(a):
    return np.array([[0, -a[2], a[1]], [a[2], 0, -a[0]], [-a[1], a[0], 0]])


class Vehicle:
    """Mass about the origin, matrices of the forces, and what a segment's inputs hold: tau and f."""

    def __init__(self, mass, weight, buoyancy, gravity, buoyant, inertia, added, linear, quadratic, lift, held):
        s = skew(gravity)
        about_origin = np.diag(inertia) - mass * s @ s
        self.rigid = np.block([[mass * np.eye(3), -mass * s], [mass * s, about_origin]])
        self.added, self.linear, self.quadratic, self.lift = np.diag(added), linear, quadratic, lift
        self.inverse = np.linalg.inv(self.rigid + self.added)
        self.weight, self.buoyancy, self.gravity, self.buoyant = weight, buoyancy, np.array(gravity), np.array(buoyant)
        self.held = held


def lauv() -> Vehicle:
    """Rudder positive to starboard, as the vehicle's file has it, planes positive to dive, thrust."""
    linear, quadratic, lift = np.diag([2.4, 23, 23, 0.3, 9.7, 9.7]), np.diag([2.4, 80, 80, 0.0006, 9.1, 9.1]), np.zeros((6, 6))
    linear[1, 5], linear[2, 4], linear[4, 2], linear[5, 1] = -11.5, 11.5, -3.1, 3.1
    quadratic[1, 5], quadratic[2, 4], quadratic[4, 2], quadratic[5, 1] = -0.3, 0.3, -1.5, 1.5
    lift[1, 1], lift[1, 5], lift[2, 2], lift[2, 4] = -30.156304379394403, 7.68, -30.156304379394403, -7.68
    lift[4, 2], lift[4, 4], lift[5, 1], lift[5, 5] = -10.98880392257711, -3.072, 10.98880392257711, -3.072

    def held(rudder, planes, thrust):
        return np.array([np.clip(thrust, 0, 14), 0, 0, 0, 0, 0]), np.array([0, -19.2 * rudder, -19.2 * planes, 0, -7.68 * planes, 7.68 * rudder])

    inertia, added = [0.0405, 1.0701, 1.0701], [1, 16, 16, 0.005, 1.3, 1.3]
    # The inertia is about the centre of gravity, 1 cm below the origin.
    return Vehicle(18, 176.58, 177.58, [0, 0, 0.01], [0, 0, 0], inertia, added, linear, quadratic, lift, held)


def bluerov2() -> Vehicle:
    places = np.array([(x, y, 0.085) for x, y in [(0.156, 0.111), (0.156, -0.111), (-0.156, 0.111), (-0.156, -0.111)]])
    places = np.vstack([places, [(0.12, 0.218, 0), (0.12, -0.218, 0), (-0.12, 0.218, 0), (-0.12, -0.218, 0)]])
    level = np.array([(1, -1, 0), (1, 1, 0), (-1, -1, 0), (-1, 1, 0)]) / math.sqrt(2)
    directions = np.vstack([level, np.tile([0, 0, -1], (4, 1))])
    wrenches = np.hstack([directions, np.cross(places, directions)]).T

    def held(*commands):
        c = np.array(commands)
        return wrenches @ (8.9 * c + 176 * c**3 - 404.1 * c**5 + 389.9 * c**7 - 140.3 * c**9), np.zeros(6)

    inertia, added = [0.26, 0.23, 0.37], [6.36, 7.12, 18.68, 0.189, 0.135, 0.222]
    linear, quadratic = np.diag([13.7, 0, 33, 0, 0.8, 0]), np.diag([141, 217, 190, 1.19, 0.47, 1.5])
    return Vehicle(13.5, 132.57, 131.588, [0, 0, 0], [0, 0, -0.01], inertia, added, linear, quadratic, np.zeros((6, 6)), held)


VEHICLES = {"lauv": lauv(), "bluerov2_heavy": bluerov2()}
INPUTS = {
    "lauv": [(0, 0, 9), (0.15, 0, 9), (-0.15, 0.1, 9), (0, -0.1, 12), (0.2, 0.05, 6), (0, 0, 9)],
    "bluerov2_heavy": [
        (0.15, 0.15, -0.15, -0.15, 0.05, 0.05, 0.05, 0.05),
        (0.15, 0.1, -0.1, -0.15, 0.05, 0.05, 0.05, 0.05),
        (0.1, 0.15, -0.15, -0.1, -0.05, -0.05, -0.05, -0.05),
        (0.15, -0.1, -0.1, 0.15, 0.1, 0.05, 0.05, 0.1),
        (-0.1, -0.1, 0.1, 0.1, 0, 0, 0, 0),
        (0,) * 8,
    ],
}


def start(k):
    """Position, attitude by roll 0.05, pitch -0.02, yaw 0.3, and a speed for each vehicle."""
    (cr, cp, cy), (sr, sp, sy) = np.cos([0.025, -0.01, 0.15]), np.sin([0.025, -0.01, 0.15])
    attitude = [cr * cp * cy + sr * sp * sy, sr * cp * cy - cr * sp * sy, cr * sp * cy + sr * cp * sy, cr * cp * sy - sr * sp * cy]
    k = np.asarray(k)
    ones = np.ones(k.shape)
    return np.array([0 * ones, 0 * ones, 5 * ones, *[q * ones for q in attitude], 0.5 + k / COUNT, 0.05 * ones, *[0 * ones] * 4])


def cross(a, b):
    return np.array([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])


def coriolis(inertia, nu):
    momentum = inertia @ nu
    return np.concatenate([cross(nu[3:], momentum[:3]), cross(nu[:3], momentum[:3]) + cross(nu[3:], momentum[3:])])


def rates(vehicle: Vehicle, tau, f, x):
    """The derivative of one state, or of a column for each vehicle."""
    a, b, c, d = x[3:7]
    nu, w = x[7:], x[10:]
    s = 2 / (a * a + b * b + c * c + d * d)
    r = np.array(
        [
            [1 - s * (c * c + d * d), s * (b * c - a * d), s * (b * d + a * c)],
            [s * (b * c + a * d), 1 - s * (b * b + d * d), s * (c * d - a * b)],
            [s * (b * d - a * c), s * (c * d + a * b), 1 - s * (b * b + c * c)],
        ]
    )
    current = r[0] * CURRENT[0] + r[1] * CURRENT[1] + r[2] * CURRENT[2]
    through = nu.copy()
    through[:3] -= current
    u, down = through[0], r[2]
    force = tau + u * (vehicle.lift @ through) + u * u * f
    force = force - coriolis(vehicle.rigid, nu) - coriolis(vehicle.added, through)
    force = force - vehicle.linear @ through - vehicle.quadratic @ (np.abs(through) * through)
    force[:3] += (vehicle.weight - vehicle.buoyancy) * down
    force[3:] += cross(vehicle.gravity, vehicle.weight * down) - cross(vehicle.buoyant, vehicle.buoyancy * down)
    force += vehicle.added[:, :3] @ cross(current, w)
    p, q, t = w
    turning = [-(b * p + c * q + d * t) / 2, (a * p + c * t - d * q) / 2, (a * q + d * p - b * t) / 2, (a * t + b * q - c * p) / 2]
    return np.concatenate([(r * nu[:3]).sum(axis=1), turning, vehicle.inverse @ force])


def adaptive(name: str, k: int, accuracy: float):
    """States at the ends of the segments. A call for each, since the inputs jump."""
    vehicle, x, ends = VEHICLES[name], start(k), []
    for inputs in INPUTS[name]:
        tau, f = vehicle.held(*inputs)
        way = solve_ivp(lambda _, x: rates(vehicle, tau, f, x), (0, SEGMENT), x, "DOP853", [SEGMENT], rtol=accuracy, atol=accuracy)
        x = way.y[:, -1]
        ends.append(x)
    return np.array(ends)


@cache
def truth(name: str, k: int):
    return adaptive(name, k, 1e-13)


def error(who: str, name: str, found) -> float:
    """Of the way of vehicle 0, or of those of all that are looked at."""
    found = np.array(found).reshape(-1, 6, 13)
    worst = 0.0
    for k, way in zip(SEEN, found):
        worst = max(worst, np.max(np.abs(way - truth(name, k)) / np.maximum(1, np.abs(truth(name, k)))))
    if not worst < AGREED:
        raise Missing(f"{who}: {name} is off by {worst:.1e}")
    return worst


def one(name: str) -> tuple[str, str]:
    return f"`{name}`, one vehicle at 1e-10 [ms]", f"`{name}`, one vehicle at 1e-10: error"


def many(name: str) -> tuple[str, str]:
    return f"`{name}`, a step of one of many [ns of CPU]", f"`{name}`, many vehicles: error"


def contenders():
    return {"planesman": ours, "scipy DOP853": scipy, "numpy": vectorised, "C++ RK4 at -O2": cpp}


def ours() -> dict[str, float]:
    text, costs = output([program("six_dof"), "--states"]), {}
    for name in VEHICLES:
        printed = {}
        for what in ("one vehicle at 1e-10", f"{COUNT} vehicles on 2 threads"):
            found = re.search(rf"^{name}, {what}, states: (.*)$", text, re.MULTILINE)
            printed[what] = error("planesman", name, json.loads(found[1]))
        (cost, error_of_one), (cost_of_many, error_of_many) = one(name), many(name)
        costs[cost] = seconds(f"{name}, one vehicle at 1e-10", text) * 1e3
        costs[error_of_one] = printed["one vehicle at 1e-10"]
        costs[cost_of_many] = seconds(f"{name}, {COUNT} vehicles on 2 threads", text) * 1e9
        costs[error_of_many] = printed[f"{COUNT} vehicles on 2 threads"]
    return costs


def scipy() -> dict[str, float]:
    costs = {}
    for name in VEHICLES:
        cost, error_of_one = one(name)
        costs[cost] = best(lambda: adaptive(name, 0, 1e-10), 3, time.process_time) * 1e3
        costs[error_of_one] = error("scipy", name, adaptive(name, 0, 1e-10))
    return costs


def vectorised() -> dict[str, float]:
    costs = {}
    for name, vehicle in VEHICLES.items():
        x, ends, begun = start(np.arange(COUNT)), [], time.process_time()
        for inputs in INPUTS[name]:
            tau, f = [held[:, None] for held in vehicle.held(*inputs)]
            for _ in range(STEPS):
                k1 = rates(vehicle, tau, f, x)
                k2 = rates(vehicle, tau, f, x + STEP / 2 * k1)
                k3 = rates(vehicle, tau, f, x + STEP / 2 * k2)
                k4 = rates(vehicle, tau, f, x + STEP * k3)
                x = x + STEP / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
                x[3:7] /= np.sqrt((x[3:7] ** 2).sum(axis=0))
            ends.append(x[:, SEEN])
        cost, error_of_many = many(name)
        costs[cost] = (time.process_time() - begun) / (len(INPUTS[name]) * STEPS * COUNT) * 1e9
        costs[error_of_many] = error("numpy", name, np.array(ends).transpose(2, 0, 1))
    return costs


@cache
def compiled() -> str:
    built = ROOT / "target/peers/six_dof"
    output(["g++", "-O2", "-std=c++17", "-o", built, HERE / "six_dof.cpp"])
    return str(built)


def cpp() -> dict[str, float]:
    costs = {}
    for name, vehicle in VEHICLES.items():
        parts = [vehicle.rigid, vehicle.added, vehicle.inverse, vehicle.linear, vehicle.quadratic, vehicle.lift]
        parts += [[vehicle.weight, vehicle.buoyancy], vehicle.gravity, vehicle.buoyant, CURRENT, start(0), [COUNT, STEPS, STEP]]
        parts += [[len(SEEN)], SEEN, [len(INPUTS[name])], *[held for inputs in INPUTS[name] for held in vehicle.held(*inputs)]]
        numbers = " ".join(repr(float(x)) for part in parts for x in np.ravel(part))
        found = json.loads(output([compiled()], input=numbers))
        cost, error_of_many = many(name)
        costs[cost], costs[error_of_many] = found["step"] * 1e9, error("C++", name, found["states"])
    return costs
