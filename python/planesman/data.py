"""Signals of bags, tables and logs as numpy arrays."""

from __future__ import annotations

import json
import warnings
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from os import PathLike
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray

from planesman import _native
from planesman._arguments import keywords, paths, text
from planesman._tables import Table

if TYPE_CHECKING:
    import pandas

Path = str | PathLike[str]


@dataclass(frozen=True)
class Samples:
    """Samples of one signal, in the order of the data.

    `len(samples)` is n. `numpy.asarray(samples)` is `value`.
    """

    stamp: NDArray[np.int64]
    """Time of each sample, ns on the data's own clock; shape (n,)."""
    value: NDArray[np.float64]
    """Values in the unit of the field; NaN if a message has no value; shape (n,)."""
    origin: int
    """First stamp of all signals that were read together, ns."""

    @property
    def time(self) -> NDArray[np.float64]:
        """Time since `origin`, s; shape (n,)."""
        return np.multiply(self.stamp - self.origin, 1e-9, dtype=np.float64)

    def series(self) -> pandas.Series:
        """As a pandas Series over the time of day (`datetime64[ns]`)."""
        import pandas

        return pandas.Series(self.value, index=pandas.to_datetime(self.stamp, unit="ns"), copy=False)

    def __len__(self) -> int:
        return len(self.value)

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> NDArray[Any]:
        if dtype is None and not copy:
            return self.value
        return np.array(self.value, dtype=dtype)


def read_bag(
    data: Path | Sequence[Path],
    fields: Iterable[str] | str,
    *,
    stamp: Literal["header", "log"] | None = None,
    time: str | None = None,
    time_unit: Literal["s", "ms", "us", "ns", "min", "h", "d"] | None = None,
    sample_time: float | str | None = None,
    most_unpacked: int | None = None,
) -> dict[str, Samples]:
    """Read signals of a bag, table or log: every sample with its own stamp, without resampling.

    `data` is a bag folder, a `metadata.yaml`, one or several `.mcap` or `.db3` files of a split bag, a table, or a log, whose file extensions
    docs/sysid.md lists. ROS need not be installed.

    `fields` are named as `list_fields` lists them: `"imu:angular_velocity.y"`, `"joint_states:position[shoulder]"`,
    `"odom:pose.pose.orientation.pitch"`, or a column of a table. For a list field the first number is read, unless one is
    named.

    `stamp` chooses the clock of a bag: that of the message headers (the default if all have one), or of the recorder (log). `time`,
    `time_unit` and `sample_time` (s) describe the time of a table. Each file of a bag is read up to `most_unpacked` MB
    once unpacked: a small file can unpack to thousands of times its size.

    Unreadable messages are skipped; a warning reports them.

    >>> bag = read_bag("bag", ["state:depth", "plane_motion:dive_planes"])
    >>> bag["state:depth"].time, bag["state:depth"].value
    >>> pandas.DataFrame({name: samples.series() for name, samples in bag.items()})
    """
    names = [fields] if isinstance(fields, (str, bytes)) else list(fields)
    options = {"stamp": stamp, "time": time, "time_unit": time_unit, "sample_time": sample_time, "most_unpacked": most_unpacked}
    signals, notes = _native.samples(paths(data), [text(name) for name in names], keywords(options))
    for note in notes:
        warnings.warn(note, stacklevel=2)
    origin = min((int(stamps.min()) for stamps, _ in signals if len(stamps)), default=0)
    return {name: Samples(stamps, values, origin) for name, (stamps, values) in zip(names, signals)}


def list_fields(data: Path | Sequence[Path], *, topic: str | None = None, most_unpacked: int | None = None) -> Table:
    """List every numeric field of a bag, table or log, one row per field.

    A row has `field` (as `read_bag` and `fit` take it), `type` of the message, `rate` (Hz), `count`, `not_finite`, `min`, `max`.
    `topic` keeps only topics whose name contains this text; `most_unpacked` is as in `read_bag`. `list_fields(bag).frame()` is a data frame.
    """
    options = keywords({"most_unpacked": most_unpacked})
    survey = json.loads(_native.fields(paths(data), None if topic is None else text(topic), options))
    for note in survey["notes"]:
        warnings.warn(note, stacklevel=2)
    rows = Table()
    for found in survey["topics"]:
        for field in found["fields"]:
            rows.append(
                {
                    "field": f"{found['name']}:{field['path']}" if found["type_name"] else field["path"],
                    "type": found["type_name"],
                    "rate": found["rate"],
                    **{key: field[key] for key in ("count", "not_finite", "min", "max")},
                }
            )
    return rows
