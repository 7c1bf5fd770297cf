"""What does not hold, grouped by its cause: each cause once, with rows, cells and commands."""

from dataclasses import replace

import pytest

from harness.comparison.known_defects import KnownDefect
from harness.comparison.verdicts import (
    Cell,
    Kind,
    Tolerance,
    Verdict,
    failed_run,
    judge,
    not_tested,
)
from harness.errors import EngineTimeoutError
from harness.report.matrix import causes
from harness.report.page import report_page

WIDTH = Tolerance("N", 1e-6, 0.0, "a millionth, for a test")
SCRIPT = """# A spring of half its stiffness.
#
#     toy -in in.toy
#     toy -in in.toy -var k 2      of twice the stiffness
#
# Expected: 1. Found: 0.5.
variable k index 1
#     toy -in another.toy
"""
DEFECT = KnownDefect(
    name="weak", engine="toy", cases=("slide",), submodels=("*",), since="1 Jan 2029",
    cause="the spring has half of its stiffness", undetermined="of no size", upstream="issue 1",
    script="reports/defects/weak/in.toy",
)  # fmt: skip


def row(case, submodel, value=0.6, verdict=None, **cell):
    check = judge(f"{case}, wall: {submodel}: force_N", Kind.ANALYTIC, value, 0.5, WIDTH)
    check = replace(check, cell=Cell(case, submodel, "wall", "toy", **cell))
    return replace(check, verdict=verdict) if verdict else check


def known(submodel):
    return row("slide", submodel, verdict=Verdict.KNOWN_DEFECT, defect="weak")


def unstated(submodel, note):
    check = not_tested(f"slide, wall: {submodel}", Kind.ANALYTIC, note)
    return replace(check, cell=Cell("slide", submodel, "wall", "toy"))


@pytest.fixture
def found(verification):
    rows = (
        row("roll", "old"), row("roll", "old"), row("roll", "new"), row("roll", "new", 0.5),
        known("a"), known("b"), known("a"),
        unstated("c", "it has no c"), unstated("d", "it has no d"),
    )  # fmt: skip
    return replace(verification, checks=rows, defects=((DEFECT, SCRIPT),))


def test_each_cause_stands_once_with_all_its_rows(found):
    told = [(c.verdict, c.title, len(c.rows)) for c in causes(found)]
    assert told == [
        (Verdict.FAIL, "out of tolerance: roll, old", 2),
        (Verdict.FAIL, "out of tolerance: roll, new", 1),
        (Verdict.KNOWN_DEFECT, "weak", 3),
        (Verdict.NOT_TESTED, "What toy does not state, or left without a value", 2),
    ]
    rows = [check for cause in causes(found) for check in cause.rows]
    assert len(rows) == sum(c.verdict is not Verdict.PASS for c in found.checks)


def test_a_known_defect_has_its_cells_its_script_and_the_lines_that_run_it(found):
    (defect,) = (c for c in causes(found) if c.title == "weak")
    assert defect.cells == (("slide", "a", "toy"), ("slide", "b", "toy"))
    assert defect.count == "3 rows in 2 cells of the matrix"
    assert defect.script == "defects/weak/in.toy"
    assert defect.commands == (
        "cd defects/weak",
        "toy -in in.toy",
        "toy -in in.toy -var k 2   # of twice the stiffness",
    )
    assert "Releases from 1 Jan 2029." in defect.sentences
    page = report_page(found, [])
    assert page.count(DEFECT.cause) == 1
    assert 'href="defects/weak/in.toy"' in page


def test_a_failure_has_its_numbers_and_the_commands_of_its_cell(found):
    first, *_, last = causes(found)
    assert first.commands == ("dem-harness verify --only roll/old/wall --engine toy",)
    assert not last.commands
    assert "0.6 against 0.5 N, 0.1 apart, 1e-06 allowed." in first.sentences


def test_engines_that_died_of_one_reason_are_one_cause(verification):
    died = [failed_run(f"run {n}", Kind.ANALYTIC, EngineTimeoutError("5 s")) for n in range(3)]
    (cause,) = causes(replace(verification, checks=tuple(died)))
    assert len(cause.rows) == 3
    assert cause.count == "3 rows"


def test_nothing_that_holds_is_a_cause(verification):
    holds = tuple(c for c in verification.checks if c.verdict in (Verdict.PASS, Verdict.FINDING))
    found = replace(verification, checks=holds)
    assert causes(found) == []
    assert 'id="causes"' not in report_page(found, [])
