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
    """Time stamps: of the message headers, or of the recorder (log) [default: header if all messages have one]"""
    time: str
    """CSV column of time [default: time, t, stamp or timestamp, else a first column that rises from row to row]"""
    time_unit: Literal["s", "ms", "us", "ns", "min", "h", "d"]
    """Unit of the time column of a CSV file [default: the one that its name ends in, as t_ms; else s]"""
    sample_time: float | str
    """Interval between two rows of a CSV file without a time (s, or with its unit: 100ms)"""
    most_unpacked: int
    """Read of each file of a bag at most so many MB once it is unpacked: a small file can unpack to thousands of times its size"""
    reference: str
    """Reference (setpoint) of the control loop, for closed-loop data: the model is then fitted in two stages"""
    rate: float
    """Sampling rate of the grid (Hz) [default: that of the slowest output]"""
    window: Span | Sequence[Span]
    """Use only data between these times, in seconds from the first output's first sample; several windows are runs of one model"""
    input_method: Literal["mean", "foh", "linear", "hold", "centred"]
    """Resampling of inputs"""
    output_method: Literal["mean", "foh", "linear", "hold", "centred"]
    """Resampling of outputs"""
    max_gap: float
    """Longest interval between two samples that is not a gap (s) [default: five sample intervals; none for a held input]"""
    unwrap: Literal["automatic", "2pi", "no"] | float
    """Angles and counters that wrap: unwrapped where the jump is unmistakable, with this period, or not"""
    outliers: Literal["outputs", "report", "drop", "keep"]
    """Outliers: samples far from the median of those around them"""
    prefilter: Span
    """Band of frequencies that is used, of every signal: LOW..HIGH, or LOW.. against drift, or ..HIGH against noise (Hz) [default: all]"""
    segment: Literal["all", "auto"]
    """Which data is used"""
    detrend: Literal["none", "mean", "line"]
    """What is subtracted from each signal"""
    validation: Path | Span
    """Data to judge the model on, of which nothing is fitted: a file or folder with the same signals, or a window of the data as in
    `window`, which is then left out of the fit [default: a model of the first seven tenths is judged on the rest]"""
    method: Literal["automatic", "output_error", "box_jenkins", "armax", "least_squares", "n4sid", "fir", "process", "frf", "recursive_least_squares", "extended_least_squares", "recursive_prediction_error", "recursive_output_error", "vehicle", "kalman", "all"]
    """The estimator"""
    order: int
    """Order of the model (of its denominator), known poles not counted, 0 for a static gain; for fir the number of coefficients [default:
    searched, 1 to 10; 1 to 4 for a method that is named; up to 64 for fir]"""
    process: Literal["1", "2", "2u", "i", "1i"]
    """Form of a process model, for `method="process"` [default: chosen by the Bayesian criterion]"""
    coherence: float
    """For `method="frf"`: the least coherence of input and output in the band that the model is fitted in [default: 0.6]"""
    numerator: int
    """Coefficients of the numerator, known zeros not counted [default: as many as the order]"""
    delay: int
    """Delay in samples from the input to its first effect, 0 where the output is measured after the input of the same sample [default:
    searched, 0 to 1000; for a method that is named 1 to 3, 1 with `order`]"""
    zeros_at_one: int
    """Number of zeros known to be at z = 1"""
    integrators: int
    """Number of poles known to be at z = 1"""
    no_offset: bool
    """The output has no offset"""
    at_rest: bool
    """The data begins at rest [default: the initial state is estimated]"""
    prewindow: bool
    """Input and output are zero before each segment (the thesis' start): zeros are put in front of it"""
    own_numerators: bool
    """Each segment has its own numerator; only the poles are common"""
    heave: Sequence[float]
    """For vehicle and kalman, q_dot = K/J u - B/J q - M_theta/J theta + NU w, w_dot = EPSILON u + ETA q - ZETA w: NU,ZETA,ETA,EPSILON, with
    w in the output's unit times m [default: no heave]"""
    vehicle: str
    """The same from a built-in vehicle or a vehicle file, at `speed`: for planes in rad, a rate in rad/s"""
    heave_doubt: float
    """Standard deviation of the heave coefficients, in % of each"""
    speed: float | str
    """The vehicle's speed (m/s, or with its unit: 1ft/s), for `vehicle` and the model file"""
    inertia: float
    """Moment of inertia J; K, B and M_theta are printed with it"""
    noise: float
    """For kalman: standard deviation of the noise, output unit [default: from second differences]"""
    bias_drift: float
    """For kalman: standard deviation of the sensor's bias drift in one second, output unit"""
    disturbance: float
    """For kalman: standard deviation of the output's change by disturbances in one second, output unit"""
    forgetting: float
    """For recursive methods: forgetting factor per sample (1: none; 0.98: a memory of about 50 samples) [default: 1]"""
    initial_covariance: float
    """For recursive methods: initial covariance of each parameter [default: 1e8]"""
    bootstrap: int
    """95 % intervals of poles and gain by a bootstrap as well: fit so many records simulated with the model and its residuals"""
    curve: Literal["automatic", "none", "dead_zone", "saturation", "square", "piecewise", "backlash", "output_dead_zone", "output_saturation", "output_piecewise"]
    """Static curve in front of the dynamics (Hammerstein) or behind them (Wiener)"""
