"""Models identified from recorded data."""

from __future__ import annotations

import html
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from os import PathLike
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from planesman import _native, _tables
from planesman._arguments import check_names, keywords, path_text, paths, text
from planesman._options import FitOptions, Path
from planesman._progress import Progress
from planesman.data import Samples
from planesman.simulation import Form, of_control

if TYPE_CHECKING:
    import matplotlib.figure
    from typing_extensions import Unpack

Data = Path | Sequence[Path] | Mapping[str, Any]

# Standard deviations of a 95 % interval.
_95 = 1.959964


@dataclass(frozen=True)
class Uncertainty:
    """How sure a model is: standard deviations. Complex arrays have that of the real part and, as imaginary part, that of the
    imaginary part."""

    covariance: NDArray[np.float64]
    """Of the coefficients of `den` after its 1, then of `num`; shape (n, n)."""
    poles: NDArray[np.complex128]
    """Of `Model.poles`."""
    continuous_poles: NDArray[np.complex128]
    """Of `Model.continuous_poles`, 1/s."""
    zeros: NDArray[np.complex128]
    """Of `Model.zeros`."""
    steady_state_gain: float | None
    """Standard deviation of `Model.steady_state_gain`, output per input."""
    parameters: dict[str, float]
    """Standard deviations of `Model.parameters`."""
    bootstrap: dict[str, Any] | None
    """95 % intervals by a bootstrap, if requested."""


@dataclass(frozen=True)
class FrequencyResponse:
    """A frequency response with its uncertainty; all arrays have the shape of `omega`."""

    omega: NDArray[np.float64]
    """Frequencies, rad/s."""
    value: NDArray[np.complex128]
    """Output per input; NaN where it is infinite."""
    magnitude_deviation: NDArray[np.float64]
    """Standard deviation of the magnitude, output per input."""
    phase_deviation: NDArray[np.float64]
    """Standard deviation of the phase, rad."""


class Model:
    """An identified model: a sampled transfer function with its uncertainty, tests and a verdict.

    Lists of coefficients begin with the highest power; `den` begins with 1, and a delay gives leading zeros of `num`.
    """

    def __init__(self, report: Mapping[str, Any], record: Mapping[str, NDArray[np.float64]] | None = None) -> None:
        self.report: dict[str, Any] = dict(report)
        """The complete output of `planesman sysid fit --json`; for a model file only `model`."""
        self.record: dict[str, NDArray[np.float64]] | None = None if record is None else dict(record)
        """The longest run on the grid: `time` (s), `input`, `measured`, `simulated`; None for a model from a file."""

    @classmethod
    def load(cls, path: Path) -> Model:
        """Read a model file, `*.json` or `*.yaml`, written by `save` or `planesman sysid fit --model`."""
        return cls({"model": json.loads(_native.read_model(path_text(path)))})

    def save(self, path: Path) -> None:
        """Write a model file, `*.json` or `*.yaml`, for the simulator, the controller, MATLAB or `load`."""
        _native.write_model(json.dumps(self._model), path_text(path))

    @property
    def _model(self) -> dict[str, Any]:
        model: dict[str, Any] = self.report["model"]
        return model

    @property
    def input(self) -> str:
        """Name of the input signal."""
        return str(self._model["input"])

    @property
    def output(self) -> str:
        """Name of the output signal."""
        return str(self._model["output"])

    @property
    def method(self) -> str:
        """The estimator."""
        return str(self._model["method"])

    @property
    def sample_time(self) -> float:
        """Sampling interval, s."""
        return float(self._model["sample_time"])

    @property
    def num(self) -> NDArray[np.float64]:
        """Numerator in z."""
        return np.array(self._model["num"])

    @property
    def den(self) -> NDArray[np.float64]:
        """Denominator in z."""
        return np.array(self._model["den"])

    @property
    def order(self) -> int:
        """Number of poles."""
        return len(self._model["den"]) - 1

    @property
    def poles(self) -> NDArray[np.complex128]:
        """Poles in z; shape (order,)."""
        return _complex(self._model["poles"])

    @property
    def continuous_poles(self) -> NDArray[np.complex128]:
        """Poles in s, 1/s, without poles at z = 0."""
        return _complex(self._model["continuous_poles"])

    @property
    def zeros(self) -> NDArray[np.complex128]:
        """Zeros in z."""
        return _complex(self._model["zeros"])

    @property
    def steady_state_gain(self) -> float | None:
        """Steady-state gain, output per input; None with a pole at z = 1."""
        gain = self._model["steady_state_gain"]
        return None if gain is None else float(gain[0])

    @property
    def fit(self) -> float | None:
        """Simulated fit on the data, %."""
        fit: float | None = self._model["fit"]
        return fit

    @property
    def held_out_fit(self) -> float | None:
        """Simulated fit on held-out data, %."""
        fit: float | None = self._model["held_out_fit"]
        return fit

    @property
    def parameters(self) -> dict[str, float]:
        """Parameters by name: K, T1, ... of a process model; b0, a0, ... of a model in s; K/J, ... of the vehicle methods."""
        return {found["name"]: found["value"] for found in self.report.get("parameters", [])}

    @property
    def curve(self) -> dict[str, Any] | None:
        """Static curve at the input or output: side, kind, parameters with deviations; None for a linear model. All other attributes describe the linear part."""
        return self.report.get("curve")

    @property
    def verdict(self) -> list[str]:
        """Sentences on fit, residuals and uncertainty of the model; the last one is the next step."""
        return list(self._model["verdict"])

    @property
    def standing(self) -> str:
        """The verdict in a word: `good`, `usable`, `usable_with_care`, `not_validated` or `not_usable`; empty for a model without a verdict."""
        judgement = self._model.get("judgement")
        return str(judgement["standing"]) if judgement else ""

    @property
    def uncertainty(self) -> Uncertainty:
        """Standard deviations of all estimates."""
        model = self._model
        return Uncertainty(
            covariance=np.array([row or [0.0] * len(model["covariance"]) for row in model["covariance"]]),
            poles=_complex(model["poles"], "_deviation"),
            continuous_poles=_complex(model["continuous_poles"], "_deviation"),
            zeros=_complex(model["zeros"], "_deviation"),
            steady_state_gain=None if model["steady_state_gain"] is None else float(model["steady_state_gain"][1]),
            parameters={found["name"]: found["deviation"] for found in self.report.get("parameters", [])},
            bootstrap=self.report.get("bootstrap"),
        )

    @property
    def noise_variance(self) -> float:
        """Variance of the white noise e that drives `noise_model`, output unit squared."""
        return float(self._model["noise_variance"])

    def noise_model(self, *, form: Form = "tf") -> Any:
        """The noise model as a discrete transfer function of python-control, from white noise `e` of variance `noise_variance` to the output;
        None if the method has no noise model: only armax, box_jenkins and their recursive forms have one."""
        shaping, denominator = self._model["noise_model"], self._model["noise_denominator"]
        den = [1.0, *denominator] if denominator else list(self._model["den"])
        if not shaping and not denominator:
            return None
        num = [1.0, *shaping]
        length = max(len(num), len(den))
        num, den = ([*of, *[0.0] * (length - len(of))] for of in (num, den))
        return of_control(num, den, self.sample_time, "e", self.output, form)

    def to_control(self, *, continuous: bool = False, form: Form = "tf") -> Any:
        """The model as a transfer function of python-control, discrete or in s; as state space with `form="ss"`. Input and output are named.

        The model in s assumes a zero-order hold at the input. A model with a delay, or with a pole without a continuous counterpart,
        is refused there.
        """
        if not continuous:
            return of_control(self.num, self.den, self.sample_time, self.input, self.output, form)
        found = self._model["continuous"]
        if found is None:
            raise _native.PlanesmanError("a pole of the model has no continuous counterpart; to_control() returns the discrete model")
        if found["delay"] != 0.0:
            raise _native.PlanesmanError(
                f"the model in s has a delay of {found['delay']:g} s, which a transfer function in s cannot represent; "
                "to_control() returns the discrete model with the delay"
            )
        return of_control(found["num"], found["den"], 0, self.input, self.output, form)

    def frequency_response(self, omega: Any = None) -> FrequencyResponse:
        """The frequency response at `omega`, rad/s; by default at 200 frequencies up to the Nyquist frequency."""
        if omega is None:
            omega = np.pi / self.sample_time * np.logspace(-3.5, 0.0, 200)
        omega = np.atleast_1d(_real("omega", omega))
        most = np.pi / self.sample_time
        beyond = omega[~(np.abs(omega) <= most * (1.0 + 1e-12))]
        if beyond.size:
            raise _native.PlanesmanError(
                f"omega: {beyond.flat[0]:g} rad/s refused: a model with the sampling interval {self.sample_time:g} s is valid only up "
                f"to its Nyquist frequency, {most:g} rad/s"
            )
        return FrequencyResponse(omega, *_native.response(json.dumps(self._model), omega.tobytes()))

    def plot(self) -> matplotlib.figure.Figure:
        """Plot measured and simulated output, residuals, poles and zeros with their deviations, and the frequency response with
        its 95 % band. A model from a file has no data and no residuals."""
        import matplotlib.pyplot as plt

        tests = self.report.get("residuals")
        rows = [self._plot_data] if self.record is not None else []
        figure = plt.figure(figsize=(10.0, 4.0 + 2.5 * (len(rows) + bool(tests))), layout="constrained")
        grid = figure.add_gridspec(len(rows) + bool(tests) + 2, 2)
        for row, plot in enumerate(rows):
            plot(figure.add_subplot(grid[row, :]))
        if tests:
            names = {"whiteness": "residual autocorrelation", "input": "cross-correlation of residual and input"}
            for column, (name, title) in enumerate(names.items()):
                _plot_correlation(figure.add_subplot(grid[len(rows), column]), tests[name], title)
        below = len(rows) + bool(tests)
        self._plot_map(figure.add_subplot(grid[below:, 0]))
        magnitude = figure.add_subplot(grid[below, 1])
        self._plot_response(magnitude, figure.add_subplot(grid[below + 1, 1], sharex=magnitude))
        figure.suptitle(f"{self.input} to {self.output}: {self.method}, order {self.order}")
        return figure

    def _plot_data(self, axes: Any) -> None:
        record = self.record or {}
        axes.plot(record["time"], record["measured"], label="measured")
        label = "simulated" if self.fit is None else f"simulated, fit {self.fit:.1f} %"
        axes.plot(record["time"], record["simulated"], label=label)
        axes.set(xlabel="time [s]", ylabel=self.output)
        axes.legend()

    def _plot_map(self, axes: Any) -> None:
        angle = np.linspace(0.0, 2.0 * np.pi, 121)
        axes.plot(np.cos(angle), np.sin(angle), "k--", linewidth=0.8)
        for places, deviations, mark in [
            (self.poles, self.uncertainty.poles, "x"),
            (self.zeros, self.uncertainty.zeros, "o"),
        ]:
            near = np.abs(places) < 4.0
            label = "poles" if mark == "x" else "zeros"
            axes.errorbar(
                places[near].real,
                places[near].imag,
                xerr=np.minimum(_95 * deviations[near].real, 4.0),
                yerr=np.minimum(_95 * deviations[near].imag, 4.0),
                fmt=mark,
                markerfacecolor="none",
                label=label,
            )
        axes.set(title="poles and zeros, 95 %", xlabel="real part", ylabel="imaginary part", aspect="equal")
        axes.legend()

    def _plot_response(self, magnitude: Any, phase: Any) -> None:
        found = self.frequency_response()
        size = np.abs(found.value)
        turn = np.degrees(np.unwrap(np.angle(found.value)))
        off = _95 * found.magnitude_deviation
        magnitude.loglog(found.omega, size)
        magnitude.fill_between(found.omega, np.maximum(size - off, 1e-3 * size), size + off, alpha=0.3)
        off = np.degrees(np.minimum(_95 * found.phase_deviation, np.pi))
        phase.semilogx(found.omega, turn)
        phase.fill_between(found.omega, turn - off, turn + off, alpha=0.3)
        magnitude.set(title="frequency response, 95 %", ylabel="magnitude")
        magnitude.tick_params(labelbottom=False)
        phase.set(xlabel="frequency [rad/s]", ylabel="phase [deg]")

    def _repr_html_(self) -> str:
        rows = []
        for pole, off in zip(self.continuous_poles, self.uncertainty.continuous_poles):
            size = abs(pole)
            means = f"decays in {-1.0 / pole.real:.4g} s" if pole.real < 0.0 else "does not decay"
            if pole.imag != 0.0:
                means = f"natural frequency {size:.4g} rad/s, damping ratio {-pole.real / size:.3g}"
            imaginary = _plus_minus(pole.imag, off.imag) if pole.imag != 0.0 else ""
            rows.append([_plus_minus(pole.real, off.real), imaginary, means])
        if self.steady_state_gain is not None:
            rows.append([_plus_minus(self.steady_state_gain, self.uncertainty.steady_state_gain or 0.0), "", "steady-state gain"])
        heads = ["pole [1/s], real part", "imaginary part", "what it does"]
        table = _tables.of_rows(heads, rows, "± : 95 %", whole=True)
        *reasons, verdict = self.verdict or [""]
        listed = "".join(f"<li>{html.escape(sentence)}</li>" for sentence in reasons)
        return f"<p><b>{html.escape(repr(self))}</b><br>{html.escape(verdict)}</p>{table}<ul>{listed}</ul>"

    def __repr__(self) -> str:
        fit = "" if self.fit is None else f", fit {self.fit:.1f} %"
        standing = self.standing.replace("_", " ") or "not judged"
        return f"{standing}: model from {self.input} to {self.output}, {self.method}, order {self.order}, {self.sample_time:g} s{fit}"


def _plus_minus(value: float, deviation: float) -> str:
    return f"{value:.4g} ± {_95 * deviation:.2g}"


def _complex(places: Sequence[Mapping[str, float]], of: str = "") -> NDArray[np.complex128]:
    return np.array([complex(place[f"re{of}"], place[f"im{of}"]) for place in places], dtype=np.complex128)


def _plot_correlation(axes: Any, found: Mapping[str, Any], title: str) -> None:
    lags, values = np.array(found["values"]).T
    axes.stem(lags, values, markerfmt=".")
    axes.axhspan(-found["bound"], found["bound"], alpha=0.2)
    axes.set(title=f"{title}, 99 %", xlabel="lag [samples]")


def fit(data: Data, input: str, output: str, *, progress: bool | None = None, **options: Unpack[FitOptions]) -> Model:
    """Identify the model from one signal to another, with uncertainty, tests and a verdict, as `planesman sysid fit` does.

    `data` is a path as for `read_bag`, with fields `input` and `output`; several bags are several experiments of one model. Or the data
    is in memory: arrays by name, each of shape (n,), as a dict, a pandas DataFrame or a `Flight`, or the result of `read_bag`. For arrays
    the time is the array `time` or `t` (s), or the index of a DataFrame, or `sample_time` (s) gives the interval. NaN is a
    missing sample. In a result of `read_bag` a list field has only its first number. By default, order, delay and method are chosen by cross-validation; `FitOptions` lists all options.

    >>> model = fit("bag", "plane_motion:dive_planes", "state:pitch_rate", window=(20, 90))
    >>> model = fit({"u": u, "y": y}, "u", "y", sample_time=0.05, order=3)
    >>> print(*model.verdict, sep="\\n"); control.bode(model.to_control())

    `progress` shows the elapsed time: by default on a terminal and in a notebook, with False nowhere.
    """
    check_names("fit", options, _keywords())
    named = {"input": text(input), "output": text(output), **keywords(options)}
    columns, files = None, []
    if isinstance(data, Mapping) or hasattr(data, "columns"):
        columns = [(text(name), _column(name, values)) for name, values in _arrays(data, (input, output, options.get("reference")))]
    else:
        files = paths(data)
    with Progress("fit", wanted=progress) as told:
        report, _, (inputs, measured, simulated) = _native.fit(files, named, columns, told)
    document = json.loads(report)
    time = np.arange(len(measured)) * document["model"]["sample_time"]
    return Model(document, {"time": time, "input": inputs, "measured": measured, "simulated": simulated})


def fit_several(
    data: Data, inputs: Sequence[str], outputs: Sequence[str], *, progress: bool | None = None, **options: Unpack[FitOptions]
) -> dict[str, Any]:
    """Identify models with several inputs for each of several outputs, as `planesman sysid fit -i a -i b -o y -o z` does.

    `data` and `options` are those of `fit`, except the options for one input. Returns the output of `--json`: under `model` a
    transfer function from each input to each output, with intervals and verdicts, and a state space model of all of them.

    >>> found = fit_several("run.csv", ["u", "u2"], ["y"])
    >>> space = found["model"]["state_space"]; control.ss(space["a"], space["b"], space["c"], space["d"], found["model"]["sample_time"])
    """
    check_names("fit_several", options, ["data", "inputs", "outputs", "progress", *FitOptions.__annotations__])
    if not inputs or not outputs or isinstance(inputs, str) or isinstance(outputs, str):
        raise _native.PlanesmanError("inputs and outputs must be lists of at least one signal: inputs=['u', 'v'], outputs=['y']")
    named = {"input": text(inputs[0]), "output": text(outputs[0]), **keywords(options)}
    for name, others in [("other_inputs", inputs[1:]), ("other_outputs", outputs[1:])]:
        if others:
            named[name] = [text(it) for it in others]
    columns, files = None, []
    if isinstance(data, Mapping) or hasattr(data, "columns"):
        columns = [(text(name), _column(name, values)) for name, values in _arrays(data, (*inputs, *outputs))]
    else:
        files = paths(data)
    with Progress("fit", wanted=progress) as told:
        report: dict[str, Any] = json.loads(_native.fit_several(files, named, columns, told))
    return report


def fit_equations(
    data: Data,
    equations: str | PathLike[str],
    inputs: Mapping[str, str] | None = None,
    outputs: Mapping[str, str] | None = None,
    *,
    progress: bool | None = None,
    **options: Unpack[FitOptions],
) -> dict[str, Any]:
    """Fit your own state equations to data at its recorded times, as `planesman sysid fit --equations FILE` does.

    `equations` is a file with them. `inputs` and `outputs` map names of the file to signals, unless the file names the signals or the names are equal.
    `data` and `options` are those of `fit`; only options for data, windows and validation have an effect. Returns the output of `--json`: under
    `parameters` name, value and standard deviation of each, under `undetermined` the parameters that the data does not determine.

    >>> found = fit_equations("run.csv", "motor.yaml", inputs={"u": "volts"})
    >>> {it["name"]: (it["value"], it["deviation"]) for it in found["parameters"]}
    """
    check_names("fit_equations", options, ["data", "equations", "inputs", "outputs", "progress", *FitOptions.__annotations__])
    named: dict[str, Any] = keywords(options)
    wanted = []
    for one, others, signals in [("input", "other_inputs", inputs), ("output", "other_outputs", outputs)]:
        written = [f"{text(name)}={text(signal)}" for name, signal in (signals or {}).items()]
        wanted += list((signals or {}).values())
        if written:
            named[one] = written[0]
        if written[1:]:
            named[others] = written[1:]
    columns, files = None, []
    if isinstance(data, Mapping) or hasattr(data, "columns"):
        columns = [(text(name), _column(name, values)) for name, values in _arrays(data, wanted)]
    else:
        files = paths(data)
    with Progress("fit", wanted=progress) as told:
        report: dict[str, Any] = json.loads(_native.fit_equations(files, path_text(equations), named, columns, told))
    return report


def _keywords() -> list[str]:
    """The keywords of `fit`."""
    return ["data", "input", "output", "progress", *FitOptions.__annotations__]


def _arrays(data: Any, wanted: Sequence[str | None]) -> list[tuple[object, Any]]:
    """Arrays by name, on a common time: from a mapping, from a data frame with its index, or from samples with their own stamps."""
    if isinstance(data, Mapping):
        samples = {name: found for name, found in data.items() if isinstance(found, Samples)}
        return list(data.items()) if not samples else _on_one_time(samples, wanted)
    columns = [(name, data[name]) for name in data.columns]
    index = data.index
    if hasattr(index, "asi8"):
        # Times of day, or since something.
        return [("time", (index.asi8 - index.asi8.min()) * _seconds(index)), *columns]
    if index.name is not None and index.name not in data.columns:
        return [(index.name, index), *columns]
    return columns


def _seconds(index: Any) -> float:
    return {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}[getattr(index, "unit", "ns")]


def _on_one_time(samples: Mapping[str, Samples], wanted: Sequence[str | None]) -> list[tuple[object, Any]]:
    """Signals with their own stamps, merged: every stamp once, and NaN where a signal has no sample."""
    if all(name is None or name in samples for name in wanted):
        samples = {name: samples[name] for name in samples if name in wanted}
    for name, signal in samples.items():
        if len(signal) and (np.maximum.accumulate(signal.stamp) - signal.stamp).max() > 1_000_000_000:
            raise _native.PlanesmanError(f"'{name}': its time goes back, as in a bag with a restart; pass the path of the bag to fit()")
    stamps = np.unique(np.concatenate([signal.stamp for signal in samples.values()]))
    origin = min((signal.origin for signal in samples.values()), default=0)
    columns: list[tuple[object, Any]] = [("time", (stamps - origin) * 1e-9)]
    for name, signal in samples.items():
        column = np.full(len(stamps), np.nan)
        column[np.searchsorted(stamps, signal.stamp)] = signal.value
        columns.append((name, column))
    return columns


def _real(name: object, values: Any) -> NDArray[np.float64]:
    try:
        numbers = np.asarray(values)
        if np.iscomplexobj(numbers):
            raise TypeError("it is complex; pass its real and its imaginary part as separate arrays")
        return np.asarray(numbers, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise _native.PlanesmanError(f"'{name}' is not an array of numbers: {error}") from None


def _column(name: object, values: Any) -> bytes:
    numbers = _real(name, values)
    if numbers.ndim != 1:
        raise _native.PlanesmanError(f"'{name}' has the shape {numbers.shape}: one number per sample is expected, shape (n,)")
    return numbers.tobytes()
