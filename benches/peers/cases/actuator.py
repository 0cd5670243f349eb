"""One second of the slewing hydraulics beside scipy.

The problem is the first of the bench `second` of dha_actuator: a volume in every valve cycle, the direction changed every 20 cycles, for
one second. scipy integrates the same hybrid equations (IBM 66-L03-005, Section II.B) with solve_ivp, each change of law a terminal event,
restarted at every flow edge. Units are inches, pounds and seconds.
"""

import re
from dataclasses import dataclass
from functools import cache

import numpy as np
from scipy.integrate import solve_ivp

from tools import Missing, best, output, program

TITLE = "Hydraulic actuator"
NOTE = "one second of slewing; scipy is DOP853 at rtol 1e-10, with an event at each change of law. Each round is the best of 20 of ours, of 2 of scipy's."

TOLERANCES = {"method": "DOP853", "rtol": 1e-10, "atol": [1e-12, 1e-10, 1e-13]}
BREAK_AWAY, CLAMP = 1 + 1e-10, 1 + 1e-12


@dataclass
class Actuator:
    """The tables' symbols."""

    area: float
    mass: float
    viscous: float
    coulomb: float
    stiffness: float
    supply: float
    clamp_positive: float
    clamp_negative: float
    volume: float
    frequency: float
    valve_time: float
    flow_time: float
    rate_gain: float
    error_rate: float

    @property
    def leakage(self):
        return 2 * self.rate_gain / self.supply


DEGREE = np.radians(1) * 0.5 * 0.05  # the AUV's volume that moves its planes by a degree
ACTUATORS = {
    "auv": Actuator(0.05, 0.002, 2.0, 0.5, 2e5, 150, 50, 50,
                    0.5 * DEGREE, 80, 5.5e-3, 6e-3, 0.35 * DEGREE, -0.02 * DEGREE),
    "table_3_1": Actuator(0.994, 0.25, 12, 380, 26600, 2130, 540, 960,
                          0.152, 82.5, 5.5e-3, 10e-3, 0.107, -0.0165),
    "table_4_1": Actuator(1.00, 0.296, 12, 600, 26600, 2130, 750, 750,
                          0.152, 82.5, 5.5e-3, 10e-3, 0.107, -0.006),
}  # fmt: skip


def flow_pieces(a, signs):
    """(from, until, flow) of each stretch of constant flow."""
    edges = {0.0, len(signs) / a.frequency}
    for n in range(len(signs)):
        begin = n / a.frequency + a.valve_time
        edges |= {begin, begin + a.flow_time}
    edges = sorted(t for t in edges if t <= len(signs) / a.frequency)
    for begin, end in zip(edges, edges[1:]):
        middle, quanta, polarity = 0.5 * (begin + end), 0, 1
        for n, sign in enumerate(signs):
            since = middle - n / a.frequency - a.valve_time
            if since >= 0:
                polarity = sign
                quanta += sign * (since < a.flow_time)
        yield begin, end, quanta * a.volume / a.flow_time + polarity * a.rate_gain + a.error_rate


class Ram:
    """[x, v, w] with the friction latch (-1, 0, 1) and the clamp (-1, 0, 1)."""

    def __init__(self, actuator):
        self.actuator, self.state, self.sliding, self.clamped, self.calls = actuator, np.zeros(3), 0, 0, 0

    def pressure(self, w):
        a = self.actuator
        return min(max(a.stiffness * w, -a.clamp_negative), a.clamp_positive)

    def rates(self, _, y, flow):
        a, (_, v, w) = self.actuator, y
        self.calls += 1
        pressure = self.pressure(w)
        force = a.area * pressure - a.viscous * v - self.sliding * a.coulomb
        return [v, force / a.mass if self.sliding else 0.0, flow - a.leakage * pressure - a.area * v]

    def margins(self):
        """What ends the present law: margins that fall through zero, and what then changes."""
        a = self.actuator
        held = {1: a.clamp_positive / a.stiffness, -1: -a.clamp_negative / a.stiffness}
        if self.sliding:
            yield lambda t, y, _: self.sliding * y[1], self.halt
        else:
            for side in (1, -1):
                most = a.coulomb / (a.area * a.stiffness) * BREAK_AWAY
                yield lambda t, y, _, s=side, m=most: m - s * y[2], lambda s=side: setattr(self, "sliding", s)
        if self.clamped:
            side = self.clamped
            yield lambda t, y, _: side * (y[2] - held[side]), lambda: setattr(self, "clamped", 0)
        else:
            for side in (1, -1):
                yield (lambda t, y, _, s=side: s * (held[s] * CLAMP - y[2]),
                       lambda s=side: setattr(self, "clamped", s))  # fmt: skip

    def halt(self):
        self.state[1] = 0.0
        force = self.actuator.area * self.pressure(self.state[2])
        self.sliding = int(np.sign(force)) if abs(force) > self.actuator.coulomb * BREAK_AWAY else 0

    def run(self, begin, end, flow):
        while begin < end:
            margins = list(self.margins())
            for margin, _ in margins:
                margin.terminal, margin.direction = True, -1
            part = solve_ivp(self.rates, (begin, end), self.state, args=(flow,),
                             events=[margin for margin, _ in margins], **TOLERANCES)  # fmt: skip
            begin, self.state = part.t[-1], part.y[:, -1]
            if part.status == 1:
                next(change for (_, change), t in zip(margins, part.t_events) if len(t))()


def slew(actuator):
    cycles = int(actuator.frequency)
    ram = Ram(actuator)
    for piece in flow_pieces(actuator, [1 if (n + 10) % 40 < 20 else -1 for n in range(cycles)]):
        ram.run(*piece)
    return ram


def contenders():
    return {"planesman": ours, "scipy DOP853": scipy}


@cache
def after() -> dict[str, float]:
    """Where the rams of dha_actuator are after a second [in]."""
    found = re.findall(r"^(\w+): after .* X_1 = (\S+) in", output([program("second")]), re.MULTILINE)
    return {name: float(position) for name, position in found}


def ours() -> dict[str, float]:
    text = output([program("second")])
    found = {name: re.search(rf"^{name}: hydraulics slewing ([\d.]+) us", text, re.MULTILINE) for name in ACTUATORS}
    return {f"{name} [us]": float(time[1]) for name, time in found.items()}


def scipy() -> dict[str, float]:
    times = {}
    for name, actuator in ACTUATORS.items():
        ram = slew(actuator)
        if not np.isclose(ram.state[0], after()[name], rtol=0, atol=2e-9):
            raise Missing(f"{name}: scipy ends at {ram.state[0]:.9f} in, dha_actuator at {after()[name]:.9f} in")
        times[f"{name} [us]"] = best(lambda: slew(actuator), 2) * 1e6
    return times
