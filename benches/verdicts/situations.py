"""The situations, as data: a plant, what moves it, what disturbs it, how it is logged, how many samples. `CROSSES` says which meet."""

from dataclasses import dataclass
from itertools import product


@dataclass(frozen=True)
class Plant:
    """`num/den` in powers of s (s, the highest first) behind a delay of so many samples, with what is beside it."""

    num: tuple
    den: tuple
    interval: float
    """Sampling interval, s: a tenth to a thirtieth of the slowest time constant."""
    delay: int = 0
    curve: tuple = ()
    """Side, kind and parameters of a static curve, named as a model file of planesman names them."""
    friction: float = 0.0
    """Dry friction in units of the input, of a first-order plant: `T v' = u - v - friction sign(v)`."""
    controller: tuple = ()
    """Proportional gain and integral gain (1/s) of the loop around it."""
    other: tuple = ()
    """`num` and `den` from a second input, `v`."""


LAG = (1.0,), (1.2, 1.0), 0.1
PLANTS = {
    "static gain": Plant((2.0,), (1.0,), 0.1),
    "static gain, delay": Plant((2.0,), (1.0,), 0.1, 4),
    "first order": Plant((1.0,), (2.0, 1.0), 0.1),
    "first order, delay": Plant((1.0,), (1.5, 1.0), 0.1, 7),
    "two lags": Plant((3.0,), (1.2, 2.6, 1.0), 0.1),
    "oscillating": Plant((2.0,), (1.0, 1.2, 4.0), 0.1),
    "lightly damped": Plant((2.0,), (1.0, 0.2, 4.0), 0.2),
    "right-half-plane zero": Plant((-1.0, 2.0), (1.0, 2.0, 2.0), 0.1),
    "zero near pole": Plant((11.0, 2.0), (2.5, 5.5, 1.0), 0.2),
    "near poles": Plant((1.1,), (1.0, 2.1, 1.1), 0.1),
    "third order": Plant((7.5,), (1.0, 7.0, 10.75, 3.75), 0.1),
    "two resonances": Plant((2.0, 1.0, 18.0), (1.0, 0.8, 13.2, 4.0, 36.0), 0.1),
    "fifth order": Plant((32.0,), (1.0, 3.3, 23.0, 31.6, 74.4, 32.0), 0.1),
    "integrator": Plant((0.5,), (1.0, 0.0), 0.1),
    "integrator with a lag": Plant((1.0,), (1.0, 1.0, 0.0), 0.1),
    "PI loop, first order": Plant((2.0,), (3.0, 1.0), 0.1, controller=(2.0, 1.2)),
    "PI loop, delay": Plant((1.0,), (1.5, 1.0), 0.1, 4, controller=(1.0, 0.6)),
    "PI loop, two lags": Plant((3.0,), (1.2, 2.6, 1.0), 0.1, controller=(1.0, 0.5)),
    "P loop, integrator": Plant((0.5,), (1.0, 0.0), 0.1, controller=(1.5, 0.0)),
    "P loop, unstable": Plant((1.0,), (1.0, -0.5), 0.1, controller=(2.0, 0.0)),
    "dead zone": Plant(*LAG, curve=("input", "dead zone", {"lower": -0.3, "upper": 0.2})),
    "saturation": Plant(*LAG, curve=("input", "saturation", {"lower": -0.5, "upper": 0.6})),
    "square law": Plant(*LAG, curve=("input", "square law", {})),
    "two slopes": Plant(*LAG, curve=("input", "piecewise linear", {"level 1": 0.1, "slope 2": 0.4})),
    "backlash": Plant(*LAG, curve=("input", "backlash", {"width": 0.4})),
    "output saturation": Plant(*LAG, curve=("output", "saturation", {"lower": -0.6, "upper": 0.5})),
    "output dead zone": Plant(*LAG, curve=("output", "dead zone", {"lower": -0.2, "upper": 0.3})),
    "dry friction": Plant(*LAG, friction=0.25),
    "two inputs": Plant(*LAG, other=((-0.5,), (0.6, 1.0))),
    "two inputs, second order": Plant((2.0,), (1.0, 1.2, 4.0), 0.1, other=((0.6,), (2.0, 1.0))),
}

OPEN = [
    "one step",
    "few steps",
    "many steps",
    "PRBS",
    "multisine",
    "chirp",
    "ramps",
    "smooth",
    "impulse",
    "impulse in row 1",
]
LOOP = ["one setpoint step", "setpoint steps", "setpoint PRBS", "feedback alone"]
PERIODIC = ["triangle", "square behind a servo"]
WELL_EXCITED = ["many steps", "PRBS", "multisine", "setpoint PRBS"]
NOISES = ["none", "white", "white 15 %", "AR(0.9)", "AR(0.97)"]
DISTURBANCES = ["sine", "daily", "unrecorded steps", "drift"]
LOGS = ["plain", "quantised", "clipped", "digits lost", "held", "jitter"]
LENGTH = 500

LINEAR = [name for name, it in PLANTS.items() if not (it.curve or it.friction or it.controller or it.other)]
LOOPS = [name for name, it in PLANTS.items() if it.controller]
CURVED = [name for name, it in PLANTS.items() if it.curve or it.friction]
SEVERAL = [name for name, it in PLANTS.items() if it.other]
FEW = ["first order", "first order, delay", "two lags", "oscillating"]

# Plants, inputs, noises, logs, lengths.
CROSSES = [
    (LINEAR, OPEN, ["none"], ["plain"], [LENGTH]),
    (LINEAR, ["few steps", "PRBS"], NOISES[1:], ["plain"], [LENGTH]),
    (FEW, ["few steps", "many steps", "multisine"], DISTURBANCES, ["plain"], [LENGTH]),
    (FEW, ["few steps", "PRBS"], ["white"], LOGS[1:], [LENGTH]),
    (["first order", "oscillating"], ["one step", "many steps"], ["none"], LOGS[1:], [LENGTH]),
    (["first order", "two lags", "third order"], ["few steps", "PRBS"], ["white", "AR(0.9)"], ["plain"], [30, 100, 3000]),
    (["first order"], ["many steps"], ["no effect"], ["plain"], [30, 100, LENGTH]),
    (["oscillating"], ["PRBS", "many steps"], ["white"], ["plain"], [10_000]),
    (["first order", "two lags"], ["many steps"], ["AR(0.9)"], ["plain"], [100_000]),
    (FEW, PERIODIC, ["none", "white"], ["plain"], [LENGTH, 3000]),
    (LOOPS, LOOP[:3], ["none", "white", "white 15 %", "AR(0.97)"], ["plain"], [LENGTH]),
    (LOOPS, LOOP[3:], ["white", "AR(0.97)"], ["plain", "quantised"], [LENGTH]),
    (CURVED, ["few steps", "many steps", "multisine"], ["none", "white"], ["plain"], [LENGTH]),
    (SEVERAL, ["few steps", "many steps", "PRBS"], ["none", "white", "AR(0.9)"], ["plain"], [LENGTH]),
]


@dataclass(frozen=True)
class Situation:
    """One cell of the crosses."""

    plant: str
    input: str
    noise: str
    log: str
    samples: int

    def __str__(self):
        return " | ".join(map(str, (self.plant, self.input, self.noise, self.log, self.samples)))


ALL = [Situation(*cell) for cross in CROSSES for cell in product(*cross)]

# What a message may name of a record that has it. "not linear" is what curves share, "disturbance" something that is not recorded.
IN_RECORD = {
    "dead zone": {"dead zone", "not linear"},
    "saturation": {"saturation", "not linear"},
    "square law": {"square law", "not linear"},
    "piecewise linear": {"not linear"},
    "backlash": {"backlash", "not linear"},
    "friction": {"friction", "not linear"},
    "clipped": {"saturation", "not linear"},
    "quantised": {"quantised"},
    "digits lost": {"clock"},
    "jitter": {"clock"},
    "held": {"clock"},
    "sine": {"disturbance"},
    "daily": {"disturbance", "drift"},
    "unrecorded steps": {"disturbance"},
    "drift": {"disturbance", "drift"},
    "no effect": {"disturbance"},
}


def causes(situation):
    """The causes that a message may name of such a record."""
    plant = PLANTS[situation.plant]
    present = [situation.noise, situation.log, *([plant.curve[1]] if plant.curve else []), *(["friction"] if plant.friction else [])]
    found = set().union(*(IN_RECORD.get(it, set()) for it in present))
    if plant.controller:
        found |= {"closed loop"} | ({"feedback alone"} if situation.input == "feedback alone" else set())
    return found
