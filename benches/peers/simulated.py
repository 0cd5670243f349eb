"""Records to identify: an oscillating plant under steps of random length and size, with white noise on its output."""

from functools import cache
from pathlib import Path

import numpy as np
from scipy.signal import lfilter

from tools import ROOT

NOISE = 0.1
"""Standard deviation of the noise over that of the output."""


def plant(order: int) -> tuple[np.ndarray, np.ndarray]:
    """Numerator and denominator in powers of z^-1: pairs of poles at moduli and angles that lie apart, gain 1 at rest, one sample of delay."""
    den = np.array([1.0])
    for pair in range(order // 2):
        modulus, angle = 0.95 - 0.03 * pair, 0.15 * (pair + 1)
        den = np.convolve(den, [1.0, -2 * modulus * np.cos(angle), modulus**2])
    if order % 2:
        den = np.convolve(den, [1.0, -0.9])
    return np.array([0.0, den.sum()]), den


@cache
def record(samples: int, order: int, seed: int = 1988) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Input, output with noise, output without."""
    random = np.random.default_rng(seed)
    u = np.repeat(random.normal(size=samples), random.integers(2, 20, samples))[:samples]
    clean = lfilter(*plant(order), u)
    return u, clean + NOISE * clean.std() * random.normal(size=samples), clean


@cache
def table(samples: int, order: int) -> Path:
    """The record as a CSV file, 20 samples a second."""
    path = ROOT / f"target/peers/record-{samples}-{order}.csv"
    u, y, _ = record(samples, order)
    np.savetxt(path, np.column_stack([np.arange(samples) * 0.05, u, y]), delimiter=",", fmt="%.12g", header="time,u,y", comments="")
    return path


def error(simulate, order: int) -> float:
    """The error of a model's simulated output on another record without noise, |y - yhat| / |y - mean y| [%]."""
    u, _, clean = record(5000, order, seed=1966)
    simulated = np.ravel(simulate(u, clean))
    return 100 * np.linalg.norm((clean - simulated)[100:]) / np.linalg.norm((clean - clean.mean())[100:])
