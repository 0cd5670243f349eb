"""The notebooks: what they import is in an extra, and what they show is stored in them."""

from __future__ import annotations

import ast
import json
import sys
from pathlib import Path
from typing import Any

import pytest

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

PYTHON = Path(__file__).resolve().parents[1]
NOTEBOOKS = sorted((PYTHON / "notebooks").glob("*.ipynb"))


def cells(notebook: Path) -> list[dict[str, Any]]:
    found: list[dict[str, Any]] = json.loads(notebook.read_text())["cells"]
    return [cell for cell in found if cell["cell_type"] == "code"]


def imported(source: str) -> set[str]:
    names: set[str] = set()
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            names |= {alias.name.split(".")[0] for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            names.add(node.module.split(".")[0])
    return names


@pytest.mark.parametrize("notebook", NOTEBOOKS, ids=lambda it: it.stem)
def test_what_a_notebook_imports_is_in_the_extra(notebook: Path) -> None:
    project = tomllib.loads((PYTHON / "pyproject.toml").read_text())["project"]
    listed = project["optional-dependencies"]["notebooks"] + project["dependencies"]
    names = {requirement.split(">")[0] for requirement in listed}
    needed = set().union(*(imported("".join(cell["source"])) for cell in cells(notebook)))
    foreign = {name for name in needed if name not in sys.stdlib_module_names} - {"planesman"}
    assert foreign and foreign <= names, foreign - names


@pytest.mark.parametrize("notebook", NOTEBOOKS, ids=lambda it: it.stem)
def test_a_notebook_shows_what_it_made(notebook: Path) -> None:
    code = cells(notebook)
    assert all(cell["execution_count"] for cell in code)
    outputs = [output for cell in code for output in cell["outputs"]]
    assert any("image/png" in output.get("data", {}) for output in outputs)
    assert not any(output["output_type"] == "error" for output in outputs)
    # Of the machine it was run on it says nothing.
    text = json.dumps([output for output in outputs if "image/png" not in output.get("data", {})])
    assert str(PYTHON.parent) not in text and str(Path.home()) not in text
