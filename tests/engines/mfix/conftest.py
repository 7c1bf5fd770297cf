"""MFiX's stand-in as an engine, and MFiX itself where a user names it."""

import importlib.util
import math
import os
import sys
from pathlib import Path

import pytest

from harness.cases.incline.runs import scene_from
from harness.engines.mfix.engine import Mfix
from harness.engines.mfix.system import system_of
from harness.engines.process import Limits

HERE = Path(__file__).parent
STAND_IN = HERE / "stand_in.py"
VARIABLE = "DEM_HARNESS_MFIX"


def _module(name):
    spec = importlib.util.spec_from_file_location(f"mfix_{name}", HERE / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="session")
def read_keywords():
    """Return the reader of MFiX's keyword files."""
    return _module("keyword_file").read_keywords


@pytest.fixture(scope="session")
def write_vtp():
    """Return the function that makes a VTP file in MFiX's form, as bytes."""
    return _module("stand_in").vtp


@pytest.fixture(scope="session")
def incline_of():
    """Return a function that makes the scene of an incline and its system in MFiX's box."""

    def make(case, start, wells, duration, every):
        scene = scene_from(case.replace(wells=wells), start)
        steps = math.ceil(duration / case.step * (1.0 - 1e-12))
        return scene, system_of("incline", scene, steps, every)

    return make


@pytest.fixture
def stand_in(script_file):
    """Return a function that makes an engine of the stand-in in one of its modes."""
    engines = []

    def make(mode="", **limits):
        text = f'exec "{sys.executable}" "{STAND_IN}" "{mode}" "$@"\n'
        path = script_file(text, name=f"mfixsolver-{len(engines)}")
        engines.append(Mfix(program=path, workers=2, limits=Limits(**limits)))
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
