"""What several tests need: a flight, and its bag."""

from __future__ import annotations

import os
from pathlib import Path

import matplotlib
import pytest

import planesman

matplotlib.use("agg")

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(scope="session")
def bag(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The built-in dive as a bag."""
    path = tmp_path_factory.mktemp("bag") / "dive.mcap"
    planesman.simulate("dive", bag=path)
    return path


@pytest.fixture(scope="session")
def flight() -> planesman.Flight:
    """The built-in dive."""
    return planesman.simulate("dive")


def built(variable: str, name: str, command: str) -> str:
    """A program that cargo has built, or the one that an environment variable names."""
    path = os.environ.get(variable, str(ROOT / "target" / "release" / name))
    if not os.access(path, os.X_OK):
        if os.environ.get("PLANESMAN_PEERS") == "required":
            pytest.fail(f"there is no program {path}: {command}")
        pytest.skip(f"there is no program {path}: {command}")
    return path


@pytest.fixture(scope="session")
def program() -> str:
    """The program `planesman`, for tests that hold the package to what it prints."""
    return built("PLANESMAN", "planesman", "cargo build --release")


@pytest.fixture(scope="session")
def reports() -> str:
    """The program `planesman-reports`."""
    return built("PLANESMAN_REPORTS", "planesman-reports", "cargo build --release --package planesman-reports")
