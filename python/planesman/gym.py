"""Gymnasium environments: vehicles with six degrees of freedom that keep a depth or heading, dock, or keep their position in a current.

`AuvEnv` is a single environment; `AuvVectorEnv` contains any number, stepped together in native code on all cores. Both are registered:

>>> import gymnasium, planesman.gym
>>> env = gymnasium.make("planesman/Depth-v0", vehicle="lauv")
>>> envs = gymnasium.make_vec("planesman/Station-v0", num_envs=4096, vehicle="bluerov2_heavy", randomise={"quadratic_damping": 0.2})

This module needs the extra `gym`: `pip install 'planesman[gym]'`. Tasks, rewards and options are in docs/gym.md of the repository.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from os import PathLike
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from planesman import _native
from planesman._arguments import path_text, text

try:
    import gymnasium
except ModuleNotFoundError as error:
    raise ModuleNotFoundError("planesman.gym needs gymnasium: pip install 'planesman[gym]'", name=error.name) from None
from gymnasium.spaces import Box
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space

Task = Literal["depth", "heading", "docking", "station"]
Span = float | tuple[float, float]
"""A half-width about the centre, or (minimum, maximum)."""

_Numbers = NDArray[np.float32]

# Outcomes of the native half.
_RUNNING, _SUCCEEDED, _FAILED, _TIME_UP = range(4)


class Quantity(NamedTuple):
    """A number of an observation, clipped at `bound`; a sensor has noise and a bias, each with the standard deviation `deviation`."""

    name: str
    unit: str
    bound: float
    deviation: float


def _number(entry: str, value: Any) -> float:
    try:
        number = float(value)
    except (TypeError, ValueError):
        number = np.nan
    if not np.isfinite(number):
        raise _native.PlanesmanError(f"{entry}: {value!r} refused: a finite number is expected")
    return number


def _span(entry: str, value: Any, low: float, about: float = 0.0) -> list[float]:
    """A span as [minimum, maximum]; a single number gives the range from `low` times it to it, about `about`."""
    if not isinstance(value, Sequence) or isinstance(value, str):
        size = _number(entry, value)
        return [about + low * size, about + size]
    if len(value) != 2:
        raise _native.PlanesmanError(f"{entry}: {value!r} refused: (minimum, maximum) is expected")
    return [_number(entry, edge) for edge in value]


def _spans(entry: str, spans: Mapping[str, Any] | None, about: float = 0.0) -> list[tuple[str, list[float]]]:
    return [(text(name), _span(f"{entry}: {name}", span, -1.0, about)) for name, span in (spans or {}).items()]


class _Environments:
    """Common parts of both kinds of environments."""

    def __init__(
        self,
        task: Task,
        count: int,
        vehicle: str | PathLike[str],
        observe: Literal["state", "sensors"],
        actions: Mapping[str, Span] | None,
        held: Mapping[str, float] | None,
        randomise: Mapping[str, Span] | None,
        current: Span | None,
        speed: float | None,
        step: float,
        substeps: int,
        duration: float | None,
    ) -> None:
        if count < 1:
            raise _native.PlanesmanError(f"num_envs: {count} refused: 1 or more are expected")
        if observe not in ("state", "sensors"):
            raise _native.PlanesmanError(f"observe: {observe!r} refused: 'state' or 'sensors' is expected")
        options = {
            "task": task,
            "vehicle": text(path_text(vehicle)),
            "sensors": observe == "sensors",
            "actions": None if actions is None else _spans("actions", actions),
            "held": [(text(name), _number(f"held: {name}", value)) for name, value in (held or {}).items()],
            "randomise": _spans("randomise", randomise, 1.0),
            "current": None if current is None else _span("current", current, 0.0),
            "speed": None if speed is None else _number("speed", speed),
            "step": _number("step", step),
            "substeps": int(substeps),
            "duration": None if duration is None else _number("duration", duration),
        }
        if substeps != int(substeps) or not 0 <= substeps < 2**32:
            raise _native.PlanesmanError(f"substeps: {substeps} refused: a whole number is expected, from 1 on")
        self.native = _native.Environments(json.dumps(options), count, 0)
        self.count = count
        self.factor_names = list(randomise or {})
        self.quantities = [Quantity(*it) for it in self.native.quantities()]
        self.moved = {name: (least, most) for name, (least, most) in self.native.actions()}
        bounds = np.array([it.bound for it in self.quantities], dtype=np.float32)
        self.observation_space = Box(-bounds, bounds, dtype=np.float32)
        self.action_space = Box(-1.0, 1.0, (len(self.moved),), dtype=np.float32)

    def reset(self, seeds: Sequence[int]) -> _Numbers:
        return self.native.reset([seed % 2**64 for seed in seeds]).reshape(self.count, -1)

    def step(self, actions: Any) -> tuple[_Numbers, NDArray[np.float64], NDArray[np.uint8]]:
        given = np.asarray(actions, dtype=np.float32)
        if given.shape != (self.count, len(self.moved)):
            raise _native.PlanesmanError(f"actions: shape {given.shape} refused: ({self.count}, {len(self.moved)}) is expected")
        seen, rewards, outcomes = self.native.step(given.tobytes())
        return seen.reshape(self.count, -1), rewards, outcomes

    def states(self) -> NDArray[np.float64]:
        return self.native.states().reshape(self.count, -1)

    def factors(self) -> dict[str, NDArray[np.float64]]:
        columns = self.native.factors().reshape(self.count, -1).T
        return dict(zip(self.factor_names, columns))


class AuvEnv(gymnasium.Env[_Numbers, _Numbers]):
    """A vehicle with a task.

    `vehicle` is built-in (`lauv`, `remus_100_6dof`, `bluerov2_heavy`) or a file; a file needs `actions`, and a cruising vehicle also `speed`. Actions are from -1 to 1.

    - `observe`: the true state (`"state"`), or `"sensors"` with noise and bias. `quantities` has names, units, bounds and deviations.
    - `actions`: inputs of the vehicle, or, if it has only thrusters, surge, sway, heave, roll, pitch, yaw; each with its value at full action (SI), or at -1 and 1.
    - `held`: constant values of other inputs.
    - `randomise`: names of the vehicle's numbers or groups (`mass`, `linear_damping`, `N_uu_rudder`), each with (minimum, maximum) factor, or the largest deviation from 1; drawn for each episode.
    - `current`: (minimum, maximum) speed, or the maximum, m/s; its direction is drawn. `speed`: initial speed through the water, m/s.
    - `step`: time between actions, s, divided into `substeps` Runge-Kutta steps. `duration`: duration of an episode, s.

    `info["success"]` tells at the end whether the goal was reached. An episode is reproducible bit for bit from the options, the seed and the actions.
    """

    metadata = {"render_modes": []}

    def __init__(
        self,
        task: Task,
        vehicle: str | PathLike[str] = "lauv",
        *,
        observe: Literal["state", "sensors"] = "state",
        actions: Mapping[str, Span] | None = None,
        held: Mapping[str, float] | None = None,
        randomise: Mapping[str, Span] | None = None,
        current: Span | None = None,
        speed: float | None = None,
        step: float = 0.1,
        substeps: int = 2,
        duration: float | None = None,
    ) -> None:
        self._all = _Environments(task, 1, vehicle, observe, actions, held, randomise, current, speed, step, substeps, duration)
        self.quantities = self._all.quantities
        """Name, unit, bound and deviation of each number of an observation."""
        self.moved = self._all.moved
        """The input that each action moves, with its values at -1 and 1."""
        self.observation_space = self._all.observation_space
        self.action_space = self._all.action_space
        self.render_mode = None
        self._is_over = True

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[_Numbers, dict[str, Any]]:
        """Begin an episode; without a seed, the environment's generator draws one."""
        super().reset(seed=seed)
        drawn = int(self.np_random.integers(2**63)) if seed is None else seed
        self._is_over = False
        return self._all.reset([drawn])[0], {}

    def step(self, action: _Numbers) -> tuple[_Numbers, float, bool, bool, dict[str, Any]]:
        """Apply an action for one step; return observation, reward, terminated (goal reached or lost), truncated (time up), and `success`."""
        if self._is_over:
            raise gymnasium.error.ResetNeeded("the episode is over: reset() begins the next")
        seen, rewards, outcomes = self._all.step(np.asarray(action)[np.newaxis])
        outcome = int(outcomes[0])
        self._is_over = outcome != _RUNNING
        info = {"success": outcome == _SUCCEEDED} if self._is_over else {}
        return seen[0], float(rewards[0]), outcome in (_SUCCEEDED, _FAILED), outcome == _TIME_UP, info

    @property
    def state(self) -> NDArray[np.float64]:
        """North, east, down (m), quaternion from the body to that frame, u, v, w (m/s), p, q, r (rad/s)."""
        states: NDArray[np.float64] = self._all.states()[0]
        return states

    @property
    def factors(self) -> dict[str, float]:
        """The factors of this episode's vehicle."""
        return {name: float(column[0]) for name, column in self._all.factors().items()}


class AuvVectorEnv(VectorEnv[_Numbers, _Numbers, NDArray[Any]]):
    """Several `AuvEnv`, each with its own episode and, with `randomise`, its own vehicle. Options are those of `AuvEnv`.

    Environment `k` with the seed `s` equals `AuvEnv` with the seed `s + k`, bit for bit. After the end of an episode the next step begins a new one
    (`AutoresetMode.NEXT_STEP`).
    """

    metadata = {"render_modes": [], "autoreset_mode": AutoresetMode.NEXT_STEP}

    def __init__(
        self,
        task: Task,
        num_envs: int,
        vehicle: str | PathLike[str] = "lauv",
        *,
        observe: Literal["state", "sensors"] = "state",
        actions: Mapping[str, Span] | None = None,
        held: Mapping[str, float] | None = None,
        randomise: Mapping[str, Span] | None = None,
        current: Span | None = None,
        speed: float | None = None,
        step: float = 0.1,
        substeps: int = 2,
        duration: float | None = None,
    ) -> None:
        self._all = _Environments(task, num_envs, vehicle, observe, actions, held, randomise, current, speed, step, substeps, duration)
        self.num_envs = num_envs
        self.quantities = self._all.quantities
        """Name, unit, bound and deviation of each number of an observation."""
        self.moved = self._all.moved
        """The input that each action moves, with its values at -1 and 1."""
        self.single_observation_space = self._all.observation_space
        self.single_action_space = self._all.action_space
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)

    def reset(
        self, *, seed: int | Sequence[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[_Numbers, dict[str, Any]]:
        """Begin an episode in each environment, with these seeds or with consecutive ones from a seed. Observations have the shape (num_envs, numbers)."""
        each: list[int | None] = list(seed) if isinstance(seed, Sequence) else [None] * self.num_envs
        if isinstance(seed, int):
            super().reset(seed=seed)
            each = list(range(seed, seed + self.num_envs))
        return self._all.reset([int(self.np_random.integers(2**63)) if it is None else it for it in each]), {}

    def step(
        self, actions: _Numbers
    ) -> tuple[_Numbers, NDArray[Any], NDArray[Any], NDArray[Any], dict[str, Any]]:
        """Apply actions for one step; return observations, rewards, terminated, truncated, and `success` of those that ended (`_success`)."""
        seen, rewards, outcomes = self._all.step(actions)
        succeeded, truncated = outcomes == _SUCCEEDED, outcomes == _TIME_UP
        terminated = succeeded | (outcomes == _FAILED)
        over = terminated | truncated
        info = {"success": succeeded, "_success": over} if over.any() else {}
        return seen, rewards, terminated, truncated, info

    @property
    def states(self) -> NDArray[np.float64]:
        """One row per environment: north, east, down (m), quaternion from the body to that frame, u, v, w (m/s), p, q, r (rad/s)."""
        return self._all.states()

    @property
    def factors(self) -> dict[str, NDArray[np.float64]]:
        """The factors of each environment's vehicle in this episode."""
        return self._all.factors()


for _task in ("depth", "heading", "docking", "station"):
    gymnasium.register(
        id=f"planesman/{_task.capitalize()}-v0",
        entry_point="planesman.gym:AuvEnv",
        vector_entry_point="planesman.gym:AuvVectorEnv",
        kwargs={"task": _task},
    )
