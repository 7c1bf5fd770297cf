"""LIGGGHTS itself, and what it once wrote."""

import shutil
from pathlib import Path

import pytest

from harness.engines.liggghts.engine import Liggghts

RECORDED = Path(__file__).parent / "recorded"


@pytest.fixture
def recorded():
    """Return a function that reads a recorded output by name."""
    return lambda name: (RECORDED / name).read_text(encoding="utf-8")


@pytest.fixture(scope="session")
def program():
    """Return the executable; skip, with the reason, where there is none."""
    path = shutil.which("liggghts")
    if path is None:
        pytest.skip("no liggghts on PATH")
    return path


@pytest.fixture(scope="module")
def liggghts(program):
    with Liggghts(program, workers=2) as engine:
        yield engine
