"""Scenarios flown in this process."""

from __future__ import annotations

import signal
import sys
import threading
from pathlib import Path

import control
import numpy as np
import pytest

import planesman


def test_a_dive_has_a_number_a_tick_and_reaches_its_depth(flight: planesman.Flight) -> None:
    assert set(flight) >= {"time", "depth", "pitch", "pitch_rate", "dive_planes", "depth_setpoint"}
    assert all(column.shape == (1800,) and column.dtype == np.float64 for column in flight.values())
    assert flight.units["depth"] == "m" and flight.units["pitch_rate"] == "rad/s"
    assert flight["depth"][-1] == pytest.approx(0.9144, abs=0.03)
    assert flight.frame().loc[10.0, "depth"] == flight["depth"][200]


def test_parameters_are_given_by_node_or_by_full_name() -> None:
    by_node = planesman.simulate(duration=20.0, depth_controller={"depth.p": 1.3, "depth": {"d": 0.5}}, plant_sim={"speed": "2ft/s"})
    full = {"depth_controller.depth.p": 1.3, "depth_controller.depth.d": 0.5, "plant_sim.speed": 0.6096}
    by_name = planesman.simulate(duration=20.0, **full)
    assert np.array_equal(by_node["depth"], by_name["depth"])
    assert not np.array_equal(by_node["depth"], planesman.simulate(duration=20.0)["depth"])
    assert len(by_node["time"]) == 400


def test_a_scenario_is_a_name_a_file_or_its_contents(tmp_path: Path) -> None:
    contents = {"description": "short", "duration": 4.0, "parameters": {"depth_controller": {"depth_setpoint": np.float64(0.1)}}}
    file = tmp_path / "short.yaml"
    file.write_text("{description: short, duration: 4.0, parameters: {depth_controller: {depth_setpoint: 0.1}}}")
    assert np.array_equal(planesman.simulate(contents)["depth"], planesman.simulate(file)["depth"])


def test_noise_follows_the_seed() -> None:
    def dive(seed: int) -> np.ndarray:
        return planesman.simulate(duration=10.0, seed=seed, depth_controller={"feedback.source": "kalman"})["depth"]

    assert np.array_equal(dive(1), dive(1))
    assert not np.array_equal(dive(1), dive(2))


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"depth_controller": {"depth.p": -1.0}}, r"\[0, 1000\]"),
        ({"depth_controller": {"depht.p": 1.0}}, "did you mean 'depth.p'"),
        ({"rudder": {"depth.p": 1.0}}, "unknown node 'rudder'"),
        ({"plant_sim": {"speed": float("nan")}}, "speed"),
        ({"duration": -1.0}, "duration: -1 refused: it must be positive and finite, in s"),
        ({"tick": float("inf")}, "tick: inf refused"),
        ({"scenario": "no_such"}, "unknown scenario 'no_such'"),
        ({"scenario": {"duration": 1.0}}, "description"),
    ],
)
def test_what_is_refused_is_refused_by_name(changes: dict, sentence: str) -> None:
    with pytest.raises(planesman.PlanesmanError, match=sentence):
        planesman.simulate(**changes)


def test_a_misspelt_keyword_is_refused_as_python_does() -> None:
    with pytest.raises(TypeError, match=r"simulate\(\) got an unexpected keyword argument 'durration'; did you mean 'duration'\?"):
        planesman.simulate(durration=3.0)
    with pytest.raises(TypeError, match="parameter_file"):
        planesman.parameter_file("dive", nod="sysid")


def test_a_bag_that_exists_is_not_overwritten(bag: Path) -> None:
    before = bag.read_bytes()
    with pytest.raises(planesman.PlanesmanError, match="exists already"):
        planesman.simulate("dive", duration=1.0, bag=bag)
    assert bag.read_bytes() == before


def test_other_threads_run_while_a_vehicle_flies() -> None:
    begun, ended = threading.Event(), threading.Event()

    def fly() -> None:
        begun.set()
        planesman.simulate("dive", duration=1500.0)
        ended.set()

    # No thread is made to yield: this one goes on only because the flight lets go of the interpreter.
    interval = sys.getswitchinterval()
    sys.setswitchinterval(1000.0)
    try:
        thread = threading.Thread(target=fly)
        thread.start()
        begun.wait()
        assert not ended.is_set()
    finally:
        sys.setswitchinterval(interval)
    thread.join()


def test_a_flight_is_interrupted() -> None:
    class Enough(Exception):
        pass

    def stop(*_: object) -> None:
        raise Enough

    before = signal.signal(signal.SIGALRM, stop)
    signal.setitimer(signal.ITIMER_REAL, 0.2)
    try:
        with pytest.raises(Enough):
            planesman.simulate("dive", duration=86_400.0)
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)


def test_a_transfer_function_is_that_of_the_linearised_vehicle() -> None:
    plant = planesman.transfer_function("brunner", speed="1ft/s")
    poles = np.sort_complex(np.roots(plant.den))
    assert poles == pytest.approx([-1.0102, -0.3554 - 0.1259j, -0.3554 + 0.1259j], abs=1e-4)
    continuous, sampled = plant.to_control(), plant.to_control(sampled=True)
    assert sampled.dt == 0.05 and continuous.isctime()
    assert np.exp(poles * 0.05) == pytest.approx(np.sort_complex(sampled.poles()), abs=1e-6)
    assert continuous.input_labels == ["dive_planes"] and continuous.output_labels == ["pitch_rate"]
    state = plant.to_control(form="ss")
    assert isinstance(state, control.StateSpace) and state.nstates == 3 and state.output_labels == ["pitch_rate"]
    # One foot per second is the default, as a number.
    assert np.array_equal(planesman.transfer_function().den, plant.den)
    with pytest.raises(planesman.PlanesmanError, match="output depth only"):
        planesman.transfer_function("brunner", "pitch_rate", "heave")


def test_parameters_are_listed_and_written_as_ros_reads_them() -> None:
    rows = {row["name"]: row for row in planesman.parameters("depth_controller")}
    assert rows["depth_controller.depth.p"]["unit"] == "rad/m"
    assert rows["depth_controller.depth.p"]["range"] == [0.0, 1000.0]
    # Defaults are values, not their text.
    assert rows["depth_controller.depth.p"]["default"] == pytest.approx(0.25 / 0.3048)
    assert rows["depth_controller.mode"]["default"] == "depth" and rows["depth_controller.lockstep"]["default"] is False
    assert rows["depth_controller.schedule.times"]["default"] == []
    with pytest.raises(planesman.PlanesmanError, match=r"unknown node 'depth_controler'; known: .*; did you mean 'depth_controller'"):
        planesman.parameters("depth_controler")
    text = planesman.parameter_file("dive", node="depth_controller", depth_controller={"depth.p": 1.25})
    assert "/**/depth_controller:" in text and "depth.p: 1.25" in text


def test_the_reports_numbers_are_recomputed(reports: str, monkeypatch: pytest.MonkeyPatch) -> None:
    rows = planesman.reproduce(reports)
    verdicts = [row["verdict"] for row in rows]
    assert len(rows) > 500 and verdicts.count("agrees") > 100
    assert all(row["erratum"] for row in rows if row["verdict"] == "contradicts")
    monkeypatch.setenv("PLANESMAN_REPORTS", reports)
    assert planesman.reproduce() == rows


def test_a_reports_program_that_is_not_there_is_refused_with_the_command_that_builds_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("PLANESMAN_REPORTS", raising=False)
    monkeypatch.setenv("PATH", str(tmp_path))
    for program in (None, tmp_path / "planesman-reports"):
        with pytest.raises(planesman.PlanesmanError, match="cargo build --release --package planesman-reports"):
            planesman.reproduce(program)
    failing = tmp_path / "planesman-reports"
    failing.write_text("#!/bin/sh\necho 'planesman-reports: 1 number differs from the book' >&2\nexit 1\n")
    failing.chmod(0o755)
    with pytest.raises(planesman.PlanesmanError, match="^planesman-reports: 1 number differs from the book$"):
        planesman.reproduce()


def test_a_flight_is_drawn(flight: planesman.Flight) -> None:
    figure = flight.plot()
    assert [axes.get_ylabel() for axes in figure.axes] == ["depth [m]", "pitch [rad]", "dive_planes [rad]"]


def law(time: float, state: planesman.simulation.NDArray[np.float64]) -> float:
    """Depth to pitch to planes, by program T6's gains and limits."""
    depth, rate, pitch, pitch_rate = state[0], state[1], state[6], state[7]
    command = np.clip(-1.0 * (0.9144 - depth) + 1.5 * rate, -0.3, 0.3)
    return float(np.clip(1.5 * (pitch - command) + 1.0 * pitch_rate, -0.4, 0.4))


def test_a_law_of_ones_own_dives_and_its_bag_is_read_as_any_other(tmp_path: Path) -> None:
    bag = tmp_path / "own.mcap"
    with planesman.Loop("dive", controller=law, bag=bag) as loop:
        states = np.array(list(loop))
        assert loop.is_over and loop.time == pytest.approx(90.0)
    assert states.shape == (1800, len(planesman.STATES)) and states.dtype == np.float64
    assert states[-1, 0] == pytest.approx(0.9144, abs=0.03)
    read = planesman.read_bag(bag, ["state:depth", "plane_command:dive_planes"])
    assert np.array_equal(read["state:depth"].value[1:], states[:-1, 0])
    assert np.abs(read["plane_command:dive_planes"].value).max() <= 0.4


def test_without_a_law_the_loop_is_the_one_that_simulate_flies() -> None:
    flown = planesman.simulate("dive", duration=5.0)
    loop = planesman.Loop("dive", duration=5.0)
    depths = [loop.state[0]] + [state[0] for state in loop]
    assert np.array_equal(depths[:-1], flown["depth"])


def test_what_a_law_raises_is_raised_and_what_it_gives_is_checked() -> None:
    def fails(time: float, state: object) -> float:
        raise KeyError("mine")

    with pytest.raises(KeyError, match="mine"):
        planesman.Loop("dive", controller=fails).step()
    with pytest.raises(planesman.PlanesmanError, match="not finite|finite"):
        planesman.Loop("dive", controller=lambda time, state: float("nan")).step()
    with pytest.raises(planesman.PlanesmanError, match="at least one plane angle"):
        planesman.Loop("dive", controller=lambda time, state: []).step()
    with pytest.raises(planesman.PlanesmanError, match="did you mean"):
        planesman.Loop("dvie")


def test_rudder_and_thrust_are_given_beside_the_planes() -> None:
    loop = planesman.Loop("remus_100", controller=lambda time, state: (0.0, 0.0, 0.0, 0.1, 0.5), duration=10.0)
    *_, last = loop
    assert last[list(planesman.STATES).index("yaw")] > 0.05
