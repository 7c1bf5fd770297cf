"""The standing test of the judges: a fault that is planted in an engine's outputs must show.

Each must fail the row that is there for it (``mutations.shown_by``) in the case's own verification
at level quick; the regression against the baseline, which comes later, is not among them.
"""

import re
from dataclasses import replace

import pytest

from harness.cases.drop.case import CASE as DROP
from harness.cases.incline import verification as incline_checks
from harness.cases.incline.case import CASE as INCLINE
from harness.cases.tower.case import CASE as TOWER
from harness.cases.verification import Study
from harness.comparison.verdicts import Kind, Triage, Verdict, missing_from
from harness.workflows.verification import MainRun
from tests.cases import mutations
from tests.cases.mutations import Mutant
from tests.cases.tower.row_engine import RowEngine
from tests.engine_doubles import Twin, frictionless, least_restitution, most_damping

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
    "ladder": lambda job: job.values["height"] == 3,
    "all drops": lambda _: True,
}


def planted(engine, kept, target, output=None, values=None):
    """Return an engine with a fault in the jobs of a target."""
    there = TARGETS[target]
    return Mutant(
        engine,
        kept,
        values and (lambda job: values(job) if there(job) else job.values),
        output and (lambda job, told: output(job, told) if there(job) else told),
    )


def assert_seen(case, engine, fault):
    checks = case.verification.run(engine, QUICK).checks
    assert engine.acted
    failed = [row for row in checks if row.verdict is Verdict.FAIL]
    shown = [f"{row.name}: {row.note}" for row in failed]
    # a run that contradicts itself, or what was asked for, is told before any of its rows
    pattern = f"{mutations.shown_by(case.name, fault)}|says that it ran with"
    assert any(re.search(pattern, row) for row in shown), (pattern, shown)
    assert not any(row.kind is Kind.REGRESSION for row in failed)
    assert [row.note for row in failed if row.triage is Triage.HARNESS] == []


def all_of(case, mutations_of, *without):
    """Return parameters of a test, by their names; ``without`` are faults that do not act."""
    return [
        pytest.param(case, target, name, mutation, id=f"{target}, {name}")
        for target, mutations in mutations_of.items()
        for name, mutation in mutations.items()
        if (target, name) not in without
    ]


ALIKE = {INCLINE: Twin, TOWER: RowEngine, DROP: Twin}
"""Engines that need no process, which tell what LAMMPS tells."""

OUTPUTS = [
    *all_of(
        INCLINE,
        {
            "passages": mutations.RESULTS,
            "sampled passages": mutations.PATHS | mutations.RESULTS,
            "steady runs": mutations.RESULTS | mutations.CRESTS,
            "motions": mutations.PATHS
            | mutations.PATH_SAMPLES
            | mutations.RESULTS
            | mutations.CRESTS,
            "recursion": mutations.RESULTS | mutations.CRESTS,
        },
        # all are trapped, or all move on
        ("sampled passages", "moves on said to be trapped"),
        ("recursion", "trapped said to move on"),
    ),
    *all_of(TOWER, dict.fromkeys(("all towers", "tower of 2", "ladder"), mutations.TOWERS)),
    *all_of(TOWER, {"all towers": mutations.TOWER_SAMPLES}),
    *all_of(TOWER, {"tower of 2": mutations.CONTACT_CHANGES}),
    *all_of(DROP, {"all drops": mutations.PATHS}),
]

VALUES = [
    *all_of(
        INCLINE,
        {
            "motions": mutations.VALUES,
            "recursion": mutations.VALUES,
            "sampled passages": mutations.DAMPING,
        },
    ),
    *all_of(TOWER, {"tower of 2": mutations.OF_A_TOWER}),
    *all_of(DROP, {"all drops": mutations.OF_A_DROP}),
]


def once_each(outputs):
    """Return each fault of a case in one target, each target in its turn."""
    targets = {}
    for param in outputs:
        case, _, fault, _ = param.values
        targets.setdefault((case, fault), []).append(param)
    return [params[n % len(params)] for n, params in enumerate(targets.values())]


@pytest.mark.parametrize("case", ALIKE, ids=lambda case: case.name)
def test_an_engine_without_a_fault_passes(case):
    found = case.verification.run(Mutant(ALIKE[case](), KEPT), QUICK)
    assert not [row for row in found.checks if row.verdict is Verdict.FAIL]


@pytest.mark.parametrize(("case", "target", "fault", "mutation"), once_each(OUTPUTS))
def test_a_fault_of_an_output_shows(case, target, fault, mutation):
    assert_seen(case, planted(ALIKE[case](), KEPT, target, mutation), fault)


@pytest.mark.parametrize(("case", "target", "fault", "change"), VALUES)
def test_other_values_than_were_asked_for_show(case, target, fault, change):
    assert_seen(case, planted(ALIKE[case](), KEPT, target, values=change), fault)


@pytest.mark.parametrize(
    "rules",
    [
        {},
        {"frictionless": frictionless(tail="clipped")},
        {"frictionless": frictionless(effective_mass="half")},
        {"integrator": ""},
        {"digits": 6},
        {"frictionless": least_restitution(1e-3)},
        {"frictionless": most_damping(0.9)},
    ],
    ids=["plain", "clipped", "half", "no scheme", "6 digits", "e >= 1e-3", "zeta <= 0.9"],
)
@pytest.mark.parametrize("case", ALIKE, ids=lambda case: case.name)
def test_each_row_of_the_plan_is_expected_whatever_an_engine_refuses(case, rules):
    engine = Mutant(ALIKE[case](), KEPT)
    engine.traits = replace(engine.traits, **rules)
    found, planned = (
        case.verification.run(engine, QUICK).checks,
        case.verification.planned("quick", engine),
    )
    assert missing_from(found, planned) == []
    assert len(found) == len(planned)


def test_a_verification_that_lost_rows_fails(monkeypatch):
    monkeypatch.setattr(incline_checks, "two_ways", lambda _: [])
    engine = Mutant(Twin(), KEPT)
    run = MainRun([INCLINE], QUICK, engine, engine.identify())
    run.cases_side_by_side()
    name = "incline: in-process against executable, energy margin"
    lost = [row for row in run.checks if row.triage == Triage.MISSING]
    assert [row.name for row in lost] == ["incline: rows of level quick, mutant", name]
    assert all(row.verdict is Verdict.FAIL and name in f"{row.note} {row.name}" for row in lost)
