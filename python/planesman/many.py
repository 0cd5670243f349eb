"""Many simulations and many fits, on one machine or on the workers of a Dask cluster."""

from __future__ import annotations

import functools
import json
import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, overload

import numpy as np

from planesman import _native, _parts
from planesman._arguments import check_names, path_text, text
from planesman._progress import Progress
from planesman._tables import Columns
from planesman.identification import Model, _keywords, fit
from planesman.simulation import Scenario, scenario_text

if TYPE_CHECKING:
    import pyarrow
    from distributed import Client
    from typing_extensions import Unpack

    from planesman._options import FitOptions

# Flights and fits of a part, at most.
_FLIGHTS = 1000
_FITS = 100


@overload
def sweep(
    scenario: Scenario,
    vary: Mapping[str, Any],
    *,
    seeds: int = 1,
    samples: int | None = None,
    out: None = None,
    client: None = None,
    parts: int | None = None,
    progress: bool | None = None,
    **parameters: Any,
) -> Columns: ...


@overload
def sweep(
    scenario: Scenario,
    vary: Mapping[str, Any],
    *,
    seeds: int = 1,
    samples: int | None = None,
    out: str | os.PathLike[str],
    client: Client | None = None,
    parts: int | None = None,
    progress: bool | None = None,
    **parameters: Any,
) -> Path: ...


def sweep(
    scenario: Scenario,
    vary: Mapping[str, Any],
    *,
    seeds: int = 1,
    samples: int | None = None,
    out: str | os.PathLike[str] | None = None,
    client: Client | None = None,
    parts: int | None = None,
    progress: bool | None = None,
    **parameters: Any,
) -> Columns | Path:
    """Fly a scenario many times with different parameters and seeds, as `planesman sweep` does.

    `vary` gives the values of each parameter: a list or array, or text as on the command line: `"0.4:1.6:0.1"` from, to and step,
    `"1ft/s,2ft/s"`, or `"0.4..1.6"` to draw `samples` from: a Latin hypercube over all parameters given in this way. Every combination is flown
    with `seeds` seeds, beginning with the scenario's. `parameters` apply to all flights, as in `simulate`.

    Without `out` all cores are used, and the result is a dict of columns with a row per case: arrays of numbers (NaN for none) and lists of words;
    `frame()` returns a data frame. With `out` the result is the folder `out/cases`, a Parquet dataset of `parts` files with the same rows,
    which DuckDB, Polars, pandas and Spark read as one table; the same call again flies the missing cases. A `client` of
    `dask.distributed` spreads the parts over its workers, which must see `out` and the files that the scenario names.

    `progress` shows a bar: by default on a terminal and in a notebook, with False nowhere. Ctrl-C ends the sweep at once; with `out` the parts
    that are done are kept.

    >>> cases = sweep("dive", {"depth_controller.depth.p": [0.4, 0.8, 1.2], "plant_sim.speed": "1ft/s,2ft/s"}, seeds=10)
    >>> sweep("dive", {"depth_controller.depth.p": "0.4..1.6"}, samples=100_000, out="/shared/gains", client=Client(cluster))
    """
    varied = tuple(f"{text(name)}={_values(values)}" for name, values in vary.items())
    known = ["scenario", "vary", "seeds", "samples", "out", "client", "parts", "progress"]
    cases = _Cases(scenario_text(scenario, parameters, function="sweep", known=known), varied, samples, seeds)
    cases.sweep.check()
    if out is None:
        if client is not None:
            raise _native.PlanesmanError("client: a sweep on a cluster needs out, a folder that all its machines share")
        with Progress("flights", cases.sweep.cases(1, 1), progress) as told:
            return Columns(cases.sweep.fly(1, 1, True, told))
    folder = _parts.absolute(out)
    if parts is None:
        combinations = cases.sweep.combinations()
        parts = _parts.default_parts(combinations, max(1, _FLIGHTS // seeds))
    elif parts > cases.sweep.combinations():
        raise _native.PlanesmanError(f"parts: {parts} refused: there are {cases.sweep.combinations()} combinations")
    cases.sweep.define(folder, parts)
    if client is not None:
        # A worker has as many threads as the cluster gave it.
        cases = _Cases(cases.scenario, cases.vary, samples, seeds, all_cores=False)
    return _parts.fill(folder / "cases", parts, cases, client, Progress("flights", wanted=progress), cases.sweep.cases)


def _values(values: Any) -> str:
    if isinstance(values, (str, bytes)) or not isinstance(values, Iterable):
        return text(values)
    return ",".join(text(value) for value in values)


@functools.lru_cache(maxsize=1)
def _sweep(scenario: str, vary: tuple[str, ...], samples: int | None, seeds: int) -> _native.Sweep:
    """The sweep, shared by all parts that a process flies."""
    return _native.Sweep(scenario, list(vary), samples, seeds)


@dataclass(frozen=True)
class _Cases:
    """The cases of a sweep, in the form sent to a worker."""

    scenario: str
    vary: tuple[str, ...]
    samples: int | None
    seeds: int
    all_cores: bool = True

    @property
    def sweep(self) -> _native.Sweep:
        return _sweep(self.scenario, self.vary, self.samples, self.seeds)

    def __call__(self, part: int, of: int, told: Callable[[int], None] | None = None) -> pyarrow.Table:
        import pyarrow

        columns = dict(self.sweep.fly(part, of, self.all_cores, told))
        error = columns.pop("error")
        arrays = {name: _parts.numbers(values) for name, values in columns.items()}
        arrays["error"] = pyarrow.array([reason or None for reason in error], pyarrow.string())
        return pyarrow.table(arrays)


def fit_all(
    data: str | os.PathLike[str] | Sequence[str | os.PathLike[str]],
    input: str,
    output: str,
    *,
    out: str | os.PathLike[str],
    client: Client | None = None,
    parts: int | None = None,
    progress: bool | None = None,
    **options: Unpack[FitOptions],
) -> Path:
    """Fit a model to each of many bags, as `fit` does, into a Parquet dataset with one row per bag.

    `data` is a folder, which is searched for all bags, tables and logs that `fit` reads, or a list of paths. Files are selected by extension: a `.txt` that is not a
    table has a row with an `error`.

    Returns the folder `out/models`, of `parts` files, which DuckDB, Polars, pandas and Spark read as one table: `data` (the path),
    `method`, `order`, `sample_time` (s), `fit` and `held_out_fit` (%), `steady_state_gain` with `steady_state_gain_deviation`, the lists `pole_re`, `pole_im`
    and their deviations `pole_re_deviation`, `pole_im_deviation` (1/s), `verdict`, `model` (the model file, JSON), and `error`: the reason if there
    is no model. The same call again fits the missing ones. `progress` is as in `sweep`. A `client` of `dask.distributed` spreads the parts over its workers, which
    must see the data and `out`.

    >>> fit_all("/shared/bags", "plane_motion:dive_planes", "state:pitch_rate", order=3, out="/shared/fits", client=Client(cluster))
    """
    check_names("fit_all", options, ["out", "client", "parts", *_keywords()])
    bags = _bags(data)
    if not bags:
        raise _native.PlanesmanError(f"'{data}': it contains no bag, table or log")
    folder = _parts.absolute(out)
    parts = _parts.default_parts(len(bags), _FITS) if parts is None else parts
    fits = _Fits(tuple(bags), input, output, tuple(sorted(options.items())))
    _define(folder, fits, parts)
    return _parts.fill(folder / "models", parts, fits, client, Progress("fits", wanted=progress), fits.count)


def _bags(data: str | os.PathLike[str] | Sequence[str | os.PathLike[str]]) -> list[str]:
    """All bags, tables and logs in a folder; a folder with a metadata.yaml is a bag."""
    if not isinstance(data, (str, bytes, bytearray, os.PathLike)):
        return [os.path.abspath(path_text(it)) for it in data]
    found = []
    for folder, below, files in os.walk(os.path.abspath(path_text(data))):
        below.sort()
        if "metadata.yaml" in files:
            found.append(folder)
            below.clear()
        else:
            found += filter(_native.is_data, (os.path.join(folder, name) for name in sorted(files)))
    return found


def _define(folder: Path, fits: _Fits, parts: int) -> None:
    """Create the folder, with a description of its job. A folder contains one job."""
    definition = {
        "input": fits.input,
        "output": fits.output,
        "options": {name: text(value) for name, value in fits.options},
        "parts": parts,
        "data": fits.bags,
    }
    written = json.dumps(definition, indent=1)
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / "fits.json"
    if not path.exists():
        _parts.put(path, lambda file: file.write(written.encode()))
    elif path.read_text() != written:
        raise _native.PlanesmanError(f"'{folder}' contains other fits. Name a new folder")


@dataclass(frozen=True)
class _Fits:
    """The fits of many bags, in the form sent to a worker."""

    bags: tuple[str, ...]
    input: str
    output: str
    options: tuple[tuple[str, Any], ...]

    def count(self, part: int, of: int) -> int:
        """Bags of a part."""
        return len(self.bags[part - 1 :: of])

    def __call__(self, part: int, of: int, told: Callable[[int], None] | None = None) -> pyarrow.Table:
        import pyarrow

        schema = pyarrow.schema(
            [("data", pyarrow.string()), ("method", pyarrow.string()), ("order", pyarrow.int64())]
            + [(name, pyarrow.float64()) for name in ("sample_time", "fit", "held_out_fit", "steady_state_gain", "steady_state_gain_deviation")]
            + [(name, pyarrow.list_(pyarrow.float64())) for name in _poles(None)]
            + [("verdict", pyarrow.list_(pyarrow.string())), ("model", pyarrow.string()), ("error", pyarrow.string())]
        )
        rows = []
        for bag in self.bags[part - 1 :: of]:
            rows.append(self._row(bag))
            if told is not None:
                told(len(rows))
        return pyarrow.Table.from_pylist(rows, schema)

    def _row(self, bag: str) -> dict[str, Any]:
        # A column of text has no place for bytes that are not.
        data = bag.encode("utf-8", "backslashreplace").decode()
        try:
            model = fit(bag, self.input, self.output, progress=False, **dict(self.options))
        except _native.PlanesmanError as error:
            return {"data": data, "error": str(error)}
        return {
            "data": data,
            "method": model.method,
            "order": model.order,
            "sample_time": model.sample_time,
            "fit": model.fit,
            "held_out_fit": model.held_out_fit,
            "steady_state_gain": model.steady_state_gain,
            "steady_state_gain_deviation": model.uncertainty.steady_state_gain,
            **_poles(model),
            "verdict": model.verdict,
            "model": json.dumps(model.report["model"]),
        }


def _poles(model: Model | None) -> dict[str, list[float]]:
    """The columns of a model's poles in s, slowest first."""
    poles = np.array([]) if model is None else model.continuous_poles
    off = np.array([]) if model is None else model.uncertainty.continuous_poles
    slowest = np.argsort(np.abs(poles), kind="stable")
    poles, off = poles[slowest], off[slowest]
    return {
        "pole_re": poles.real.tolist(),
        "pole_im": poles.imag.tolist(),
        "pole_re_deviation": off.real.tolist(),
        "pole_im_deviation": off.imag.tolist(),
    }
