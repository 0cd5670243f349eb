"""Models from bags and arrays."""

from __future__ import annotations

import inspect
import pickle
import typing
from pathlib import Path

import control
import numpy as np
import pandas
import pytest
from numpy.typing import NDArray
from scipy import signal

import planesman
from planesman import _native, _tables
from planesman.identification import FitOptions

TRUE = [-0.3554 + 0.1259j, -0.3554 - 0.1259j, -1.0102]
"""The vehicle's poles at 1 ft/s, 1/s."""


@pytest.fixture(scope="module")
def model(bag: Path) -> planesman.Model:
    return planesman.fit(bag, "plane_motion:dive_planes", "state:pitch_rate", window=(20, 90), order=3, speed="1ft/s")


def arrays(noise: float = 0.01, samples: int = 2000) -> dict[str, NDArray[np.float64]]:
    """y of 0.1 z / (z^2 - 1.7 z + 0.745), with noise on it."""
    random = np.random.default_rng(1)
    u = np.repeat(random.choice([-1.0, 1.0], samples // 10), 10)
    y = np.zeros(samples)
    for k in range(2, samples):
        y[k] = 1.7 * y[k - 1] - 0.745 * y[k - 2] + 0.1 * u[k - 1]
    return {"u": u, "y": y + noise * random.standard_normal(samples)}


def test_the_vehicles_poles_are_found(model: planesman.Model) -> None:
    assert model.continuous_poles.shape == (3,) and model.order == 3
    for true in TRUE:
        assert np.abs(model.continuous_poles - true).min() < 0.01
    assert model.fit is not None and model.fit > 99.0
    assert any("verdict" in sentence for sentence in model.verdict)
    assert model.uncertainty.covariance.shape == (len(model.num) + 3,) * 2


def test_poles_lie_within_their_uncertainty() -> None:
    model = planesman.fit(arrays(noise=0.1), "u", "y", sample_time=0.05, order=2, delay=1, method="output_error")
    off = model.uncertainty.poles
    for true in np.roots([1.0, -1.7, 0.745]):
        nearest = np.argmin(np.abs(model.poles - true))
        error = model.poles[nearest] - true
        assert abs(error.real) < 4.0 * off[nearest].real < 0.05
        assert abs(error.imag) < 4.0 * off[nearest].imag < 0.05


def test_python_control_takes_the_model(model: planesman.Model) -> None:
    sampled = model.to_control()
    assert sampled.dt == model.sample_time
    # control finds the roots anew.
    assert np.sort_complex(sampled.poles()) == pytest.approx(np.sort_complex(model.poles), abs=1e-7)
    continuous = model.to_control(continuous=True)
    assert np.sort_complex(continuous.poles()) == pytest.approx(np.sort_complex(model.continuous_poles), abs=1e-5)
    response = model.frequency_response([0.1, 1.0, 5.0])
    assert response.value == pytest.approx([sampled(np.exp(1j * w * model.sample_time)) for w in response.omega], rel=1e-9)
    assert (response.magnitude_deviation > 0.0).all() and (response.phase_deviation > 0.0).all()


def test_arrays_frames_and_flights_are_data(flight: planesman.Flight) -> None:
    data = arrays()
    model = planesman.fit(data, "u", "y", sample_time=0.05, order=2, method="output_error", delay=1)
    assert model.poles == pytest.approx(np.roots([1.0, -1.7, 0.745]), abs=5e-3)
    assert model.record is not None and np.array_equal(model.record["measured"], data["y"])
    frame = pandas.DataFrame(data).assign(time=np.arange(2000) * 0.05)
    again = planesman.fit(frame, "u", "y", order=2, method="output_error", delay=1)
    assert again.den == pytest.approx(model.den, abs=1e-9)
    flown = planesman.fit(flight, "dive_planes", "pitch_rate", window=(20, 90), order=3)
    assert flown.input == "dive_planes" and flown.sample_time == 0.05


def test_an_array_that_is_strided_or_of_other_numbers_is_taken() -> None:
    data = arrays()
    doubled = {name: np.repeat(column, 2)[::2] for name, column in data.items()}
    assert not doubled["u"].flags.c_contiguous
    single = {"u": doubled["u"].astype(np.int64), "y": doubled["y"]}
    options: FitOptions = {"sample_time": 0.05, "order": 2, "delay": 1}
    assert np.array_equal(planesman.fit(single, "u", "y", **options).den, planesman.fit(data, "u", "y", **options).den)


def test_a_model_survives_file_and_pickle(model: planesman.Model, tmp_path: Path) -> None:
    for name in ("model.json", "model.yaml"):
        model.save(tmp_path / name)
        loaded = planesman.Model.load(tmp_path / name)
        assert np.array_equal(loaded.den, model.den) and loaded.verdict == model.verdict
        assert loaded.record is None
        assert np.array_equal(loaded.frequency_response().value, model.frequency_response().value, equal_nan=True)
    sent = pickle.loads(pickle.dumps(model))
    assert sent.report == model.report and np.array_equal(sent.record["simulated"], model.record["simulated"])
    # The simulator takes the file as its vehicle.
    flown = planesman.simulate("dive", duration=5.0, plant_sim={"vehicle": tmp_path / "model.yaml"})
    assert len(flown["depth"]) == 100


def test_a_delay_has_no_place_in_s() -> None:
    data = arrays()
    late = {"u": data["u"], "y": np.concatenate([np.zeros(10), data["y"][:-10]])}
    model = planesman.fit(late, "u", "y", sample_time=0.05, order=2, delay=11)
    assert len(model.to_control().poles()) >= 2
    with pytest.raises(planesman.PlanesmanError, match="delay of"):
        model.to_control(continuous=True)


def test_what_is_refused_is_refused_in_one_sentence(bag: Path) -> None:
    data = arrays(samples=200)
    for call, sentence in [
        (lambda: planesman.fit(bag, "plane_motion:dive_planes", "state:pitch_rat"), "pitch_rat"),
        (lambda: planesman.fit(bag, "state:pitch", "state:pitch"), "both as input and as output"),
        (lambda: planesman.fit(data, "u", "y"), "sample_time"),
        (lambda: planesman.fit(data, "u", "z", sample_time=0.05), "no column 'z'; there are u, y"),
        (lambda: planesman.fit({**data, "u": data["u"][1:]}, "u", "y", sample_time=0.05), "all columns must have the same length"),
        (lambda: planesman.fit({"u": np.eye(2), "y": np.eye(2)}, "u", "y", sample_time=0.05), r"shape \(2, 2\)"),
        (lambda: planesman.fit({"u": ["a"], "y": [1.0]}, "u", "y", sample_time=0.05), "not an array of numbers"),
        (lambda: planesman.fit(data, "u", "y", sample_time=0.05, order=99), "99"),
        (lambda: planesman.fit(data, "u", "y", sample_time=0.05, method="magic"), "magic"),
        (lambda: planesman.fit(data, "u", "y", sample_time=-1.0), "-1"),
        (lambda: planesman.fit({**data, "u": data["u"] + 1j}, "u", "y", sample_time=0.05), "'u' is not an array of numbers: it is complex"),
        (lambda: planesman.fit(data, "u", "y", sample_time=0.05, heave=(1, 0, 0, 0)), "heave and vehicle need method='vehicle' or kalman"),
        (lambda: planesman.fit(data, "u", "y", sample_time=0.05, window=(0, 5), validation=(3, 9)), r"window=\(0, 5\) overlaps validation=\(3, 9\)"),
    ]:
        with pytest.raises(planesman.PlanesmanError, match=sentence) as refusal:
            call()
        assert "\n" not in str(refusal.value) and "--" not in str(refusal.value), refusal.value
    with pytest.raises(TypeError, match=r"fit\(\) got an unexpected keyword argument 'ordr'; did you mean 'order'\?"):
        planesman.fit(data, "u", "y", sample_time=0.05, ordr=2)  # type: ignore[call-arg]


@pytest.mark.parametrize(
    ("keywords", "message"),
    [
        ({"heave": [1.0, 2.0, 3.0, 4.0], "method": "armax"}, "heave and vehicle need method='vehicle' or kalman"),
        ({"prewindow": True}, "prewindow needs order"),
        ({"forgetting": 0.9, "method": "armax"}, "apply only to recursive methods such as method='recursive_least_squares'"),
        ({"window": (0, 20), "validation": (10, 30)}, "window=(0, 20) overlaps validation=(10, 30)"),
    ],
)
def test_messages_are_in_pythons_words(keywords: dict[str, typing.Any], message: str) -> None:
    with pytest.raises(planesman.PlanesmanError) as refusal:
        planesman.fit(arrays(), "u", "y", sample_time=0.05, **keywords)
    assert message in str(refusal.value)


def test_a_verdict_is_in_pythons_words() -> None:
    data = arrays()
    constant = {"u": data["u"], "y": data["y"] + np.linspace(0.0, 40.0, 2000)}
    verdict = planesman.fit(constant, "u", "y", sample_time=0.05, order=2, delay=1).verdict
    assert verdict and not any("--" in sentence for sentence in verdict), verdict


def test_what_the_package_returns_is_data(flight: planesman.Flight, bag: Path) -> None:
    options: FitOptions = {"window": (20, 90), "order": 3, "delay": 1}
    known = planesman.fit(flight, "dive_planes", "pitch_rate", **options)
    # The time is the index of a frame.
    framed = planesman.fit(flight.frame(), "dive_planes", "pitch_rate", **options)
    assert np.array_equal(framed.den, known.den)
    timed = flight.frame()[["dive_planes", "pitch_rate"]]
    timed.index = pandas.to_datetime(timed.index, unit="s", origin="2026-01-01")
    assert planesman.fit(timed, "dive_planes", "pitch_rate", **options).den == pytest.approx(known.den, abs=1e-9)
    # Samples have stamps of their own: two topics of one loop, and a sensor's at other instants.
    signals = ["control_state:dive_planes", "state:pitch_rate", "state:dive_planes"]
    read = planesman.read_bag(bag, signals)
    model = planesman.fit(read, "state:dive_planes", "state:pitch_rate", **options)
    assert model.input == "state:dive_planes" and model.den == pytest.approx(known.den, abs=1e-9)
    framed = planesman.fit(
        pandas.DataFrame({name: samples.series() for name, samples in read.items()}), "state:dive_planes", "state:pitch_rate", **options
    )
    assert framed.den == pytest.approx(known.den, abs=1e-6)
    apart = {name: planesman.Samples(it.stamp[place::2], it.value[place::2], it.origin) for place, (name, it) in enumerate(read.items()) if place < 2}
    odd = planesman.fit(apart, *signals[:2], window=(20, 90), order=3, delay=1)
    assert odd.sample_time == pytest.approx(0.1)
    back = planesman.Samples(np.concatenate([read[signals[1]].stamp] * 2), np.concatenate([read[signals[1]].value] * 2), 0)
    with pytest.raises(planesman.PlanesmanError, match="its time goes back"):
        planesman.fit({"u": read[signals[0]], "y": back}, "u", "y")


def test_a_folder_of_several_bags_is_refused_and_a_list_is_several_experiments(tmp_path: Path) -> None:
    bags = [tmp_path / f"run_{number}.mcap" for number in (1, 2)]
    for seed, path in enumerate(bags, 1):
        planesman.simulate("dive", seed=seed, bag=path, depth_controller={"identification.seed": seed})
    signals = ("plane_motion:dive_planes", "state:pitch_rate")
    for call in [lambda: planesman.fit(tmp_path, *signals), lambda: planesman.read_bag(tmp_path, signals), lambda: planesman.read_bag(bags, signals)]:
        with pytest.raises(planesman.PlanesmanError, match=r"several bags \(times overlap\): run_1.mcap, run_2.mcap; name one"):
            call()
    both = planesman.fit(bags, *signals, order=3, delay=1)
    one = planesman.fit(bags[0], *signals, order=3, delay=1)
    assert both.report["record"]["samples"] > 1.9 * one.report["record"]["samples"]
    for true in TRUE:
        assert np.abs(both.continuous_poles - true).min() < 0.03


def test_own_equations_and_a_curve_are_fitted_to_arrays(tmp_path: Path) -> None:
    # 2 / (0.5 s + 1) behind a dead zone of 0.3, sampled every 0.1 s.
    random = np.random.default_rng(2)
    u = np.repeat(random.uniform(-2, 2, 80), 10)
    pole = np.exp(-0.2)
    moved = np.sign(u) * np.maximum(np.abs(u) - 0.3, 0)
    x = signal.lfilter([0, 2 * (1 - pole)], [1, -pole], moved)
    data = {"time": 0.1 * np.arange(len(u)), "volts": u, "y": x + 0.01 * random.standard_normal(len(u))}
    equations = tmp_path / "motor.yaml"
    equations.write_text(
        "inputs: [u]\noutputs: {y: {equation: x}}\n"
        "states: {x: {derivative: '(K*deadzone(u, -w, w) - x)/T', initial: 0}}\n"
        "parameters: {K: {start: 1}, T: {start: 1, min: 0.01}, w: {start: 0.1, min: 0}}\n"
    )
    found = planesman.fit_equations(data, equations, inputs={"u": "volts"})
    truth = {"K": 2.0, "T": 0.5, "w": 0.3}
    for it in found["parameters"]:
        assert abs(it["value"] - truth[it["name"]]) < 4 * it["deviation"] < 0.1
    curved = planesman.fit({"volts": u, "y": data["y"]}, "volts", "y", sample_time=0.1)
    assert curved.curve is not None and curved.curve["kind"] == "dead zone"
    levels = {it["name"]: it["value"] for it in curved.curve["parameters"]}
    assert levels == pytest.approx({"lower": -0.3, "upper": 0.3}, abs=0.02)
    assert abs(curved.steady_state_gain - 2) < 0.05


def test_nothing_is_said_beyond_the_nyquist_frequency(model: planesman.Model) -> None:
    most = np.pi / model.sample_time
    assert np.isfinite(model.frequency_response([0.1, most]).value).all()
    for beyond in (1.01 * most, [0.1, 2.0 * most], np.nan, np.inf):
        with pytest.raises(planesman.PlanesmanError, match="Nyquist frequency, 62.8"):
            model.frequency_response(beyond)
    with pytest.raises(planesman.PlanesmanError, match="complex"):
        model.frequency_response(1j)


def test_the_noise_is_a_model_too() -> None:
    # ARMAX: y = 1.7 y - 0.745 y + 0.1 u + e + 0.6 e.
    random = np.random.default_rng(2)
    u = np.repeat(random.choice([-1.0, 1.0], 1000), 10)
    e = 0.05 * random.standard_normal(len(u))
    y = signal.lfilter([0.0, 0.1], [1.0, -1.7, 0.745], u) + signal.lfilter([1.0, 0.6], [1.0, -1.7, 0.745], e)
    model = planesman.fit({"u": u, "y": y}, "u", "y", sample_time=0.05, order=2, delay=1, method="armax")
    noise = model.noise_model()
    # It is close to the true one at all frequencies, and so is the spectrum of the noise.
    _, true = signal.freqz([1.0, 0.6], [1.0, -1.7, 0.745], np.array([0.02, 0.2, 1.0, 2.0]))
    found = np.array([noise(np.exp(1j * w)) for w in (0.02, 0.2, 1.0, 2.0)])
    assert np.abs(found / true - 1.0).max() < 0.15
    assert model.noise_variance == pytest.approx(0.05**2, rel=0.1)
    assert noise.input_labels == ["e"] and noise.output_labels == ["y"]
    assert isinstance(model.noise_model(form="ss"), control.StateSpace)
    assert planesman.fit({"u": u, "y": y}, "u", "y", sample_time=0.05, order=2, delay=1, method="output_error").noise_model() is None


def test_python_control_is_told_the_names_and_takes_state_space(bag: Path) -> None:
    model = planesman.fit(bag, "plane_motion:dive_planes", "imu:angular_velocity.y", window=(20, 90), order=3, delay=1)
    sampled = model.to_control()
    # Dots divide system and signal in python-control.
    assert sampled.input_labels == ["plane_motion:dive_planes"] and sampled.output_labels == ["imu:angular_velocity_y"]
    state = model.to_control(form="ss")
    assert isinstance(state, control.StateSpace) and state.dt == model.sample_time and state.input_labels == sampled.input_labels
    at = np.exp(0.1j)
    assert state(at) == pytest.approx(sampled(at), rel=1e-6)
    with pytest.raises(planesman.PlanesmanError, match="form: 'zpk' refused"):
        model.to_control(form="zpk")  # type: ignore[arg-type]


def test_models_flights_and_tables_show_themselves(model: planesman.Model, flight: planesman.Flight) -> None:
    shown = model._repr_html_()
    assert "±" in shown and "damping ratio" in shown and model.verdict[-1].split("'")[0] in shown
    assert "<td>depth_setpoint</td><td>m</td>" in flight._repr_html_()
    table = planesman.parameters("sysid")
    assert isinstance(table, list) and table._repr_html_().count("<tr>") < 15 and f"{len(table)} rows" in table._repr_html_()
    assert table.frame()["name"].tolist() == [row["name"] for row in table]
    # What a bag or a file says is text.
    row = _tables.Table([{"a<b>": "<script>", "n": float("nan"), "none": None}])
    assert row._repr_html_().count("<script>") == 0 and "a&lt;b&gt;" in row._repr_html_()


def test_the_typed_options_are_those_of_the_program() -> None:
    # What the package itself says or does.
    own = {"input", "output", "quiet", "json", "model", "html"}
    options = {name: values for name, values in _native.fit_options() if name not in own | {"help"}}
    typed = typing.get_type_hints(FitOptions)
    assert set(typed) == set(options)
    for name, hint in typed.items():
        if typing.get_origin(hint) is typing.Literal:
            assert set(typing.get_args(hint)) == set(options[name]), name


def test_everything_public_has_a_docstring() -> None:
    for name in planesman.__all__:
        found = getattr(planesman, name)
        assert inspect.getdoc(found), name
        if inspect.isclass(found):
            for member, of in vars(found).items():
                if callable(of) and not member.startswith("_"):
                    assert inspect.getdoc(of), f"{name}.{member}"


def test_a_model_is_drawn_with_and_without_data(model: planesman.Model, tmp_path: Path) -> None:
    assert len(model.plot().axes) == 6
    model.save(tmp_path / "model.json")
    assert len(planesman.Model.load(tmp_path / "model.json").plot().axes) == 3


def test_the_loop_is_closed_with_the_identified_model(model: planesman.Model) -> None:
    loop = control.feedback(-0.2 * model.to_control())
    assert isinstance(loop, control.TransferFunction)
