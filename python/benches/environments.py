"""Environment steps a second of planesman.gym, 4096 environments at once, and the error of their integration.

    python python/benches/environments.py

An environment step is 0.1 s: actions in, Runge-Kutta steps, observations, rewards, ends of episodes. Rates are by the clock and, since a busy machine gives a process only a share of its cores, for
two cores of processor time. The error is the largest of any number of a state, relative where it is above 1, after 10 s with new actions each second, beside steps of 1 ms.
"""

from __future__ import annotations

import os
import time

import numpy as np

from planesman.gym import AuvVectorEnv

COUNT, STEPS = 4096, 100

CASES = [
    ("depth", "lauv", {}),
    ("depth", "lauv", {"substeps": 5}),
    ("depth", "remus_100_6dof", {}),
    ("depth", "remus_100_6dof", {"substeps": 5}),
    ("docking", "lauv", {}),
    ("docking", "lauv", {"observe": "sensors"}),
    ("docking", "lauv", {"randomise": {"mass": 0.1}}),
    ("station", "bluerov2_heavy", {}),
    ("station", "bluerov2_heavy", {"substeps": 5}),
    ("station", "bluerov2_heavy", {"observe": "sensors", "randomise": {"mass": 0.1}}),
]


def rates(task: str, vehicle: str, options: dict) -> tuple[float, float]:
    """Million environment steps a second by the clock, and for two seconds of processor time: the best of five."""
    envs = AuvVectorEnv(task, COUNT, vehicle, **options)
    envs.reset(seed=1)
    actions = envs.action_space.sample()
    best = [0.0, 0.0]
    for _ in range(5):
        begun = time.perf_counter(), time.process_time()
        for _ in range(STEPS):
            envs.step(actions)
        clock, processor = time.perf_counter() - begun[0], time.process_time() - begun[1]
        best = [max(best[0], COUNT * STEPS / clock / 1e6), max(best[1], 2.0 * COUNT * STEPS / processor / 1e6)]
    return best[0], best[1]


def error(task: str, vehicle: str, options: dict) -> float:
    """The largest error after 10 s of 20 environments."""
    both = [AuvVectorEnv(task, 20, vehicle, **(options | more)) for more in ({}, {"substeps": 100})]
    for envs in both:
        envs.reset(seed=1)
        envs.action_space.seed(1)
    for step in range(100):
        if step % 10 == 0:
            actions = both[0].action_space.sample()
        for envs in both:
            envs.step(actions)
    found, exact = (envs.states for envs in both)
    return float(np.max(np.abs(found - exact) / np.maximum(np.abs(exact), 1.0)))


if __name__ == "__main__":
    print(f"{COUNT} environments on {os.cpu_count()} cores, load {os.getloadavg()[0]:.1f}")
    for case in CASES:
        task, vehicle, options = case
        clock, processor = rates(*case)
        off = "" if "observe" in options else f"; error {error(*case):.1e}"
        print(f"{task} {vehicle} {options}: {clock:.2f} million a second, {processor:.2f} for two cores of processor time{off}", flush=True)
