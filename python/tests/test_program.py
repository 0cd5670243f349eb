"""The package beside the program: the same numbers, the same sentences."""

from __future__ import annotations

import csv
import json
import subprocess
from pathlib import Path

import numpy as np
import pytest

import planesman


def run(program: str, *args: object, cwd: Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run([program, *map(str, args)], cwd=cwd, capture_output=True, text=True, timeout=120)


def test_a_flight_is_that_of_the_program(program: str, flight: planesman.Flight, tmp_path: Path) -> None:
    assert run(program, "sim", "dive", "--out", "dive.csv", cwd=tmp_path).returncode == 0
    columns = {name: f"{name} [{unit}]" for name, unit in flight.units.items() if name != "time"}
    read = planesman.read_bag(tmp_path / "dive.csv", columns.values())
    for name, column in columns.items():
        assert np.array_equal(read[column].value, flight[name]), name


def test_a_model_is_that_of_the_program(program: str, bag: Path, tmp_path: Path) -> None:
    fit = run(program, "sysid", "fit", bag, "-i", "plane_motion:dive_planes", "-o", "state:pitch_rate", "--json", cwd=tmp_path)
    printed, returned = json.loads(fit.stdout), dict(planesman.fit(bag, "plane_motion:dive_planes", "state:pitch_rate").report)
    # The sentences name options, as each user writes them; the judgement is the same as data.
    for report in (printed, returned):
        model = report["model"] = dict(report["model"])
        assert model.pop("verdict") and model["judgement"]
    assert printed == returned


def test_a_sweep_is_that_of_the_program(program: str, tmp_path: Path) -> None:
    (tmp_path / "short.yaml").write_text("{description: short, duration: 4.0, parameters: {depth_controller: {depth_setpoint: 0.1}}}")
    vary = "depth_controller.depth.p=0.5:1.5:0.5"
    swept = run(program, "sweep", "short.yaml", "--vary", vary, "--seeds", 2, "--out", "out", cwd=tmp_path)
    assert swept.returncode == 0, swept.stderr
    name, values = vary.split("=")
    columns = planesman.sweep(tmp_path / "short.yaml", {name: values}, seeds=2)
    rows = list(csv.DictReader((tmp_path / "out" / "cases.csv").open()))
    assert list(columns) == list(rows[0])
    for name, column in columns.items():
        written = [row[name] for row in rows]
        if isinstance(column, list):
            assert column == written
        else:
            assert np.array_equal(column, [float(cell) if cell else np.nan for cell in written], equal_nan=True), name


@pytest.mark.parametrize(
    ("args", "call"),
    [
        (["sim", "dive", "--set", "depth_controller.depth.p=-1"], lambda: planesman.simulate(depth_controller={"depth.p": -1})),
        (["sysid", "fit", "none.mcap", "-i", "a:b", "-o", "c:d"], lambda: planesman.fit("none.mcap", "a:b", "c:d")),
        (["tf", "no_vehicle"], lambda: planesman.transfer_function("no_vehicle")),
    ],
)
def test_a_refusal_is_that_of_the_program(args: list[str], call: object, program: str, tmp_path: Path) -> None:
    refused = run(program, *args, cwd=tmp_path)
    assert refused.returncode != 0
    with pytest.raises(planesman.PlanesmanError) as refusal:
        call()  # type: ignore[operator]
    said = refused.stderr.strip().splitlines()[-1].removeprefix("planesman: ")
    # A change is a keyword, not an option.
    said = said.removeprefix("--set ")
    assert str(refusal.value).strip() == said
