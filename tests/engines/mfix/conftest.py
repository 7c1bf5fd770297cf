"""MFiX's stand-in as an engine, and MFiX itself where a user names it."""

import os
import sys
from contextlib import ExitStack
from pathlib import Path

import pytest

from harness.engines.mfix.engine import Mfix

STAND_IN = Path(__file__).parent / "stand_in.py"
VARIABLE = "DEM_HARNESS_MFIX"


@pytest.fixture
def stand_in(script_file):
    """Return a function that makes an engine of the stand-in in one of its modes."""
    with ExitStack() as opened:

        def make(mode=""):
            text = f'exec "{sys.executable}" "{STAND_IN}" "{mode}" "$@"\n'
            program = script_file(text, name=f"mfixsolver-{mode.replace(' ', '-')}")
            return opened.enter_context(Mfix(program=program, workers=2))

        yield make


@pytest.fixture
def mfix():
    """Return MFiX itself; skip without the path of a solver."""
    program = os.environ.get(VARIABLE)
    if program is None:
        pytest.skip(f"no MFiX here: {VARIABLE} does not name its solver")
    with Mfix(program=program) as engine:
        yield engine
