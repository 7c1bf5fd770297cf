"""The pages of the contact cases: what stands in matrices, codes by laws, conventions, defects."""

import pytest

from harness.cases.bench import OWN, Bench
from harness.cases.checks import run_checks, selected
from harness.cases.contacts import report
from harness.model.conventions import Rules
from tests.cases.contacts.common import case_named, twin


def slower(_, motion):
    """Return a motion with velocities off by 1e-3: a code that is wrong everywhere."""
    motion.velocity[1:] *= 1.0 - 1e-3
    return motion


def ran(engine, case, level="quick"):
    """Return a bench in which an engine has run the checks of a case."""
    bench = Bench(engine)
    checks = selected(case.name, case.checks_up_to(engine, level), level)
    run_checks(case.name, checks, bench)
    return bench


@pytest.fixture(scope="module")
def benches():
    case = case_named("slip-to-roll")
    right, wrong = twin(declared=Rules(wall_lever="height")), twin(change_motion=slower)
    right.traits = wrong.traits
    return {"right": ran(right, case), "wrong": ran(wrong, case), OWN: Bench(None)}


def test_a_matrix_has_the_laws_that_were_run_and_how_far_each_is_from_the_reference(benches):
    case = case_named("slip-to-roll")
    section = report.case_section(case, {"right": benches["right"]})
    (table,) = section.tables
    quick = [trial.law for trial in case.trials if trial.level == "quick"]
    assert list(table.frame["law"]) == quick
    assert all(float(cell) <= 1e-9 for cell in table.frame["wall"])
    assert not report.case_section(case_named("drag"), {"right": benches["right"]}).tables


def test_codes_by_laws_count_rows_within_and_beyond_the_tolerance(benches):
    case = case_named("slip-to-roll")
    codes = {name: bench for name, bench in benches.items() if name != OWN}
    table = report.codes_by_laws([case], codes).set_index("law")
    total = sum(len(sizes) for _, sizes in report.differences([case], benches["right"]))
    assert table.loc["all laws", "right"].startswith(f"{total} rows, ")
    assert table.loc["all laws", "wrong"].endswith("beyond")


def test_a_convention_stands_with_its_formula_and_what_it_moves(benches):
    table = report.conventions([case_named("slip-to-roll")], {"right": benches["right"]})
    assert list(table["convention"]) == ["wall_lever"]
    assert float(table["moves"][0]) > 1e-4
    assert table["formula"][0]
