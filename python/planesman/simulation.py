"""Simulation of scenarios in this process, and transfer functions of vehicles."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from os import PathLike
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray

from planesman import _native, _tables
from planesman._arguments import check_names, keywords, path_text, text

if TYPE_CHECKING:
    import matplotlib.figure
    import pandas

Scenario = str | PathLike[str] | Mapping[str, Any]
"""A built-in scenario by name (dive, open_loop, way_depths, remus_100, lauv, turning_circle, zigzag, bluerov2), a scenario file by path, or its contents as a mapping."""


def scenario_text(
    scenario: Scenario,
    parameters: Mapping[str, Any],
    duration: float | None = None,
    tick: float | None = None,
    seed: int | None = None,
    *,
    function: str,
    known: Sequence[str],
) -> str:
    """The checked text of a scenario with these changes. `known`: keywords of the calling function."""
    check_names(function, [name for name, value in parameters.items() if "." not in name and not isinstance(value, Mapping)], known)
    changes = [f"{text(name)}={text(value)}" for name, value in _flat(parameters)]
    if isinstance(scenario, Mapping):
        # JSON is YAML.
        return _native.scenario(json.dumps(scenario, default=_plain), True, changes, duration, tick, seed)
    return _native.scenario(text(path_text(scenario)), False, changes, duration, tick, seed)


def _flat(parameters: Mapping[str, Any]) -> Iterator[tuple[str, Any]]:
    """Converts `depth_controller={"depth.p": 1.2}` to `{"depth_controller.depth.p": 1.2}`."""
    for name, value in parameters.items():
        if isinstance(value, Mapping):
            yield from ((f"{text(name)}.{text(below)}", found) for below, found in _flat(value))
        else:
            yield name, value


def _plain(value: Any) -> Any:
    if isinstance(value, (np.ndarray, np.generic)):
        return value.tolist()
    if isinstance(value, PathLike):
        return text(value)
    raise TypeError(f"{value!r} of a scenario refused: numbers, text, lists and mappings are expected")


class Flight(Mapping[str, NDArray[np.float64]]):
    """A flight as a table: each column is a numpy array with one number per tick, shape (ticks,).

    `flight["depth"]` is a column, `flight.units["depth"]` is its unit, `flight.frame()` is a
    data frame, and `fit(flight, "dive_planes", "pitch_rate")` identifies from it.
    """

    def __init__(self, columns: Mapping[str, NDArray[np.float64]], units: Mapping[str, str]) -> None:
        self._columns = dict(columns)
        self.units: dict[str, str] = dict(units)
        """The unit of each column."""

    def __getitem__(self, name: str) -> NDArray[np.float64]:
        return self._columns[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._columns)

    def __len__(self) -> int:
        return len(self._columns)

    def __repr__(self) -> str:
        columns = ", ".join(f"{name} [{self.units[name]}]" for name in self)
        return f"Flight of {len(self['time'])} ticks: {columns}"

    def _repr_html_(self) -> str:
        names = ["column", "unit", "first", "least", "most", "last"]
        edges = [(name, self.units[name], of[0], of.min(), of.max(), of[-1]) for name, of in self.items() if len(of)]
        return _tables.of_rows(names, edges, f"Flight of {len(self['time'])} ticks, {len(self)} columns", whole=True)

    def frame(self) -> pandas.DataFrame:
        """As a pandas DataFrame over `time`."""
        import pandas

        return pandas.DataFrame(self._columns, copy=False).set_index("time")

    def plot(self, *columns: str) -> matplotlib.figure.Figure:
        """Plot columns over time, one below the other; by default depth, pitch and planes."""
        import matplotlib.pyplot as plt

        names = columns or ("depth", "pitch", "dive_planes")
        figure, axes = plt.subplots(len(names), 1, sharex=True, squeeze=False, figsize=(8.0, 1.0 + 1.8 * len(names)))
        for axis, name in zip(axes[:, 0], names):
            axis.plot(self["time"], self[name])
            if name == "depth":
                axis.plot(self["time"], self["depth_setpoint"], "k--", linewidth=1.0, label="setpoint")
                axis.legend()
                axis.invert_yaxis()
            axis.set_ylabel(f"{name} [{self.units[name]}]")
            axis.grid(alpha=0.3)
        axes[-1, 0].set_xlabel("time [s]")
        figure.align_ylabels()
        figure.tight_layout()
        return figure


def simulate(
    scenario: Scenario = "dive",
    *,
    duration: float | None = None,
    tick: float | None = None,
    seed: int | None = None,
    bag: str | PathLike[str] | None = None,
    namespace: str = "/auv",
    **parameters: Any,
) -> Flight:
    """Simulate a scenario in this process: vehicle, controller, actuator and identifier, bit for bit as `planesman sim`.

    `scenario` is a built-in one (see `Scenario`), a file, or its contents as a mapping. `duration` and `tick`
    are in s; `seed` is the seed of all noise. `parameters` are those listed by `parameters()`, by node or by full name:

    >>> simulate("dive", depth_controller={"depth.p": 1.2}, plant_sim={"speed": "2ft/s"})
    >>> simulate("dive", **{"depth_controller.depth.p": 1.2})

    A number is in SI; other units are written with the number. With `bag`, a new `.mcap` file, every message of the loop is recorded
    there, its topics in `namespace`.

    Returns one array per column, with one number per tick: `time` (s), `depth` (m), `pitch` (rad), `pitch_rate` (rad/s), `dive_planes` (rad)
    and more; `Flight.units` has the units.
    """
    known = ["scenario", "duration", "tick", "seed", "bag", "namespace"]
    flown = scenario_text(scenario, parameters, duration, tick, seed, function="simulate", known=known)
    columns, units = {}, {}
    for name, numbers in _native.fly(flown, None if bag is None else path_text(bag), text(namespace)):
        name, unit = name.removesuffix("]").split(" [")
        columns[name], units[name] = numbers, unit
    return Flight(columns, units)


Controller = Callable[[float, NDArray[np.float64]], "float | Sequence[float]"]
"""A control law: a function of time (s) and state (in the order of `STATES`) that returns the angle of the dive planes (rad, positive to dive), or this angle
with `bow_stern_differential`, `roll_differential`, `rudder` (rad) and `thrust` (share of full thrust)."""

STATES: dict[str, str] = dict(name.removesuffix("]").split(" [") for name in _native.states())
"""Names and units of the numbers of a state, in order."""


class Loop:
    """A scenario simulated tick by tick in this process, with your own control law instead of `depth_controller`.

    >>> def law(time, state):
    ...     depth, pitch, rate = state[0], state[6], state[7]
    ...     return np.clip(1.7 * (pitch - 0.5 * (depth - 0.9144)) + 0.6 * rate, -0.4, 0.4)
    >>> with Loop("dive", controller=law, bag="own.mcap") as loop:
    ...     depths = [state[0] for state in loop]

    Scenario, changes and `bag` are those of `simulate`; without `controller` the loop is the same as in `simulate`. An exception in the
    control law ends the step and is raised there.
    """

    def __init__(
        self,
        scenario: Scenario = "dive",
        *,
        controller: Controller | None = None,
        duration: float | None = None,
        tick: float | None = None,
        seed: int | None = None,
        bag: str | PathLike[str] | None = None,
        namespace: str = "/auv",
        **parameters: Any,
    ) -> None:
        known = ["scenario", "controller", "duration", "tick", "seed", "bag", "namespace"]
        flown = scenario_text(scenario, parameters, duration, tick, seed, function="Loop", known=known)
        self._loop = _native.Loop(flown, controller, None if bag is None else path_text(bag), text(namespace))

    @property
    def state(self) -> NDArray[np.float64]:
        """The true state at the present tick, in the order of `STATES`, shape (13,)."""
        return self._loop.state()

    @property
    def time(self) -> float:
        """The present time, s."""
        return self._loop.time()

    @property
    def is_over(self) -> bool:
        """Whether the scenario's duration has passed; the loop can be stepped on."""
        return self._loop.is_over()

    def step(self) -> NDArray[np.float64]:
        """Fly one tick; the state after it."""
        self._loop.step()
        return self._loop.state()

    def __iter__(self) -> Iterator[NDArray[np.float64]]:
        """The state after each tick, to the end of the scenario."""
        while not self.is_over:
            yield self.step()

    def close(self) -> None:
        """Close the bag and move it to its final path."""
        self._loop.close()

    def __enter__(self) -> Loop:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


@dataclass(frozen=True)
class TransferFunction:
    """A vehicle's transfer function about level flight. Coefficients begin with the highest power."""

    num: NDArray[np.float64]
    """Numerator in s."""
    den: NDArray[np.float64]
    """Denominator in s."""
    sampled_num: NDArray[np.float64]
    """Numerator in z, with a zero-order hold."""
    sampled_den: NDArray[np.float64]
    """Denominator in z."""
    sample_time: float
    """Sampling interval, s."""
    about: list[str]
    """Vehicle, signals, units, speed and operating point."""
    input: str
    """The input signal."""
    output: str
    """The output signal."""

    def to_control(self, *, sampled: bool = False, form: Form = "tf") -> Any:
        """The transfer function as an object of python-control, in s or in z; as state space with `form="ss"`. Input and output have
        their names."""
        if sampled:
            return of_control(self.sampled_num, self.sampled_den, self.sample_time, self.input, self.output, form)
        return of_control(self.num, self.den, 0, self.input, self.output, form)


Form = Literal["tf", "ss"]
"""Transfer function, or state space."""


def of_control(num: Any, den: Any, sample_time: float, input: str, output: str, form: Form) -> Any:
    """A model of python-control, in s if the sampling interval is 0. Dots in names are replaced, since python-control uses them to separate system and signal."""
    import control

    if form not in ("tf", "ss"):
        raise _native.PlanesmanError(f"form: '{form}' refused: 'tf' or 'ss' is expected")
    names = {"inputs": input.replace(".", "_"), "outputs": output.replace(".", "_")}
    model = control.tf(num, den, sample_time, **names)
    return model if form == "tf" else control.ss(model, **names)


def transfer_function(
    vehicle: str | PathLike[str] = "brunner",
    input: Literal["dive_planes", "pitch_rate"] = "dive_planes",
    output: Literal["pitch_rate", "pitch", "depth", "heave"] = "pitch_rate",
    *,
    speed: float | str = 0.3048,
    rate: float = 20.0,
    base: str = "brunner",
) -> TransferFunction:
    """Linearise a vehicle about level flight, as `planesman tf` does.

    `vehicle` is a built-in one (brunner, brunner_as_printed, remus_100), a vehicle file, or a model file of `fit`, which takes everything except
    its pitch dynamics from `base`. `speed` is in m/s or a text with its unit; `rate` is the sampling rate of the discrete model, Hz. `input`
    pitch_rate is possible only with `output` depth.
    """
    options = {"input": input, "output": output, "speed": speed, "rate": rate, "base": base}
    about, continuous, sampled = _native.transfer_function(text(path_text(vehicle)), keywords(options))
    num, den, sampled_num, sampled_den = map(np.array, continuous + sampled)
    return TransferFunction(num, den, sampled_num, sampled_den, 1.0 / rate, about, input, output)


def parameters(node: str | None = None) -> _tables.Table:
    """List every parameter of all nodes, or of one node: `name`, `unit`, `default`, `range`, `choices`, `description`."""
    return _tables.Table(json.loads(_native.parameters(None if node is None else text(node))))


def parameter_file(scenario: Scenario = "dive", *, node: str | None = None, **parameters: Any) -> str:
    """The text of a ROS 2 parameter file (`--params-file`) with the values of a scenario and changes as in `simulate`."""
    held = scenario_text(scenario, parameters, function="parameter_file", known=["scenario", "node"])
    return _native.parameter_file(held, None if node is None else text(node))
