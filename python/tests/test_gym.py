"""Environments of Gymnasium."""

from __future__ import annotations

import importlib
import importlib.util
import json
import warnings
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from scipy.integrate import solve_ivp

import planesman
import planesman.gym
from planesman.gym import AuvEnv, AuvVectorEnv

ROOT = Path(__file__).resolve().parents[2]

KINDS = [
    ("depth", "lauv"),
    ("depth", "remus_100_6dof"),
    ("heading", "bluerov2_heavy"),
    ("docking", "lauv"),
    ("docking", "bluerov2_heavy"),
    ("station", "lauv"),
    ("station", "bluerov2_heavy"),
]


@pytest.mark.parametrize(("task", "vehicle"), KINDS)
def test_gymnasiums_checker_has_nothing_to_say(task: str, vehicle: str) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        env = gymnasium.make(f"planesman/{task.capitalize()}-v0", vehicle=vehicle, observe="sensors").unwrapped
        check_env(env, skip_render_check=True)


@pytest.mark.parametrize("options", [{}, {"observe": "sensors", "randomise": {"mass": 0.1, "N_uu_rudder": (0.7, 1.2)}}])
def test_an_environment_among_many_is_the_one_alone_over_the_ends_of_episodes(options: dict) -> None:
    many = gymnasium.make_vec("planesman/Docking-v0", num_envs=70, duration=1.0, **options)
    ones = {k: AuvEnv("docking", duration=1.0, **options) for k in (0, 69)}
    seen, _ = many.reset(seed=5)
    for k, one in ones.items():
        assert np.array_equal(seen[k], one.reset(seed=5 + k)[0])
    many.action_space.seed(1)
    for _ in range(10):
        actions = many.action_space.sample()
        seen, rewards, terminated, truncated, _ = many.step(actions)
        for k, one in ones.items():
            alone = one.step(actions[k])
            assert np.array_equal(seen[k], alone[0]) and alone[1:4] == (rewards[k], terminated[k], truncated[k])
            assert np.array_equal(many.unwrapped.states[k], one.state)
            assert one.factors == {name: of[k] for name, of in many.unwrapped.factors.items()}
    assert truncated.all()
    # The next step begins the next episode: its action does nothing.
    before = many.unwrapped.factors
    _, rewards, terminated, truncated, info = many.step(actions)
    assert not rewards.any() and not terminated.any() and not truncated.any() and info == {}
    assert all((before[name] != of).all() for name, of in many.unwrapped.factors.items())
    with pytest.raises(gymnasium.error.ResetNeeded):
        ones[0].step(actions[0])


def test_results_are_arrays_of_their_own_that_stay() -> None:
    many = AuvVectorEnv("station", 3, "bluerov2_heavy")
    first, _ = many.reset(seed=1)
    assert first.shape == (3, 12) and first.dtype == np.float32 and first.base is not None
    kept = first.copy()
    second = many.step(np.zeros((3, 4)))[0]
    assert np.array_equal(first, kept) and not np.array_equal(first, second)
    assert np.array_equal(many.reset(seed=1)[0], first) and not np.array_equal(many.reset()[0], first)
    assert np.array_equal(many.reset(seed=[1, 2, 3])[0], first)
    assert np.array_equal(many.reset(seed=[None, 2, None])[0] == first, np.array([[False], [True], [False]]) | (first == 0.0))
    with pytest.raises(planesman.PlanesmanError, match="seeds: 2 given; 3 are expected"):
        many.reset(seed=[1, 2])
    with pytest.raises(planesman.PlanesmanError, match="num_envs: 0 refused"):
        AuvVectorEnv("depth", 0)


def test_the_observation_is_what_the_state_says() -> None:
    env = AuvEnv("station", "bluerov2_heavy")
    env.reset(seed=3)
    for _ in range(20):
        seen, reward, *_ = env.step(np.array([0.5, -0.2, 0.1, 0.6]))
    x, y, z, a, b, c, d, *velocity = env.state
    yaw = np.arctan2(2 * (a * d + b * c), 1 - 2 * (c * c + d * d))
    pitch = np.arcsin(2 * (a * c - b * d))
    roll = np.arctan2(2 * (a * b + c * d), 1 - 2 * (b * b + c * c))
    ahead, starboard = -x * np.cos(yaw) - y * np.sin(yaw), x * np.sin(yaw) - y * np.cos(yaw)
    assert [it.name for it in env.quantities][:6] == ["ahead", "starboard", "below", "heading_error", "roll", "pitch"]
    assert seen == pytest.approx([ahead, starboard, 20.0 - z, -yaw, roll, pitch, *velocity], abs=1e-6)
    effort = np.mean(np.square([0.5, -0.2, 0.1, 0.6]))
    off = (x * x + y * y + (20.0 - z) ** 2) / 0.5**2
    assert reward == pytest.approx(0.1 / (1.0 + off + (yaw / 0.3) ** 2 + 0.1 * effort), rel=1e-6)


def test_a_vehicle_with_factors_moves_as_scipy_has_it_on_equations_written_anew(monkeypatch: pytest.MonkeyPatch) -> None:
    """The peer of benches/peers: matrices in numpy, DOP853 at 1e-12."""
    for folder in ("benches/peers/cases", "benches/peers"):
        monkeypatch.syspath_prepend(str(ROOT / folder))
    peer = importlib.import_module("six_dof")
    monkeypatch.setattr(peer, "CURRENT", np.zeros(3))
    spans = {"mass": 0.2, "Y_uv": 0.3, "linear_damping": 0.3, "M_qdot": 0.3}
    env = AuvEnv("docking", "lauv", current=0.0, substeps=20, randomise=spans)
    env.reset(seed=7)
    factor, lauv = env.factors, peer.lauv()
    lift = lauv.lift.copy()
    lift[1, 1] *= factor["Y_uv"]
    inertia, added = np.array([0.0405, 1.0701, 1.0701]) * factor["mass"], [1, 16, 16, 0.005, 1.3 * factor["M_qdot"], 1.3]
    damping = lauv.linear * factor["linear_damping"], lauv.quadratic
    own = peer.Vehicle(18 * factor["mass"], 176.58, 177.58, [0, 0, 0.01], [0, 0, 0], inertia, added, *damping, lift, lauv.held)
    state = env.state.copy()
    for angles in ([0.5, -0.25], [-1.0, 0.5], [0.25, 1.0]):
        tau, f = own.held(0.3 * angles[0], 0.3 * angles[1], 9.0)
        state = solve_ivp(lambda _, x: peer.rates(own, tau, f, x), (0.0, 1.0), state, method="DOP853", rtol=1e-12, atol=1e-12).y[:, -1]
        for _ in range(10):
            env.step(np.array(angles))
        assert env.state == pytest.approx(state, abs=1e-7)
        assert np.abs(env.state[[7, 11, 12]]).min() > 1e-3


def test_sensors_differ_from_the_truth_by_what_their_quantities_say() -> None:
    options = {"actions": {"rudder": 0.3}, "duration": 1000.0}
    many = AuvVectorEnv("heading", 2000, observe="sensors", **options)
    told = np.array([many.reset(seed=1)[0], many.step(np.zeros((2000, 1)))[0]])
    truth = AuvVectorEnv("heading", 2000, **options)
    exact = np.array([truth.reset(seed=1)[0], truth.step(np.zeros((2000, 1)))[0]])
    # Drawn after the episode, so that the vehicles are the same.
    off = told - exact
    off = off[:, np.abs(exact[0, :, 0]) < 1.0]
    deviation = np.array([it.deviation for it in many.quantities])
    assert np.std(off[0], axis=0) == pytest.approx(np.sqrt(2.0) * deviation, rel=0.1)
    # What two have in common is the bias.
    assert np.std(off[1] - off[0], axis=0) == pytest.approx(np.sqrt(2.0) * deviation, rel=0.1)


def test_factors_are_drawn_evenly_from_their_spans() -> None:
    many = AuvVectorEnv("depth", 2000, randomise={"mass": (0.9, 1.3), "linear_damping": 0.2})
    many.reset(seed=2)
    for name, (least, most) in {"mass": (0.9, 1.3), "linear_damping": (0.8, 1.2)}.items():
        drawn = many.factors[name]
        assert drawn.min() >= least and drawn.max() <= most
        quarters, _ = np.histogram(drawn, 4, (least, most))
        assert np.abs(quarters - 500).max() < 80


def test_laws_of_a_control_engineer_do_the_tasks() -> None:
    """The signs are those of the page: a law in physical units comes to its depth, its heading, and into the dock."""
    depth = AuvVectorEnv("depth", 50, "lauv")
    seen, _ = depth.reset(seed=1)
    for _ in range(399):
        error, rate, pitch, pitch_rate = seen.T
        dive = np.clip(-0.3 * error + 0.6 * rate, -0.5, 0.5)
        seen, *_ = depth.step(np.clip((1.5 * (pitch - dive) + 0.5 * pitch_rate) / 0.3, -1.0, 1.0)[:, np.newaxis])
    assert np.abs(seen[:, 0]).max() < 0.3

    heading = AuvVectorEnv("heading", 50, "remus_100_6dof")
    seen, _ = heading.reset(seed=1)
    for _ in range(199):
        seen, *_ = heading.step(((seen[:, 0] - seen[:, 1]) / 0.237)[:, np.newaxis])
    assert np.abs(seen[:, 0]).max() < 0.05

    dock = AuvVectorEnv("docking", 200, "bluerov2_heavy")
    seen, _ = dock.reset(seed=1)
    over, success = np.zeros(200, bool), np.zeros(200, bool)
    while not over.all():
        wanted = seen[:, :3] * [0.3, 0.6, 0.6]
        wanted[:, 0] = np.clip(wanted[:, 0], 0.1, 0.3)
        force = (wanted - seen[:, 6:9]) * [8.0, 8.0, 8.0]
        seen, _, terminated, truncated, info = dock.step(np.c_[force, seen[:, 3] - seen[:, 11]])
        now = (terminated | truncated) & ~over
        success |= now & info.get("success", np.zeros(200, bool))
        over |= now
    assert success.mean() > 0.9


def test_a_vehicle_of_ones_own_takes_the_place_of_a_built_in_one(tmp_path: Path) -> None:
    text = (ROOT / "crates/vehicle/vehicle/vehicles/six_dof/lauv.yaml").read_text()
    file = tmp_path / "own.yaml"
    file.write_text(text.replace("name: lauv", "name: own"))
    own = AuvEnv("depth", file, actions={"stern_planes": 0.3}, held={"thrust": 9.0}, speed=1.5)
    built_in = AuvEnv("depth", "lauv")
    assert np.array_equal(own.reset(seed=4)[0], built_in.reset(seed=4)[0])
    assert np.array_equal(own.step(np.array([0.3]))[0], built_in.step(np.array([0.3]))[0])
    assert own.moved == {"stern_planes": (-0.3, 0.3)}


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        ({"task": "station", "vehicle": "remus_100_6dof"}, "actions: none given; remus_100_6dof has rudder, stern_planes"),
        ({"task": "depth", "actions": {"heave": 1.0}}, "'heave' is none; lauv has rudder, stern_planes, thrust"),
        ({"task": "depth", "actions": {"rudder": (0.2, 0.1)}}, "rudder"),
        ({"task": "depth", "held": {"thrust": float("nan")}}, "held: thrust: nan refused: a finite number"),
        ({"task": "depth", "actions": {"rudder": "port"}}, "actions: rudder: 'port' refused: a finite number"),
        ({"task": "depth", "randomise": {"mass": (0.9, 1.0, 1.1)}}, "randomise: mass: .* refused: .minimum, maximum."),
        ({"task": "depth", "substeps": 2.5}, "substeps: 2.5 refused: a whole number"),
        ({"task": "depth", "duration": 1e9}, "duration / step: .* refused: 1 to 1e6 steps"),
        ({"task": "depth", "randomise": {"thrust": 0.1}}, "randomise: thrust: vehicle 'lauv' has no such number"),
        ({"task": "depth", "randomise": {"mass": 1.5}}, r"randomise: mass \[-0.5, 2.5\]"),
        ({"task": "depth", "vehicle": "luav"}, "vehicle file 'luav'.*lauv"),
        ({"task": "depth", "step": 0.0}, "step: 0 refused"),
        ({"task": "depth", "substeps": 0}, "substeps: 0 refused"),
        ({"task": "dept"}, "unknown variant `dept`"),
        ({"task": "depth", "observe": "all"}, "'state' or 'sensors'"),
        ({"task": "depth", "current": 1e3}, "current"),
    ],
)
def test_what_is_refused_is_refused_by_name(options: dict, sentence: str) -> None:
    with pytest.raises(planesman.PlanesmanError, match=sentence):
        AuvEnv(**options)


def test_actions_of_another_shape_or_no_numbers_are_refused() -> None:
    many = AuvVectorEnv("depth", 3)
    many.reset(seed=1)
    with pytest.raises(planesman.PlanesmanError, match=r"shape \(3,\) refused: \(3, 1\)"):
        many.step(np.zeros(3))
    with pytest.raises(planesman.PlanesmanError, match="environment 1 is not a number"):
        many.step(np.array([[0.0], [np.nan], [0.0]]))
    assert np.isfinite(many.step(np.array([[np.inf], [-np.inf], [1e30]]))[0]).all()


def example(name: str) -> Any:
    """A file of launch-scripts/examples as a module."""
    spec = importlib.util.spec_from_file_location(name, ROOT / "launch-scripts" / "examples" / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_the_policy_of_the_examples_dives_and_is_what_its_file_says(tmp_path: Path) -> None:
    """The law of launch-scripts/examples/policy_controller.py, without ROS."""
    module, file = example("policy"), ROOT / "launch-scripts" / "examples" / "lauv_depth_policy.json"
    policy, written = module.Policy(file), json.loads(file.read_text())
    env = AuvEnv("depth", "lauv", duration=60.0)
    assert policy.actions == env.moved and policy.observations == [it.name for it in env.quantities]
    for seed in range(5):
        seen, _ = env.reset(seed=seed)
        for _ in range(600):
            [planes] = policy(dict(zip(policy.observations, seen.tolist()))).values()
            numbers = seen / written["scale"]
            for layer in written["layers"]:
                numbers = np.tanh(numbers @ layer["weights"] + layer["biases"])
            assert planes == pytest.approx(0.3 * numbers[0], abs=1e-12)
            seen, *_ = env.step(np.array([planes / 0.3]))
        assert abs(seen[0]) < 0.15
    for change in ({"scale": [1.0]}, {"layers": written["layers"][:1]}, {"actions": {}}, {"layers": None}):
        broken = tmp_path / "broken.json"
        broken.write_text(json.dumps(written | change))
        with pytest.raises(ValueError, match="is no policy"):
            module.Policy(broken)


def test_the_policy_flies_the_loop_in_this_process() -> None:
    """Vehicle, actuator and messages of the ROS loop; a tick is half a step of the training."""
    policy = example("policy").Policy(ROOT / "launch-scripts" / "examples" / "lauv_depth_policy.json")

    def law(time: float, state: np.ndarray) -> float:
        named = dict(zip(planesman.STATES, state))
        named["depth_error"] = 8.0 - named["depth"]
        return policy(named)["stern_planes"]

    plant = {"vehicle": "lauv", "speed": 1.5, "initial_depth": 4.0}
    loop = planesman.Loop("dive", controller=law, duration=40.0, plant_sim=plant)
    *_, last = loop
    assert last[0] == pytest.approx(8.0, abs=0.1)
