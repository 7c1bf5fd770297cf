"""ESyS-Particle itself, where it is; a fake of it and of its launcher, and recorded output."""

import sys
from pathlib import Path

import pytest

from harness.engines.esys.engine import Esys
from harness.engines.process import Limits
from harness.errors import EngineMissingError

RECORDED = Path(__file__).parent / "recorded"

LAUNCHER = 'shift 2\nexec "$@"\n'
"""Takes ``-np 2`` off and runs the rest, once."""

FAKE = """#!{python}
import json, os, signal, sys, time
if sys.argv[1] == "version.py":
    print("RESULT version = {version}")
    sys.exit()
with open(sys.argv[2]) as file:
    runs = json.load(file)
{body}
"""


@pytest.fixture(scope="session")
def esys():
    """Return the engine, or skip with the reason."""
    try:
        engine = Esys()
        engine.identify()
    except EngineMissingError as error:
        pytest.skip(str(error))
    with engine:
        yield engine


@pytest.fixture
def recorded():
    """Return a function that reads the text of a recorded file by name."""
    return lambda name: (RECORDED / name).read_text(encoding="utf-8")


@pytest.fixture
def fake(tmp_path, script_file):
    """Return a function that opens the engine with a program that does what ``body`` says."""
    engines = []

    def open_fake(body, version="9.9", seconds=60.0):
        program = tmp_path / "esysparticle"
        program.write_text(FAKE.format(python=sys.executable, version=version, body=body))
        program.chmod(0o755)
        launcher = script_file(LAUNCHER, "mpirun-fake")
        engine = Esys(str(program), launcher, workers=1, limits=Limits(seconds=seconds))
        engines.append(engine)
        return engine

    yield open_fake
    for engine in engines:
        engine.close()
