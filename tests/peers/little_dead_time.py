#!/usr/bin/env python3
"""Records of ten plants with little dead time or none, of first to third order, some integrating: tables of a PRBS and the answer with 1 % noise.

    little_dead_time.py FOLDER

The plants are held and filtered by scipy. Prints one JSON object a plant: its file, gain, whether it integrates.
"""

import json
import sys
from pathlib import Path

import numpy as np
from scipy.signal import cont2discrete, lfilter

#       name       num             factors of the denominator      tick  duration  delay, ticks
PLANTS = [
    ("lag", [2.0], [[5, 1]], 0.05, 300, 0),
    ("negative", [-3.0], [[2, 1]], 0.02, 100, 0),
    ("two_lags", [2.0], [[5, 1], [1, 1]], 0.05, 300, 0),
    ("fast", [10.0], [[0.5, 1], [0.05, 1]], 0.01, 60, 0),
    ("two_lags_late", [1.0], [[4, 1], [0.8, 1]], 0.05, 300, 1),
    ("three_lags", [1.5], [[4, 1], [1, 1], [0.3, 1]], 0.05, 300, 0),
    ("with_lead", [2.0, 1.0], [[5, 1], [0.6, 1]], 0.05, 300, 0),
    ("integrator", [0.5], [[1, 0]], 0.05, 100, 0),
    ("motor", [8.0], [[0.12, 1], [1, 0]], 0.01, 30, 0),
    ("servo", [3.0], [[0.5, 1], [0.1, 1], [1, 0]], 0.02, 60, 0),
]


def main() -> None:
    folder = Path(sys.argv[1])
    random = np.random.default_rng(1)
    for name, num, factors, tick, duration, delay in PLANTS:
        den = [1.0]
        for factor in factors:
            den = np.polymul(den, factor)
        num_z, den_z, _ = cont2discrete((num, den), tick, method="zoh")
        count = int(duration / tick)
        # A slow half and a fast one.
        slow, fast = (np.repeat(random.choice([-1.0, 1.0], count // hold + 1), hold)[:count] for hold in (count // 60, count // 360))
        u = np.where(np.arange(count) < count // 2, slow, fast)
        driven = np.concatenate([np.zeros(delay), u[: count - delay]])
        y = lfilter(num_z.ravel(), den_z, driven)
        moved = y - np.polyval(np.polyfit(np.arange(count), y, 1), np.arange(count))
        y = y + 0.01 * np.std(moved) * random.standard_normal(count)
        path = folder / f"{name}.csv"
        with path.open("w") as file:
            file.write("time,u,y\n")
            file.writelines(f"{k * tick:.3f},{u[k]:g},{y[k]:.8g}\n" for k in range(count))
        integrates = den[-1] == 0
        print(json.dumps({"file": path.name, "gain": float(num[-1] / den[-2 if integrates else -1]), "integrates": bool(integrates)}))


if __name__ == "__main__":
    main()
