"""A cylinder behind on/off valves beside scipy.

The problem is that of the bench `schedule` of planesman_circuit: the built-in circuit with a travel of 40 mm, six commands to its valves in
0.6 s, against rigid and against elastic stops. scipy integrates the same equations with solve_ivp, each halt, break-away and stop a terminal
event, restarted wherever a valve moves.
"""

import re
from functools import cache

import numpy as np
from scipy.integrate import solve_ivp

from tools import Missing, best, output, program

TITLE = "Circuit of on/off valves"
NOTE = "0.6 s under six commands; scipy is DOP853 at rtol 1e-8, with an event at each halt, break-away and stop, ours at 1e-8: both end within 3e-11 m of the truth."

ATMOSPHERE = 101325.0
MASS, VISCOUS, COULOMB, LOAD = 120.0, 900.0, 150.0, 500.0
AREAS, VOLUMES = (8.04e-4, 4.90e-4), (0.30e-3, 0.20e-3)
SUPPLY, TANK = 10e6, 0.3e6
BULK, AIR, POLYTROPIC = 1.4e9, 0.005, 1.4
RATED, LAMINAR, DELAY = 0.5e6, 5e4, 5e-3
TRAVEL, BREAK_AWAY = 0.04, COULOMB * (1 + 1e-10)
FLOWS = {"PA": 12, "AT": 12, "PB": 8, "BT": 8}  # L/min with all valves open
COMMANDS = [(0.0, 31, 0, 0, 31), (0.06, 9, 0, 0, 5), (0.15, 0, 0, 0, 0), (0.22, 0, 20, 17, 0), (0.34, 0, 31, 31, 0), (0.5, 3, 0, 0, 2)]
VARIANTS = {"rigid": (0.0, None), "elastic": (2000.0, (5e6, 2.0))}
"""Spring [N/m]; stiffness [N/m] and damping [s/m] of the stops."""


def bulk_modulus(p):
    absolute = p + ATMOSPHERE
    # A trial step of the integrator may lead below zero.
    air = AIR * (ATMOSPHERE / max(absolute, 1.0)) ** (1 / POLYTROPIC)
    return (1 + air) / (1 / BULK + air / (POLYTROPIC * absolute))


def root(drop):
    return drop / np.sqrt(np.sqrt(drop * drop + LAMINAR * LAMINAR))


class Cylinder:
    """[x, v, p_A, p_B] with what holds the ram."""

    def __init__(self, spring, stop):
        self.spring, self.stop = spring, stop
        x, b = 0.02, TANK + 0.5 * (SUPPLY - TANK)
        a = np.clip((b * AREAS[1] + LOAD + spring * x) / AREAS[0], TANK, SUPPLY)
        b = np.clip((a * AREAS[0] - LOAD - spring * x) / AREAS[1], TANK, SUPPLY)
        self.y, self.t = np.array([x, 0, a, b]), 0.0
        self.sliding = self.rests = self.contact = 0
        self.k = dict.fromkeys(FLOWS, 0.0)

    def net(self, y):
        x, v, a, b = y
        force = a * AREAS[0] - b * AREAS[1] - LOAD - self.spring * x
        if self.contact:
            stiffness, damping = self.stop
            depth = self.contact * x - TRAVEL
            force -= self.contact * stiffness * depth * max(0.0, 1 + damping * self.contact * v)
        return force

    def rates(self, _, y):
        x, v, a, b = y
        flow_a = self.k["PA"] * root(SUPPLY - a) + self.k["AT"] * root(TANK - a)
        flow_b = self.k["PB"] * root(SUPPLY - b) + self.k["BT"] * root(TANK - b)
        v = v if self.sliding else 0.0
        acceleration = (self.net(y) - VISCOUS * v - self.sliding * COULOMB) / MASS if self.sliding else 0.0
        return [
            v,
            acceleration,
            bulk_modulus(a) / (VOLUMES[0] + AREAS[0] * x) * (flow_a - AREAS[0] * v),
            bulk_modulus(b) / (VOLUMES[1] - AREAS[1] * x) * (flow_b + AREAS[1] * v),
        ]

    def margins(self):
        """What ends the present law: margins that fall through zero, and what then changes."""
        if self.rests:
            yield lambda _, y: BREAK_AWAY + self.rests * self.net(y), self.release
        elif not self.sliding:
            for side in (1, -1):
                yield lambda _, y, s=side: BREAK_AWAY - s * self.net(y), lambda s=side: setattr(self, "sliding", s)
        else:
            yield lambda _, y: self.sliding * y[1], self.halt
            if self.contact:
                yield lambda _, y: self.contact * y[0] - TRAVEL, lambda: setattr(self, "contact", 0)
            else:
                for side in (1, -1):
                    yield lambda _, y, s=side: TRAVEL - s * y[0], lambda s=side: self.meet(s)

    def halt(self):
        self.y[1] = 0.0
        force = self.net(self.y)
        self.sliding = int(np.sign(force)) if abs(force) > BREAK_AWAY else 0

    def meet(self, side):
        if self.stop:
            self.contact = side
        else:
            self.y[:2] = side * TRAVEL, 0.0
            self.sliding, self.rests = 0, side

    def release(self):
        self.sliding, self.rests = -self.rests, 0

    def run(self, until, rtol):
        while self.t < until:
            margins = list(self.margins())
            for margin, _ in margins:
                margin.terminal, margin.direction = True, -1
            part = solve_ivp(self.rates, (self.t, until), self.y, method="DOP853", rtol=rtol, atol=rtol * np.array([TRAVEL, 1, SUPPLY, SUPPLY]),
                             events=[margin for margin, _ in margins], max_step=5e-3)  # fmt: skip
            self.t, self.y = part.t[-1], part.y[:, -1].copy()
            if part.status == 1:
                next(change for (_, change), t in zip(margins, part.t_events) if len(t))()


def moved(variant, rtol=1e-8):
    """x after 0.6 s [m]."""
    cylinder = Cylinder(*VARIANTS[variant])
    for (time, *masks), after in zip(COMMANDS, [time for time, *_ in COMMANDS[1:]] + [0.6 - DELAY]):
        cylinder.run(time + DELAY, rtol)
        for (edge, flow), mask in zip(FLOWS.items(), masks):
            cylinder.k[edge] = flow / 6e4 / np.sqrt(RATED) * mask / 31
        cylinder.run(after + DELAY, rtol)
    return cylinder.y[0]


def contenders():
    return {"planesman": ours, "scipy DOP853": scipy}


@cache
def after() -> dict[str, float]:
    found = re.findall(r"^(\w+) at 1e-8: .* x = (\S+) m", output([program("schedule")]), re.MULTILINE)
    return {name: float(position) for name, position in found}


def ours() -> dict[str, float]:
    found = re.findall(r"^(\w+) at 1e-8: 0.6 s in ([\d.]+) us", output([program("schedule")]), re.MULTILINE)
    return {f"{name} [us]": float(time) for name, time in found}


def scipy() -> dict[str, float]:
    times = {}
    for name in VARIANTS:
        position = moved(name)
        if not np.isclose(position, after()[name], rtol=0, atol=6e-11):
            raise Missing(f"{name}: scipy ends at {position:.13f} m, ours at {after()[name]:.13f} m")
        times[f"{name} [us]"] = best(lambda: moved(name), 2) * 1e6
    return times
