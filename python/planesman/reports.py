"""The numbers of the two historical reports."""

from __future__ import annotations

import json
from planesman import _native
from planesman._tables import Table


def reproduce() -> Table:
    """Recompute every number of the two reports and of Hopsan's validations, a row each.

    A row has `report`, `number`, `family` and `name` in words, `source` (page or table), `unit` (the report's own), `printed`,
    `recomputed`, `within` (how far off it may be), `verdict`, `note`, and the `erratum` with its `explanation` of a number that is
    contradicted. Numbers that are not printed, or cannot be recomputed, are None. "read back" is a constant that the models are given.
    `reproduce().frame()` is a data frame.
    """
    return Table(json.loads(_native.reproduced()))
