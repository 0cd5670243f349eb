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

import planesman
from planesman import _native
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
        (lambda: planesman.fit(bag, "state:pitch", "state:pitch"), "input and the output"),
        (lambda: planesman.fit(data, "u", "y"), "sample_time"),
        (lambda: planesman.fit(data, "u", "z", sample_time=0.05), "no column 'z'; there are u, y"),
        (lambda: planesman.fit({**data, "u": data["u"][1:]}, "u", "y", sample_time=0.05), "all columns must be of one length"),
        (lambda: planesman.fit({"u": np.eye(2), "y": np.eye(2)}, "u", "y", sample_time=0.05), r"shape \(2, 2\)"),
        (lambda: planesman.fit({"u": ["a"], "y": [1.0]}, "u", "y", sample_time=0.05), "no array of numbers"),
        (lambda: planesman.fit(data, "u", "y", sample_time=0.05, order=99), "99"),
        (lambda: planesman.fit(data, "u", "y", sample_time=0.05, method="magic"), "magic"),
        (lambda: planesman.fit(data, "u", "y", sample_time=-1.0), "-1"),
        (lambda: planesman.fit(data, "u", "y", sample_time=0.05, ordr=2), "--ordr"),  # type: ignore[call-arg]
    ]:
        with pytest.raises(planesman.PlanesmanError, match=sentence) as refusal:
            call()
        assert "\n" not in str(refusal.value)


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
