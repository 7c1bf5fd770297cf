"""Items that share a process: each has its outcome, whatever becomes of the others."""

import json
import sys
import threading

import pytest

from harness.engines.process import Batches, Limits, in_batches, parallel_map
from harness.errors import EngineCrashError, EngineNaNError, EngineOutputError, EngineTimeoutError

CODE = """
import json, os, shutil, sys, time
ways = json.load(open("ways.json"))
for place, way in enumerate(ways):
    if way == "hang": time.sleep(60)
    if way == "death": os.abort()
    if way == "stop": sys.exit(0)
    if way == "lost folder": sys.exit(shutil.rmtree(os.getcwd()) or 5)
    open(str(place), "w").write(way)
if ways[-1] == "late": os.abort()
"""


def write(folder, ways):
    (folder / "ways.json").write_text(json.dumps(ways))
    return [sys.executable, "-c", CODE]


def read(folder, place, way, seconds):
    assert seconds > 0.0
    if way == "nan":
        raise EngineNaNError("nan")
    path = folder / str(place)
    return path.read_text() if path.exists() else None


OPTIONS = {
    "title": "Echo",
    "write": write,
    "read": read,
    "error": lambda ended, log: EngineNaNError(log) if "nan" in log else ended.error("Echo"),
    "log": lambda folder, place: "begun\n",  # noqa: ARG005
}
ECHO = Batches(**OPTIONS)
CASES = {
    "a crash costs one item": (
        ["well", "death", "well", "death"],
        [str, EngineCrashError, str, EngineCrashError],
    ),
    "so does a good end without a result": (
        ["well", "stop", "well"],
        [str, EngineOutputError, str],
    ),
    "so does a process that removes its folder": (
        ["lost folder", "well"],
        [EngineCrashError, str],
    ),
    "and an output that cannot be read": (["well", "nan", "well"], [str, EngineNaNError, str]),
    "a process that fails at its end takes the last": (["well", "late"], [str, EngineCrashError]),
    "after two hangs in a row the rest is not run": (
        ["hang", "hang", "well", "well"],
        [EngineTimeoutError] * 4,
    ),
    "nothing": ([], []),
}


@pytest.mark.parametrize("name", CASES)
def test_outcomes_of_items(name):
    ways, kinds = CASES[name]
    outcomes = ECHO.run(ways, 1, Limits(seconds=0.3 if "hang" in ways else 60.0))
    assert [type(outcome) for outcome in outcomes] == kinds
    for way, outcome in zip(ways, outcomes, strict=True):
        assert outcome == way or outcome.log.startswith("begun") or "not run" in str(outcome)
    assert ("not run after two that hung" in str(outcomes[-1:])) == name.startswith("after two")
    assert ("after its results were written" in str(outcomes[-1:])) == ("late" in ways)


@pytest.mark.parametrize("shares", [None, [[4, 2, 0], [1, 3]]])
def test_outcomes_of_several_processes_are_in_the_order_of_items(shares):
    ways = ["a", "death", "b", "c", "death"]
    outcomes = ECHO.run(ways, 2, shares=shares)
    for way, outcome in zip(ways, outcomes, strict=True):
        assert outcome == way or (way == "death" and isinstance(outcome, EngineCrashError))


def test_batches_grow():
    sizes = []

    def run(items):
        sizes.append(len(items))
        return [2 * item for item in items]

    assert list(in_batches(range(20), run, 2)) == [(k, 2 * k) for k in range(20)]
    assert sizes == [2, 4, 8, 6]


def test_results_keep_the_order_of_items_and_an_exception_starts_no_more():
    barrier = threading.Barrier(2, timeout=10.0)  # two run side by side
    assert parallel_map(lambda item: (barrier.wait(), item)[1], range(4), 2) == [0, 1, 2, 3]
    done = []

    def fail(item):
        done.append(item)
        raise ValueError

    with pytest.raises(ValueError):  # noqa: PT011
        parallel_map(fail, range(100), 1)
    assert done == [0]
