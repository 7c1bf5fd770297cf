"""The standing test of the judges: a fault that is planted in an engine's outputs must show.

Each must fail a row of the case's own verification at level quick; the regression against the
baseline, which comes later, is not among them.
"""

import pytest

from harness.cases.contract import Study
from harness.cases.drop.case import CASE as DROP
from harness.cases.incline.case import CASE as INCLINE
from harness.cases.tower.case import CASE as TOWER
from harness.comparison.triage import Triage
from harness.comparison.verdicts import Kind, Verdict
from tests.cases import mutations
from tests.cases.doubles import Twin
from tests.cases.mutations import Mutant
from tests.cases.tower.row_engine import RowEngine

QUICK = Study("quick")
KEPT = {}
"""Outputs by job: each runs once, whatever is planted in it afterwards."""


def passage(job):
    return job.values["route"] == "passage"


def steady(job):
    return not passage(job)


TARGETS = {
    "passages": passage,
    "sampled passages": lambda job: passage(job) and job.sampled,
    "steady runs": steady,
    "motions": lambda job: steady(job) and job.sampled,
    "recursion": lambda job: steady(job) and job.values["angle"] == 10.6,
    "all towers": lambda _: True,
    "tower of 2": lambda job: job.values["height"] == 2,
    "tower of 19": lambda job: job.values["height"] == 19,
    "ladder": lambda job: job.values["height"] == 3,
    "all drops": lambda _: True,
}


def planted(engine, target, output=None, values=None):
    """Return an engine with a fault in the jobs of a target."""
    there = TARGETS[target]
    return Mutant(
        engine,
        KEPT,
        values and (lambda job: values(job) if there(job) else job.values),
        output and (lambda job, told: output(job, told) if there(job) else told),
    )


def assert_seen(case, engine):
    checks = case.verify(engine, QUICK).checks
    assert engine.acted
    failed = [row for row in checks if row.verdict is Verdict.FAIL]
    assert failed
    assert not any(row.kind is Kind.REGRESSION for row in failed)
    assert [row.note for row in failed if row.triage is Triage.HARNESS] == []


@pytest.mark.parametrize(
    ("case", "engine"),
    [(INCLINE, Twin), (TOWER, RowEngine), (DROP, Twin)],
    ids=lambda one: one.name,
)
def test_an_engine_without_a_fault_passes(case, engine):
    found = case.verify(Mutant(engine(), KEPT), QUICK)
    assert not [row for row in found.checks if row.verdict is Verdict.FAIL]
    assert len(found.checks) == case.expected_rows("quick", engine())


def all_of(**mutations_of):
    """Return the parameters of a test: target and mutation, by their names."""
    return [
        pytest.param(target, mutation, id=f"{target}, {name}")
        for target, mutations in mutations_of.items()
        for name, mutation in mutations.items()
    ]


@pytest.mark.parametrize(
    ("target", "mutation"),
    all_of(
        **{
            "sampled passages": mutations.PATHS | mutations.RESULTS,
            "motions": mutations.PATHS | mutations.RESULTS | mutations.CRESTS,
            "passages": mutations.RESULTS,
            "steady runs": mutations.RESULTS
            | mutations.CRESTS
            | {"second sphere displaced by 1e-4 d": mutations.displaced},
            "recursion": mutations.RESULTS
            | mutations.CRESTS
            | {"second sphere displaced by 1e-4 d": mutations.displaced},
        }
    ),
)
def test_a_fault_of_an_incline_shows(target, mutation):
    assert_seen(INCLINE, planted(Twin(), target, mutation))


@pytest.mark.parametrize(
    ("target", "mutation"),
    all_of(
        **dict.fromkeys(("all towers", "tower of 2", "tower of 19", "ladder"), mutations.TOWERS)
    ),
)
def test_a_fault_of_a_tower_shows(target, mutation):
    assert_seen(TOWER, planted(RowEngine(), target, mutation))


@pytest.mark.parametrize(("target", "mutation"), all_of(**{"all drops": mutations.PATHS}))
def test_a_fault_of_a_drop_shows(target, mutation):
    assert_seen(DROP, planted(Twin(), target, mutation))
