"""Recomputed numbers of the two historical reports."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sysconfig
import tempfile
from os import PathLike
from pathlib import Path

from planesman._native import PlanesmanError
from planesman._tables import Table

_PROGRAM = "planesman-reports"


def reproduce(program: str | PathLike[str] | None = None) -> Table:
    """Recompute every number of the two reports and of Hopsan's validations, one row per number.

    The numbers come from the program `planesman-reports` (`cargo build --release --package planesman-reports` in a clone): that of `program`,
    or of the environment variable `PLANESMAN_REPORTS`, or the one among this Python's scripts or on `PATH`.

    A row has `report`, `number`, `family` and `name` in words, `source` (page or table), `unit` (the report's own), `printed`,
    `recomputed`, `within` (allowed difference), `verdict`, `note`, and the `erratum` with its `explanation` of a number that is
    contradicted. Numbers that are not printed, or cannot be recomputed, are None. "read back" is a printed constant used as an input of the models.
    `reproduce().frame()` is a data frame.
    """
    named = program or os.environ.get("PLANESMAN_REPORTS")
    places = os.pathsep.join([sysconfig.get_path("scripts"), os.environ.get("PATH", os.defpath)])
    found = shutil.which(named or _PROGRAM, path=places)
    if found is None:
        wanted = f"the reports' program '{os.fspath(named)}'" if named else f"the reports' program, {_PROGRAM},"
        raise PlanesmanError(
            f"{wanted} was not found; build it: cargo build --release --package {_PROGRAM}, and name it with program= or PLANESMAN_REPORTS"
        )
    with tempfile.TemporaryDirectory() as folder:
        rows = Path(folder) / "numbers.json"
        run = subprocess.run([found, "reproduce", "--json", rows], capture_output=True, text=True)
        if run.returncode != 0:
            raise PlanesmanError(run.stderr.strip() or f"{found} ended with status {run.returncode}")
        return Table(json.loads(rows.read_text()))
