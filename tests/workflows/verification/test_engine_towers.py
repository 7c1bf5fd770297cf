"""Towers of an engine: what is judged, and what a wrong one does to it."""

from dataclasses import replace

import numpy as np
import pytest
from harness.comparison.engine_evidence import EngineEvidence
from harness.workflows.verification.other_engines.extent import EXTENTS, FINEST

from harness.cases.tower.engine_checks import tower_checks
from harness.comparison.verdicts import Verdict
from harness.errors import EngineCrashError, RequestError
from tests import engine_doubles as doubles

QUICK = EXTENTS["quick"]


def checks_of(engine, extent=QUICK):
    evidence = EngineEvidence(10.2)
    return tower_checks(engine, extent, evidence), evidence


@pytest.mark.parametrize(("kind", "order"), [(doubles.Twin, 2.0), (doubles.Half, 1.0)])
def test_every_height_is_close_and_the_order_is_that_of_the_scheme(kind, order):
    rows, evidence = checks_of(kind(), EXTENTS["default"])
    assert {check.verdict for check in rows} == {Verdict.PASS}
    assert len(rows) == 2 * 5 + 1
    assert [tower.height for tower in evidence.towers] == [1, 2, 4, 9, 19]
    assert {tower.steps_per_contact for tower in evidence.towers} == {FINEST}
    assert all(abs(tower.peak_error) < 2e-5 for tower in evidence.towers)
    (found,) = evidence.convergence
    assert found.l2_order.value == pytest.approx(order, abs=0.1)
    assert found.solver == kind.name


def test_second_order_leaves_1e_7_and_is_given_no_room_for_first_order():
    rows, evidence = checks_of(doubles.Twin(), EXTENTS["default"])
    assert all(abs(tower.impulse_error) < 1e-7 for tower in evidence.towers)
    impulses = [check for check in rows if "impulse" in check.name]
    assert all(check.tolerance == pytest.approx(2e-5 * check.expected) for check in impulses)


def test_semi_implicit_euler_that_is_read_at_its_half_steps_is_the_leapfrog_of_second_order():
    class Leapfrog(doubles.Twin):
        traits = replace(doubles.Half.traits)

        def towers(self, cases, duration, **options):
            return doubles.Twin().towers(cases, duration, **options)

    rows, _ = checks_of(Leapfrog(), EXTENTS["default"])
    assert {check.verdict for check in rows} == {Verdict.PASS}
    assert rows[-1].expected == 2.0
    impulses = [check for check in rows if "impulse" in check.name]
    assert all(check.tolerance == pytest.approx(2e-5 * check.expected) for check in impulses)


def test_a_scheme_of_another_order_than_declared_fails(monkeypatch):
    declared = replace(doubles.Half.traits, integrator="velocity-verlet")

    class Other(doubles.Half):
        def towers(self, cases, duration, **options):
            with pytest.MonkeyPatch.context() as patch:
                patch.setattr(Other, "traits", doubles.Half.traits)
                return super().towers(cases, duration, **options)

    monkeypatch.setattr(Other, "traits", declared)
    rows, _ = checks_of(Other(), EXTENTS["default"])
    failed = [check.name for check in rows if check.verdict is Verdict.FAIL]
    assert any("order" in name for name in failed)
    assert any("impulse" in name for name in failed)


def test_a_wrong_stiffness_fails_at_every_height():
    class Softer(doubles.Twin):
        def towers(self, cases, duration, **options):
            softer = [case.replace(stiffness=case.stiffness * (1 - 1e-4)) for case in cases]
            return super().towers(softer, duration, **options)

    rows, _ = checks_of(Softer())
    peaks = [check for check in rows if "peak force" in check.name]
    assert {check.verdict for check in peaks} == {Verdict.FAIL}


def test_few_digits_make_the_order_a_finding():
    class Rounded(doubles.Twin):
        traits = replace(doubles.TRAITS, digits=6)

        def towers(self, cases, duration, **options):
            return [
                replace(run, grain_force=np.round(run.grain_force, 3))
                for run in super().towers(cases, duration, **options)
            ]

    rows, _ = checks_of(Rounded())
    assert rows[-1].verdict is Verdict.FINDING
    assert "6 digits" in rows[-1].note
    assert {check.verdict for check in rows[:-1]} == {Verdict.PASS}


def test_one_tower_that_dies_does_not_cost_the_others():
    class Weak(doubles.Twin):
        def towers(self, cases, duration, **options):
            runs = super().towers(cases, duration, **options)
            heights = [case.height for case in cases]
            return [
                EngineCrashError("out of reach") if height == 19 else run
                for height, run in zip(heights, runs, strict=True)
            ]

    rows, evidence = checks_of(Weak())
    died = [check for check in rows if check.engine_died]
    assert [check.name for check in died] == ["twin: tower, n = 19, 10000 steps per contact"]
    assert [tower.height for tower in evidence.towers] == [1, 4]


def test_a_run_that_does_not_show_its_window_is_the_engine_s_failure():
    class Short(doubles.Twin):
        def towers(self, cases, duration, **options):
            return super().towers(cases, duration / 2, **options)

    rows, _ = checks_of(Short())
    assert all(check.engine_died and "too short" in check.note for check in rows[:3])


def test_an_engine_that_cannot_state_the_case_is_not_tested_with_its_reason():
    class Hertzian(doubles.Twin):
        def towers(self, *_, **__):
            raise RequestError("its spring is Hertz's")

    rows, _ = checks_of(Hertzian())
    assert {check.verdict for check in rows} == {Verdict.NOT_TESTED}
    assert {check.note for check in rows} == {"its spring is Hertz's"}


def test_an_engine_without_towers_is_not_tested():
    class Inclines(doubles.Twin):
        states_towers = False

    (only,), _ = checks_of(Inclines())
    assert only.verdict is Verdict.NOT_TESTED
