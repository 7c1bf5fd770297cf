"""Towers of an engine beside the main one: what is judged, and what a wrong one does to it."""

from dataclasses import replace

import numpy as np
import pytest

from harness.cases.tower.case import CASE
from harness.cases.tower.verification import FINEST_STEPS
from harness.cases.verification import Study
from harness.comparison.verdicts import Verdict
from harness.errors import EngineCrashError
from tests.cases.tower.row_engine import Half, RowEngine


def checks_of(engine, level="quick"):
    found = CASE.verification.run(engine, Study(level=level, role="other"))
    return found.checks, found.evidence


@pytest.mark.parametrize(("kind", "order"), [(RowEngine, 2.0), (Half, 1.0)])
def test_every_height_is_close_and_the_order_is_that_of_the_scheme(kind, order):
    rows, evidence = checks_of(kind(), "default")
    assert {check.verdict for check in rows} == {Verdict.PASS}
    assert len(rows) == 2 * 5 + 1
    assert [tower.height for tower in evidence.towers] == [1, 2, 4, 9, 19]
    assert {tower.steps_per_contact for tower in evidence.towers} == {FINEST_STEPS}
    assert all(abs(tower.peak_error) < 2e-5 for tower in evidence.towers)
    (found,) = evidence.convergence
    assert found.l2_order.value == pytest.approx(order, abs=0.1)
    assert found.solver == kind.name


def test_the_tolerance_of_the_order_is_not_the_scatter_of_the_run_under_test():
    rows, _ = checks_of(RowEngine())
    assert rows[-1].tolerance == 0.15
    assert rows[-1].uncertainty != rows[-1].tolerance


def test_semi_implicit_euler_that_is_read_at_its_half_steps_is_the_leapfrog_of_second_order():
    class Leapfrog(RowEngine):
        traits = Half.traits

        def run(self, jobs):
            return RowEngine().run(jobs)

    Leapfrog.name = RowEngine.name
    rows, _ = checks_of(Leapfrog(), "default")
    assert {check.verdict for check in rows} == {Verdict.PASS}
    assert rows[-1].expected == 2.0
    impulses = [check for check in rows if "impulse" in check.name]
    assert all(check.tolerance == pytest.approx(2e-5 * check.expected) for check in impulses)


def test_a_scheme_of_another_order_than_declared_fails():
    class Other(Half):
        traits = RowEngine.traits

        def run(self, jobs):
            return Half().run(jobs)

    rows, _ = checks_of(Other(), "default")
    failed = {check.name: check.note for check in rows if check.verdict is Verdict.FAIL}
    assert any("order" in name for name in failed)
    assert all("positions and velocities that contradict" in note for note in failed.values())


def test_a_wrong_stiffness_fails_at_every_height():
    def softer(case):
        return case.replace(stiffness=case.stiffness * (1 - 1e-4))

    rows, _ = checks_of(RowEngine(softer))
    peaks = [check for check in rows if "peak force" in check.name]
    assert {check.verdict for check in peaks} == {Verdict.FAIL}


def test_few_digits_make_the_order_a_finding():
    class Rounded(RowEngine):
        traits = replace(RowEngine.traits, digits=6)

    def rounded(table, _):
        return {**table, "contact_force_N": np.round(table["contact_force_N"], 3)}

    rows, _ = checks_of(Rounded(spoil=rounded))
    assert rows[-1].verdict is Verdict.FINDING
    assert "6 digits" in rows[-1].note
    assert {check.verdict for check in rows[:-1]} == {Verdict.PASS}


def test_one_tower_that_dies_does_not_cost_the_others():
    def weak(table, case):
        return EngineCrashError("out of reach") if case.height == 19 else table

    rows, evidence = checks_of(RowEngine(spoil=weak))
    died = [check for check in rows if check.engine_died]
    assert [check.name for check in died] == ["row: tower, n = 19, 10000 steps per contact"]
    assert [tower.height for tower in evidence.towers] == [1, 4]


def test_a_run_that_does_not_show_its_window_is_the_engine_s_failure():
    def slower(case):
        return case.replace(stiffness=case.stiffness / 16)

    rows, _ = checks_of(RowEngine(slower))
    assert all(check.engine_died and "must be at least" in check.note for check in rows[:3])


def test_an_engine_that_refuses_the_case_is_not_tested_with_its_reason():
    class Hertzian(RowEngine):
        def refuses(self, _):
            return "its spring is Hertz's"

    (only,), _ = checks_of(Hertzian())
    assert (only.name, only.verdict) == ("row: towers", Verdict.NOT_TESTED)
    assert only.note == "its spring is Hertz's"
