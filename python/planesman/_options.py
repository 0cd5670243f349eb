"""The options of `fit`, as the library declares them. This file is written by the test python_options::, which compares it."""

from __future__ import annotations

from collections.abc import Sequence
from os import PathLike
from typing import Literal, TypedDict

Path = str | PathLike[str]
Span = tuple[float | None, float | None]


class FitOptions(TypedDict, total=False):
    """The options of `fit` and `fit_all`: those of `planesman sysid fit`, of which docs/sysid.md says more."""

    stamp: Literal["header", "log"]
    """Time stamps: from the message headers, or from the recorder (log) [default: header if all messages have one]"""
    time: str
    """CSV column of time [default: time, t, stamp or timestamp, else a first column that increases from row to row]"""
    time_unit: Literal["s", "ms", "us", "ns", "min", "h", "d"]
    """Unit of the time column of a CSV file [default: the unit at the end of its name, such as t_ms; else s]"""
    sample_time: float | str
    """Interval between two rows of a CSV file without a time (s, or with its unit: 100ms)"""
    most_unpacked: int
    """Read at most this many MB (decompressed) of each file of a bag: a small file can unpack to thousands of times its size"""
    reference: str
    """Reference (setpoint) of the control loop, for closed-loop data: the model is then fitted in two stages"""
    rate: float
    """Sampling rate of the grid (Hz) [default: the rate of the slowest output]"""
    window: Span | Sequence[Span]
    """Use only data between these times, in seconds from the first output's first sample; each window is a separate run of the same model"""
    input_method: Literal["mean", "foh", "linear", "hold", "centred"]
    """Resampling of inputs"""
    output_method: Literal["mean", "foh", "linear", "hold", "centred"]
    """Resampling of outputs"""
    max_gap: float
    """Longest interval between two samples that is not a gap (s) [default: five sample intervals; no limit for a held input]"""
    unwrap: Literal["automatic", "2pi", "no"] | float
    """Angles and counters that wrap: unwrap if the jumps clearly come from wrapping (default), with this period, or not at all"""
    outliers: Literal["outputs", "report", "drop", "keep"]
    """Outliers: samples far from the median of their neighbours"""
    prefilter: Span
    """Frequency band to keep in every signal: LOW..HIGH, LOW.. to remove drift, or ..HIGH to remove noise (Hz) [default: all]"""
    segment: Literal["all", "auto"]
    """Part of the data to use"""
    detrend: Literal["none", "mean", "line"]
    """Mean or trend to subtract from each signal"""
    validation: Path | Span
    """Validation data, not used for the fit: a file or folder with the same signals, or a window of the data as in `window`, which is then
    left out of the fit [default: a model of the first 70 % is validated on the rest]"""
    method: Literal["automatic", "output_error", "box_jenkins", "armax", "least_squares", "n4sid", "fir", "process", "frf", "recursive_least_squares", "extended_least_squares", "recursive_prediction_error", "recursive_output_error", "vehicle", "kalman", "all"]
    """The estimator"""
    order: int
    """Order of the model (of its denominator), without known poles; 0 for a static gain; for fir the number of coefficients [default:
    searched from 1 to 10; from 1 to 4 with a named method; up to 64 for fir]"""
    process: Literal["1", "2", "2u", "i", "1i"]
    """Form of a process model, for `method="process"` [default: chosen by the Bayesian criterion]"""
    coherence: float
    """For `method="frf"`: the lowest coherence of input and output in the band of the fit [default: 0.6]"""
    numerator: int
    """Coefficients of the numerator, without known zeros [default: the same number as the order]"""
    delay: int
    """Delay in samples from the input to its first effect; 0 if the output is measured after the input of the same sample [default:
    searched from 0 to 1000; with a named method 1 to 3, or 1 with `order`]"""
    zeros_at_one: int
    """Number of zeros known to be at z = 1"""
    integrators: int
    """Number of poles known to be at z = 1"""
    no_offset: bool
    """The output has no offset"""
    at_rest: bool
    """The data begins at rest [default: the initial state is estimated]"""
    prewindow: bool
    """Input and output are zero before each segment (the thesis' start): zeros are inserted before it"""
    own_numerators: bool
    """Each segment has its own numerator; only the poles are common"""
    heave: Sequence[float]
    """For vehicle and kalman, the coefficients of heave in q_dot = K/J u - B/J q - M_theta/J theta + NU w, w_dot = EPSILON u + ETA q - ZETA
    w, with w in the output's unit times m [default: no heave]"""
    vehicle: str
    """Take the heave coefficients from a built-in vehicle or a vehicle file, at `speed`: for planes in rad, a rate in rad/s"""
    heave_doubt: float
    """Standard deviation of the heave coefficients, in % of each"""
    speed: float | str
    """The vehicle's speed (m/s, or with its unit: 1ft/s), for `vehicle` and the model file"""
    inertia: float
    """Moment of inertia J; if given, K, B and M_theta are printed"""
    noise: float
    """For kalman: standard deviation of the noise, output unit [default: from second differences]"""
    bias_drift: float
    """For kalman: standard deviation of the sensor's bias drift in one second, output unit"""
    disturbance: float
    """For kalman: standard deviation of the output's change by disturbances in one second, output unit"""
    forgetting: float
    """For recursive methods: forgetting factor per sample (1: no forgetting; 0.98: a memory of about 50 samples) [default: 1]"""
    initial_covariance: float
    """For recursive methods: initial covariance of each parameter [default: 1e8]"""
    bootstrap: int
    """Also compute 95 % intervals of poles and gain by a bootstrap: fit this many records simulated with the model and its residuals"""
    curve: Literal["automatic", "none", "dead_zone", "saturation", "square", "piecewise", "backlash", "output_dead_zone", "output_saturation", "output_piecewise"]
    """Static curve before the dynamics (Hammerstein) or after them (Wiener)"""
