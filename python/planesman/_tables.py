"""Lists and dicts that a notebook displays as tables."""

from __future__ import annotations

import html
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    import pandas

# Rows of a long table that are shown, at its beginning and at its end.
_HEAD, _TAIL = 8, 3


class Table(list[dict[str, Any]]):
    """Rows, each a dict with the same keys. `frame()` returns a data frame."""

    def frame(self) -> pandas.DataFrame:
        """As a pandas DataFrame."""
        import pandas

        return pandas.DataFrame(list(self))

    def _repr_html_(self) -> str:
        names = list(self[0]) if self else []
        return of_rows(names, [list(row.values()) for row in self])


class Columns(dict[str, Any]):
    """Columns by name, of equal length: arrays of numbers and lists of words. `frame()` returns a data frame."""

    def frame(self) -> pandas.DataFrame:
        """As a pandas DataFrame."""
        import pandas

        return pandas.DataFrame(dict(self))

    def _repr_html_(self) -> str:
        return of_rows(list(self), list(zip(*self.values())))


def of_rows(names: Sequence[str], rows: Sequence[Sequence[Any]], note: str = "", *, whole: bool = False) -> str:
    """A table as HTML; of a long one only the first and the last rows, unless `whole` is set."""
    shown: list[Sequence[Any] | None] = list(rows)
    if not whole and len(rows) > _HEAD + _TAIL + 1:
        shown = [*rows[:_HEAD], None, *rows[-_TAIL:]]
        note = note or f"{len(rows)} rows"
    head = _row("th", names)
    body = "".join(_row("td", ["…"] * len(names) if row is None else map(text, row)) for row in shown)
    below = f"<p>{html.escape(note)}</p>" if note else ""
    return f"<table><thead>{head}</thead><tbody>{body}</tbody></table>{below}"


def _row(kind: str, cells: Iterable[str]) -> str:
    return "<tr>" + "".join(f"<{kind}>{html.escape(cell)}</{kind}>" for cell in cells) + "</tr>"


def text(value: Any) -> str:
    """Text of a value; numbers with six significant digits."""
    if value is None:
        return ""
    if isinstance(value, (float, np.floating)):
        return "" if np.isnan(value) else f"{value:.6g}"
    return str(value)
