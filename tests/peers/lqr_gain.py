#!/usr/bin/env python3
"""The gain of `crates/vehicle/flight/examples/own_law.rs`, by scipy.

The vehicle is `brunner` at 1 ft/s from the thesis' numbers (`sampled_margins.py`), held over ticks of 0.05 s; the states are heave, pitch rate, pitch and
depth in m, rad and s. Minimised is `sum (z/0.05)^2 + (theta/0.3)^2 + (delta/0.2)^2`. Prints the gain as a JSON list.
"""

import json

import numpy as np
from sampled_margins import TICK, vehicle
from scipy.linalg import expm, solve_discrete_are

FOOT = 0.3048

to_metres = np.diag([FOOT, 1, 1, FOOT])
a, b = vehicle(1.0)
a = to_metres @ a @ np.linalg.inv(to_metres)
b = to_metres @ b.reshape(4, 1)
held = expm(np.block([[a, b], [np.zeros((1, 5))]]) * TICK)
a, b = held[:4, :4], held[:4, 4:]
p = solve_discrete_are(a, b, np.diag([0, 0, 0.3**-2, 0.05**-2]), [[0.2**-2]])
gain = np.linalg.solve(0.2**-2 + b.T @ p @ b, b.T @ p @ a)
print(json.dumps(gain[0].tolist()))
