"""Runs that share a process: each has its outcome, whatever becomes of the others."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from harness.cases.drop.system import TEMPLATE
from harness.engines.contract import collect, finished, run_in_turn
from harness.engines.lammps.engine import Lammps
from harness.engines.output import Output, results_in
from harness.engines.process import Ended
from harness.engines.provenance import Provenance
from harness.errors import (
    EngineCrashError,
    EngineNaNError,
    EngineOutputError,
    EngineTimeoutError,
)

DONE = "RESULT verdict = finished\n"
WELL = Ended("", 0, 1.0, timed_out=False)


def batch_of(script):
    """Return a runner of items that says how each ends: well, in death or in a hang."""
    started = []

    def run(items):
        started.append(len(items))
        outcomes = []
        for item in items:
            if script[item] == "well":
                outcomes.append(item)
                continue
            error = EngineTimeoutError if script[item] == "hang" else EngineCrashError
            return [*outcomes, error(f"at {item}")]
        return outcomes

    return run, started


@given(st.lists(st.sampled_from(["well", "death"]), min_size=1, max_size=20))
def test_a_batch_that_ends_early_costs_only_the_item_it_was_at(script):
    run, started = batch_of(script)
    for item, outcome in enumerate(run_in_turn(range(len(script)), run)):
        assert (outcome == item) == (script[item] == "well")
        if script[item] == "death":
            assert str(outcome) == f"at {item}"
    assert len(started) <= 1 + script.count("death")


@given(st.lists(st.sampled_from(["well", "hang"]), min_size=1, max_size=20))
def test_after_two_hangs_in_a_row_nothing_more_is_tried(script):
    run, started = batch_of(script)
    outcomes = run_in_turn(range(len(script)), run)
    assert len(outcomes) == len(script)
    for item, outcome in enumerate(outcomes):
        if outcome != item:
            assert isinstance(outcome, EngineTimeoutError)
            given_up = "not run after two that hung" in str(outcome)
            assert given_up or script[item] == "hang"
    if script[:2] == ["hang", "hang"]:
        assert len(started) == 2
    assert len(started) <= 2 + script.count("well")


def gathered(logs, ended, read=None):
    def error_of(log):
        if log.startswith("ERROR"):
            return EngineNaNError(log)
        return ended.error("it")

    def output(index):
        return Output(results_in(logs[index]), Provenance("it", "1"), log=logs[index])

    return collect(logs, read or output, error_of, ended, "it")


def test_what_finished_before_a_death_counts():
    outcomes = gathered([DONE, DONE, "begun", ""], Ended("words", -11, 1.0, timed_out=False))
    assert len(outcomes) == 3
    assert [type(outcome) for outcome in outcomes] == [Output, Output, EngineCrashError]
    assert outcomes[2].log == "begun\nwords"


@pytest.mark.parametrize("code", [1, 139, -9])
def test_a_process_that_fails_after_its_last_result_takes_all_of_them_with_it(code):
    outcomes = gathered([DONE, DONE], Ended("", code, 1.0, timed_out=False))
    assert [type(outcome) for outcome in outcomes] == [EngineCrashError] * 2
    assert all("after its results were written" in str(outcome) for outcome in outcomes)
    assert outcomes[0].log == DONE


def test_a_good_end_without_a_result_is_bad_output():
    (outcome,) = gathered(["begun"], WELL)
    assert type(outcome) is EngineOutputError
    (outcome,) = gathered(["ERROR: nan"], WELL)
    assert type(outcome) is EngineNaNError


def test_an_output_that_cannot_be_read_costs_only_itself():
    def read(index):
        if index == 1:
            raise EngineNaNError("nan")
        return index

    first, second, third = gathered([DONE] * 3, WELL, read)
    assert (first, third) == (0, 2)
    assert second.log == DONE


def test_an_echo_of_the_last_line_is_no_end():
    assert finished("x\n" + DONE)
    assert not finished(Lammps.script(TEMPLATE).text)
