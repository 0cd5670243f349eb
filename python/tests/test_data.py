"""Bags, tables and logs as arrays."""

from __future__ import annotations

import gc
import os
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pandas
import pyarrow.parquet
import pytest

import planesman


def test_a_bag_holds_the_numbers_that_were_flown(bag: Path, flight: planesman.Flight) -> None:
    read = planesman.read_bag(bag, ["state:depth", "state:pitch", "control_state:depth_setpoint"])
    assert np.array_equal(read["state:depth"].value, flight["depth"])
    assert np.array_equal(read["state:pitch"].value, flight["pitch"])
    assert np.array_equal(read["control_state:depth_setpoint"].value, flight["depth_setpoint"])
    samples = read["state:depth"]
    assert samples.stamp.dtype == np.int64 and samples.value.dtype == np.float64
    assert np.array_equal(samples.stamp, np.round(flight["time"] * 1e9).astype(np.int64))
    assert samples.time[:3] == pytest.approx([0.0, 0.05, 0.1])
    assert len(samples) == len(np.asarray(samples)) == 1800


def test_signals_become_a_data_frame_over_their_stamps(bag: Path) -> None:
    read = planesman.read_bag(bag, ["state:depth", "plane_motion:dive_planes"])
    frame = pandas.DataFrame({name: samples.series() for name, samples in read.items()})
    assert frame.shape == (1800, 2)
    assert (frame.index[1] - frame.index[0]).total_seconds() == 0.05


def test_every_field_that_is_listed_can_be_read(bag: Path) -> None:
    rows = planesman.list_fields(bag, topic="imu")
    assert {"/auv/imu:angular_velocity.y", "/auv/imu:linear_acceleration.x"} <= {row["field"] for row in rows}
    for row in rows:
        values = planesman.read_bag(bag, row["field"])[row["field"]].value
        assert len(values) == row["count"] == 1800
        assert values.min() == row["min"] and values.max() == row["max"]
        assert row["type"] == "sensor_msgs/msg/Imu" and row["rate"] == pytest.approx(20.0)


def test_a_table_is_read_and_an_empty_cell_is_not_a_number(tmp_path: Path) -> None:
    table = tmp_path / "table.csv"
    table.write_text("t_ms,u,y\n0,1,2\n50,,3\n100,4,5\n")
    with pytest.warns(UserWarning, match="of 3 cells 1 are empty"):
        read = planesman.read_bag(table, ["u", "y"])
    assert np.array_equal(read["u"].value, [1.0, np.nan, 4.0], equal_nan=True)
    assert read["y"].stamp.tolist() == [0, 50_000_000, 100_000_000]
    with pytest.warns(UserWarning, match="of 3 cells 1 are empty"):
        assert [row["field"] for row in planesman.list_fields(table)] == ["u", "y"]


def test_what_is_refused_is_refused_in_one_sentence(bag: Path, tmp_path: Path) -> None:
    for data, fields, sentence in [
        (bag, ["stat:depth"], "the bag has no such topic; it has .*/auv/state"),
        (bag, ["state:dept"], "dept"),
        (bag, ["state"], "TOPIC:FIELD"),
        (tmp_path / "none.mcap", ["state:depth"], "none.mcap"),
        (bag, [], "no signal is given"),
    ]:
        with pytest.raises(planesman.PlanesmanError, match=sentence) as refusal:
            planesman.read_bag(data, fields)
        assert "\n" not in str(refusal.value)
        assert isinstance(refusal.value, ValueError)


def test_a_file_whose_name_looks_like_an_option_is_a_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("--json.csv").write_text("t,u\n0,1\n1,2\n")
    assert planesman.read_bag("--json.csv", "u")["u"].value.tolist() == [1.0, 2.0]


def test_an_array_is_not_a_copy_and_outlives_what_it_came_with(bag: Path) -> None:
    value = planesman.read_bag(bag, "state:depth")["state:depth"].value
    again = planesman.read_bag(bag, "state:depth")["state:depth"].value
    assert not value.flags.owndata and value.flags.writeable and value.flags.c_contiguous
    gc.collect()
    value[:] = 1.0
    assert value.sum() == 1800.0 and not np.array_equal(value, again)


def test_a_signal_without_a_sample_is_an_empty_array(tmp_path: Path) -> None:
    table = tmp_path / "empty.csv"
    table.write_text("t,u\n")
    samples = planesman.read_bag(table, "u")["u"]
    assert samples.value.shape == samples.time.shape == (0,)


def test_a_path_may_be_bytes_and_its_name_need_not_be_utf_8(bag: Path, tmp_path: Path) -> None:
    odd = os.fsencode(tmp_path) + b"/dive-\xff.mcap"
    shutil.copy(bag, odd)
    fields = planesman.list_fields(bag)
    assert planesman.list_fields(os.fsencode(bag)) == planesman.list_fields([odd]) == fields  # type: ignore[arg-type, list-item]
    assert planesman.list_fields(os.fsdecode(odd)) == planesman.list_fields(Path(os.fsdecode(odd))) == fields
    out = planesman.fit_all([os.fsdecode(odd)], "u", "y", out=os.fsdecode(odd) + "-fits")
    with next(out.iterdir()).open("rb") as file:
        rows = pyarrow.parquet.read_table(file).to_pylist()
    assert rows[0]["data"].endswith("/dive-\\udcff.mcap") and "no ':'" in rows[0]["error"]


@pytest.mark.parametrize("path", ["/tmp/\ud800.mcap", "/tmp/a\0b", b"/tmp/\xff.mcap", "", b"", "\udcff"])
def test_a_path_that_cannot_be_is_refused(path: Any) -> None:
    for call in [
        lambda: planesman.list_fields(path),
        lambda: planesman.read_bag([path], "state:depth"),
        lambda: planesman.fit(path, "u", "y"),
        lambda: planesman.simulate(path),
        lambda: planesman.transfer_function(path),
        lambda: planesman.Model.load(path),
    ]:
        with pytest.raises(planesman.PlanesmanError):
            call()


@pytest.mark.parametrize("path", ["/tmp/\ud800.mcap", "/tmp/a\0b.mcap", ""])
def test_a_bag_that_cannot_be_is_not_flown(path: str) -> None:
    with pytest.raises(planesman.PlanesmanError):
        planesman.simulate("dive", duration=1.0, bag=path)


@pytest.mark.parametrize(
    ("name", "error"),
    [(b"state:depth", TypeError), (bytearray(b"depth"), TypeError), ("\udcff", planesman.PlanesmanError), ("\ud800", planesman.PlanesmanError)],
)
def test_bytes_and_surrogates_are_no_names(name: Any, error: type[Exception], bag: Path) -> None:
    for call in [
        lambda: planesman.list_fields(bag, topic=name),
        lambda: planesman.read_bag(bag, [name]),
        lambda: planesman.fit(bag, name, "state:depth"),
        lambda: planesman.fit(bag, "state:depth", "state:pitch", method=name),
        lambda: planesman.fit({"u": [1.0], "y": [1.0]}, "u", "y", sample_time=name),
        lambda: planesman.simulate("dive", plant_sim={"vehicle": name}),
        lambda: planesman.simulate({"description": name, "duration": 1.0}),
        lambda: planesman.simulate("dive", duration=1.0, namespace=name),
        lambda: planesman.sweep("dive", {"plant_sim.vehicle": [name]}),
        lambda: planesman.transfer_function("brunner", output=name),
        lambda: planesman.parameters(name),
        lambda: planesman.parameter_file("dive", node=name),
    ]:
        with pytest.raises(error):
            call()
