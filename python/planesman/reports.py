"""The numbers of the two historical reports."""

from __future__ import annotations

import json
from typing import Any

from planesman import _native


def reproduce() -> list[dict[str, Any]]:
    """Recompute every number of the two reports, a row each.

    A row has `report`, `number`, `family` and `name` in words, `source` (page or table), `unit` (the report's own), `printed`,
    `recomputed`, `within` (how far off it may be), `verdict`, `note`, and the `erratum` with its `explanation` of a number that is
    contradicted. Numbers that are not printed, or cannot be recomputed, are None. "read back" is a constant that the models are given.
    `pandas.DataFrame(reproduce())` is a table.
    """
    rows: list[dict[str, Any]] = json.loads(_native.reproduced())
    return rows
