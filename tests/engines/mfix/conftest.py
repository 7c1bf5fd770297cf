"""MFiX's stand-in as an engine, and MFiX itself where a user names it."""

import importlib.util
import os
import sys
from pathlib import Path

import pytest

from harness.engines.mfix.engine import Mfix

STAND_IN = Path(__file__).parent / "stand_in.py"
VARIABLE = "DEM_HARNESS_MFIX"


@pytest.fixture(scope="session")
def stand_in_module():
    """Return the module of the stand-in, which reads keyword files and writes VTP files."""
    spec = importlib.util.spec_from_file_location("mfix_stand_in", STAND_IN)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture
def stand_in(script_file):
    """Return a function that makes an engine of the stand-in in one of its modes."""
    engines = []

    def make(mode=""):
        text = f'exec "{sys.executable}" "{STAND_IN}" "{mode}" "$@"\n'
        path = script_file(text, name=f"mfixsolver-{len(engines)}")
        engines.append(Mfix(program=path, workers=2))
        return engines[-1]

    yield make
    for engine in engines:
        engine.close()


@pytest.fixture
def mfix():
    """Return MFiX itself; skip without the path of a solver."""
    program = os.environ.get(VARIABLE)
    if program is None:
        pytest.skip(f"no MFiX here: {VARIABLE} does not name its solver")
    with Mfix(program=program) as engine:
        yield engine
