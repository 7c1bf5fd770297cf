"""Engines whose program is a Python file that passes for the code, and what each must stand."""

import sys
import time
from contextlib import ExitStack
from pathlib import Path

import pytest

from harness.cases.incline.runs import run_inclines
from harness.cases.incline.system import InclineRun
from harness.engines.process import Limits
from harness.errors import EngineTimeoutError


@pytest.fixture
def faked(script_file):
    """Return a function that opens an engine of a class with a Python file as its program.

    ``words`` come before those that the engine gives; ``limits`` are those of its runs.
    """
    with ExitStack() as opened:

        def make(kind, words, name="fake-lmp", workers=1, **limits):
            said = " ".join(f'"{word}"' for word in words)
            path = script_file(f'exec "{sys.executable}" {said} "$@"\n', name)
            engine = kind(program=path, workers=workers, limits=Limits(**limits))
            return opened.enter_context(engine)

        yield make


@pytest.fixture
def fails_alone():
    """Return a function that checks that a bad case costs only its own runs, and how it fails.

    It returns the outcomes of the good case, then those of the bad one.
    """

    def check(engine, good, bad, error, said, every=None):
        results = run_inclines(engine, [good, bad, good, good, bad], "passage", every=every)
        failed = [results[1], results[4]]
        for result in failed:
            assert type(result) is error
            assert said in str(result)
            assert "\n" not in str(result)
        passed = [results[0], results[2], results[3]]
        assert all(isinstance(result, InclineRun) for result in passed)
        return passed, failed

    return check


@pytest.fixture
def ends_a_hang(tmp_path):
    """Return a function that checks that a run that hangs ends at its limit, and its processes."""

    def check(engine, bad):
        start = time.monotonic()
        (error,) = run_inclines(engine, [bad], "passage")
        assert isinstance(error, EngineTimeoutError)
        assert time.monotonic() - start < 10.0
        commands = (path.read_bytes() for path in Path("/proc").glob("[0-9]*/cmdline"))
        assert not any(str(tmp_path).encode() in command for command in commands)

    return check
