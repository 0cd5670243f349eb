"""Many flights and many fits, here and on a cluster."""

from __future__ import annotations

import json
import os
import shutil
import signal
import threading
from collections.abc import Callable, Iterator
from pathlib import Path

import duckdb
import numpy as np
import pandas
import polars
import pyarrow
import pyarrow.parquet
import pytest
from distributed import Client, LocalCluster

import planesman
from planesman import _parts, _progress

SHORT = {"description": "short", "duration": 4.0, "parameters": {"depth_controller": {"depth_setpoint": 0.1}}}
VARY = {"depth_controller.depth.p": [0.5, 1.0, 1.5], "plant_sim.speed": "1ft/s,2ft/s", "dha_actuator.model": ["ideal", "dha"]}


@pytest.fixture(scope="module")
def client() -> Iterator[Client]:
    cluster = LocalCluster(n_workers=2, threads_per_worker=1, processes=True, host="127.0.0.1", dashboard_address=None)
    with cluster, Client(cluster) as client:
        yield client


def table(folder: Path) -> pandas.DataFrame:
    """A dataset, in the order of its cases."""
    return duckdb.sql(f"select * from '{folder}/*.parquet' order by 1").df()


def same(one: pandas.DataFrame, other: pandas.DataFrame) -> bool:
    return one.astype(object).where(one.notna(), None).equals(other.astype(object).where(other.notna(), None))


def test_a_sweep_has_a_row_a_case() -> None:
    cases = planesman.sweep(SHORT, VARY, seeds=2)
    frame = pandas.DataFrame(cases)
    assert frame["case"].tolist() == list(range(3 * 2 * 2 * 2))
    assert sorted(set(frame["plant_sim.speed [m/s]"])) == [0.3048, 0.6096]
    assert frame["dha_actuator.model"][:4].tolist() == ["ideal", "ideal", "dha", "dha"]
    assert frame["seed"][:2].tolist() == [1, 2]
    assert (frame["plane_travel [rad]"] > 0.0).all() and (frame["error"] == "").all()


def test_a_case_is_the_flight_of_its_parameters() -> None:
    cases = planesman.sweep("dive", {"depth_controller.depth.p": np.array([0.9, 1.1])}, plant_sim={"speed": "2ft/s"})
    flight = planesman.simulate("dive", depth_controller={"depth.p": 1.1}, plant_sim={"speed": "2ft/s"})
    assert cases["pulses [1]"][1] == flight["pulses"][-1] != cases["pulses [1]"][0]
    assert cases["depth_setpoint [m]"][1] == flight["depth_setpoint"][-1]


def test_a_dataset_goes_on_where_it_stopped_and_is_read_by_others(tmp_path: Path) -> None:
    whole = pandas.DataFrame(planesman.sweep(SHORT, VARY, seeds=2))
    whole["error"] = None
    folder = planesman.sweep(SHORT, VARY, seeds=2, out=tmp_path / "sweep", parts=5)
    assert folder == tmp_path / "sweep" / "cases"
    files = sorted(folder.iterdir())
    assert [file.name for file in files] == [f"part-{part:04}-of-0005.parquet" for part in range(1, 6)]
    assert same(table(folder), whole)
    before = {file: file.stat().st_mtime_ns for file in files}
    bytes_before = files[2].read_bytes()
    files[2].unlink()
    planesman.sweep(SHORT, VARY, seeds=2, out=tmp_path / "sweep", parts=5)
    assert files[2].read_bytes() == bytes_before
    assert all(file.stat().st_mtime_ns == before[file] for file in files if file != files[2])

    by_polars = polars.read_parquet(folder).sort("case")
    assert by_polars["case"].to_list() == list(range(24))
    assert by_polars["error"].null_count() == 24
    assert same(pandas.read_parquet(folder).sort_values("case", ignore_index=True), whole)


# As a power cut leaves a file on some file systems: empty, cut, or with zeros where its end was to be.
@pytest.mark.parametrize("cut", [lambda it: b"", lambda it: it[: len(it) // 2], lambda it: it[:-1], lambda it: it[:-8] + bytes(8)])
def test_a_part_that_is_not_whole_is_computed_again(cut: Callable[[bytes], bytes], tmp_path: Path) -> None:
    def work(part: int, of: int) -> pyarrow.Table:
        return pyarrow.table({"case": [part]})

    folder = _parts.fill(tmp_path / "cases", 3, work, None)
    whole = {file: file.read_bytes() for file in folder.iterdir()}
    hurt = _parts.path_of(folder, 2, 3)
    hurt.write_bytes(cut(whole[hurt]))
    assert _parts.fill(folder, 3, work, None) == folder
    assert {file: file.read_bytes() for file in folder.iterdir()} == whole


def test_a_part_of_another_number_of_rows_is_computed_again(tmp_path: Path) -> None:
    pyarrow.parquet.write_table(pyarrow.table({"case": [1, 2]}), _parts.path_of(tmp_path, 1, 1))
    _parts.fill(tmp_path, 1, lambda part, of: pyarrow.table({"case": [part]}), None)
    assert len(table(tmp_path)) == 1


def test_a_number_that_is_not_there_is_null(tmp_path: Path) -> None:
    wild = {"plant_sim.environment.seaway.moment": [0, 10000]}
    rows = table(planesman.sweep(SHORT, wild, out=tmp_path / "wild"))
    assert rows["error"].notna().tolist() == [False, True] and "plant_sim: " in rows["error"][1]
    found = duckdb.sql(f"""select count(*) from '{tmp_path}/wild/cases/*.parquet' where "steady_error [m]" is null""")
    assert found.fetchall() == [(1,)]
    assert np.isnan(planesman.sweep(SHORT, wild)["steady_error [m]"][1])


def test_what_is_refused_is_refused_before_the_first_flight(tmp_path: Path) -> None:
    one = {"depth_controller.depth.p": "0.5:1.5:0.5"}
    planesman.sweep(SHORT, one, out=tmp_path / "one")
    for vary, options, sentence in [
        ({"depth_controller.depht.p": [1.0]}, {}, "did you mean 'depth.p'"),
        ({"depth_controller.depth.p": [1.0, -1.0]}, {}, "must lie in"),
        ({"depth_controller.depth.p": "0..1"}, {}, "needs a number of samples. Give samples=N"),
        ({"dha_actuator.logic.mode": ["single_speed", "two_speed"]}, {}, "1 of 2 combinations"),
        (one, {"out": tmp_path / "one", "seeds": 2}, "another sweep"),
        (one, {"out": tmp_path / "one", "parts": 2}, "this sweep in 3 parts"),
        (one, {"out": tmp_path / "two", "parts": 9}, "there are 3 combinations"),
        (one, {"out": tmp_path / "two", "parts": 0}, "parts: 0 refused"),
    ]:
        with pytest.raises(planesman.PlanesmanError, match=sentence):
            planesman.sweep(SHORT, vary, **options)
    with pytest.raises(TypeError, match=r"sweep\(\) got an unexpected keyword argument 'seed'; did you mean 'seeds'\?"):
        planesman.sweep(SHORT, one, seed=3)


def test_a_sweep_of_weeks_and_a_fit_of_weeks_are_interrupted_at_once(flight: planesman.Flight) -> None:
    class Enough(Exception):
        pass

    def stop(*_: object) -> None:
        raise Enough

    # As the handler of Ctrl-C raises KeyboardInterrupt, on the main thread, while others work.
    before = signal.signal(signal.SIGALRM, stop)
    weeks = {"depth_controller.depth.p": [0.5, 1.0]}
    calls = [
        lambda: planesman.sweep("dive", weeks, seeds=1_000_000),
        # One flight of a day each: within a flight, too.
        lambda: planesman.sweep({**SHORT, "duration": 86_400.0}, weeks, seeds=1_000),
        lambda: planesman.fit(flight, "dive_planes", "pitch_rate", window=(20, 90), order=3, delay=1, bootstrap=100_000),
    ]
    try:
        for call in calls:
            signal.setitimer(signal.ITIMER_REAL, 1.0)
            with pytest.raises(Enough):
                call()
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)


def test_progress_is_shown_as_lines_where_it_is_asked_for(capfd: pytest.CaptureFixture[str]) -> None:
    told: list[str] = []
    with _progress.Progress("flights", 40, True) as progress:
        progress._began -= 60.0
        progress._drawn -= 60.0
        progress(10)
        progress(11)
    told = capfd.readouterr().err.splitlines()
    assert len(told) == 1 and told[0].startswith("flights [#######...") and "10/40, " in told[0] and told[0].endswith(" s left")
    with _progress.Progress("flights", 40, False) as progress:
        progress._drawn -= 60.0
        progress(10)
    assert capfd.readouterr().err == ""


def test_samples_are_drawn_as_often_as_asked() -> None:
    cases = planesman.sweep(SHORT, {"depth_controller.depth.p": "0.4..1.6"}, samples=7)
    gains = cases["depth_controller.depth.p [rad/m]"]
    assert len(set(gains)) == 7 and (gains >= 0.4).all() and (gains < 1.6).all()


def test_a_cluster_flies_the_same_and_needs_a_folder(client: Client, tmp_path: Path) -> None:
    with pytest.raises(planesman.PlanesmanError, match="needs out"):
        planesman.sweep(SHORT, VARY, client=client)  # type: ignore[call-overload]
    folder = planesman.sweep(SHORT, VARY, seeds=2, out=tmp_path / "sweep", client=client)
    whole = pandas.DataFrame(planesman.sweep(SHORT, VARY, seeds=2))
    whole["error"] = None
    assert same(table(folder), whole)


def test_a_worker_killed_in_mid_run_loses_nothing_and_nothing_is_twice(client: Client, tmp_path: Path) -> None:
    vary, seeds, parts = {"depth_controller.depth.p": "0.5:1.5:0.02"}, 3, 40
    options = {"seeds": seeds, "depth_controller": {"feedback.source": "kalman"}}
    scenario = {**SHORT, "duration": 30.0}
    workers = client.run(os.getpid)
    killed: dict[str, int] = {}

    def kill_one() -> None:
        cases = tmp_path / "sweep" / "cases"
        while not cases.is_dir() or sum(1 for it in cases.glob("*.parquet")) < 3:
            if stop.wait(0.01):
                return
        killed["there"] = sum(1 for it in cases.glob("*.parquet"))
        os.kill(next(iter(workers.values())), signal.SIGKILL)

    stop = threading.Event()
    killer = threading.Thread(target=kill_one)
    killer.start()
    try:
        folder = planesman.sweep(scenario, vary, out=tmp_path / "sweep", client=client, parts=parts, **options)
    finally:
        stop.set()
        killer.join()
    assert 3 <= killed["there"] < parts
    assert next(iter(workers.values())) not in client.run(os.getpid).values()
    rows = table(folder)
    assert rows["case"].tolist() == list(range(51 * seeds))
    assert len(list(folder.glob("*.parquet"))) == parts
    whole = pandas.DataFrame(planesman.sweep(scenario, vary, **options))
    whole["error"] = None
    assert same(rows, whole)


def test_an_error_of_a_part_ends_the_call(client: Client, tmp_path: Path) -> None:
    def work(part: int, of: int) -> pyarrow.Table:
        if part == 2:
            raise RuntimeError("part 2 is broken")
        return pyarrow.table({"case": [part]})

    with pytest.raises(RuntimeError, match="part 2 is broken"):
        _parts.fill(tmp_path / "cases", 3, work, client)
    assert not _parts.path_of(tmp_path / "cases", 2, 3).exists()


def test_a_worker_that_does_not_see_the_folder_says_so(tmp_path: Path) -> None:
    with pytest.raises(planesman.PlanesmanError, match="name a folder shared by all machines of the cluster"):
        _parts.write(tmp_path / "elsewhere", 1, 1, lambda part, of: pyarrow.table({"case": [part]}), 1)


def test_a_part_that_breaks_off_leaves_no_file(tmp_path: Path) -> None:
    class Broken:
        """No table: writing it fails."""

    with pytest.raises(AttributeError):
        _parts.write(tmp_path, 1, 1, lambda part, of: Broken(), 1)  # type: ignore[arg-type, return-value]
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("on_cluster", [False, True])
def test_every_bag_of_a_folder_is_fitted_once(on_cluster: bool, bag: Path, tmp_path: Path, request: pytest.FixtureRequest) -> None:
    bags = tmp_path / "bags"
    for number in range(5):
        (bags / f"day{number % 2}").mkdir(parents=True, exist_ok=True)
        shutil.copy(bag, bags / f"day{number % 2}" / f"dive{number}.mcap")
    (bags / "broken.mcap").write_bytes(b"no bag")
    client = request.getfixturevalue("client") if on_cluster else None
    signals = ("plane_motion:dive_planes", "state:pitch_rate")
    folder = planesman.fit_all(bags, *signals, window=(20, 90), order=3, delay=1, out=tmp_path / "fits", client=client, parts=3)
    rows = table(folder)
    assert rows["data"].tolist() == [str(bags / "broken.mcap")] + [
        str(bags / f"day{number % 2}" / f"dive{number}.mcap") for number in (0, 2, 4, 1, 3)
    ]
    assert "broken.mcap" in rows["error"][0] and rows["error"][1:].isna().all()
    model = planesman.fit(bag, *signals, window=(20, 90), order=3, delay=1)
    for row in rows[1:].itertuples():
        assert row.fit == model.fit and row.order == 3 and list(row.verdict) == model.verdict
        assert json.loads(row.model) == model.report["model"]
        assert row.pole_re[0] == pytest.approx(-0.355, abs=0.02) and row.pole_re_deviation[0] > 0.0
    again = planesman.fit_all(bags, *signals, window=(20, 90), order=3, delay=1, out=tmp_path / "fits", client=client, parts=3)
    assert again == folder and len(table(folder)) == 6
    with pytest.raises(planesman.PlanesmanError, match="other fits"):
        planesman.fit_all(bags, *signals, order=2, out=tmp_path / "fits")
    # Not a thousand rows with the same error.
    with pytest.raises(TypeError, match="unexpected keyword argument 'ordr'; did you mean 'order'"):
        planesman.fit_all(bags, *signals, ordr=2, out=tmp_path / "others")


def test_every_file_that_fit_reads_is_found_in_a_folder(tmp_path: Path) -> None:
    data = tmp_path / "data"
    data.mkdir()
    random = np.random.default_rng(1)
    u = np.repeat(random.choice([-1.0, 1.0], 60), 5)
    y = 0.01 * random.standard_normal(300)
    for k in range(1, 300):
        y[k] += 0.8 * y[k - 1] + 0.5 * u[k - 1]
    tables = ["a.csv", "b.tsv", "c.txt", "d.dat", "e.LVM", "f.log", "g.asc", "h.prn", "i.tab"]
    for name in tables:
        np.savetxt(data / name, np.c_[0.1 * np.arange(300), u, y], header="t,u,y", comments="", delimiter=",")
    logs = ["j.ulg", "k.ulog", "l.bin", "m.BIN", "n.tlog", "o.alog"]
    for name in [*logs, "p.mcap", "p.mcap.zstd", "q.db3.zstd", "model.json", "notes.md", "r.parquet", "none"]:
        (data / name).write_bytes(b"no data")
    rows = table(planesman.fit_all(data, "u", "y", order=1, delay=1, out=tmp_path / "fits"))
    # What is packed beside the same unpacked is no other bag.
    assert [Path(it).name for it in rows["data"]] == [*tables, *logs, "p.mcap", "q.db3.zstd"]
    assert rows["error"][: len(tables)].isna().all() and rows["error"][len(tables) :].notna().all()
    model = planesman.fit(data / "a.csv", "u", "y", order=1, delay=1)
    assert (rows["fit"][: len(tables)] == model.fit).all()


def test_a_folder_without_bags_is_refused(tmp_path: Path) -> None:
    with pytest.raises(planesman.PlanesmanError, match="no bag"):
        planesman.fit_all(tmp_path, "u", "y", out=tmp_path / "fits")
