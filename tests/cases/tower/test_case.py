"""The tower as a case: one run, its references, its verification and its part of the report."""

import numpy as np
import pytest

from harness.cases.tower.case import CASE
from harness.cases.tower.system import TowerRunParameters
from harness.cases.verification import Study
from harness.comparison.verdicts import Kind, Verdict
from harness.errors import EngineCrashError, EngineError, EngineOutputError, RequestError
from harness.parameters.tower import Tower
from harness.workflows.case_runs import parameters_of
from tests.cases.tower.row_engine import RowEngine

QUICK = Study(level="quick")


@pytest.fixture(scope="module")
def own():
    return CASE.verification.run_solvers(QUICK)


@pytest.fixture(scope="module")
def main():
    return CASE.verification.run(RowEngine(), QUICK)


@pytest.mark.parametrize("preset", CASE.presets.values(), ids=CASE.presets.keys())
def test_every_solver_has_the_declared_quantities_near_their_references(preset):
    declared = {observable.name for observable in CASE.quantities}
    references = CASE.references(preset, RowEngine.traits)
    assert set(references) == declared
    for solver in CASE.solvers:
        found = CASE.solve(preset, solver).values
        assert set(found) == declared
        for name, value in found.items():
            assert value == pytest.approx(references[name].value, rel=1e-5, abs=1e-6), name


@pytest.mark.parametrize("values", [{}, {"height": 1}, {"height": 12, "speed": 0.01}])
def test_a_run_in_an_engine_covers_the_window_and_meets_its_references(values):
    parameters = TowerRunParameters(**values)
    engine = RowEngine()
    found = CASE.measure(parameters, engine).values
    references = CASE.references(parameters, engine.traits)
    assert len(engine.jobs) == 1
    for name, value in found.items():
        assert value == pytest.approx(references[name].value, rel=3e-5, abs=3e-5), name


def test_a_grain_on_one_fixed_particle_is_known_in_closed_form():
    known = CASE.references(TowerRunParameters(height=1), RowEngine.traits)
    kinds = {name: reference.kind for name, reference in known.items()}
    assert kinds.pop("final_velocity_m_per_s") == "integrated"
    assert set(kinds.values()) == {"closed form"}
    exact = CASE.solve(TowerRunParameters(height=1), "exact").values
    for name, value in exact.items():
        assert value == pytest.approx(known[name].value, rel=1e-9, abs=1e-9), name


def test_solvers_and_parameters_that_are_not_there_are_refused():
    with pytest.raises(RequestError, match="no such solver"):
        CASE.solve(TowerRunParameters(), "euler")
    with pytest.raises(RequestError, match="duration = 1"):
        TowerRunParameters(duration=1.0)
    with pytest.raises(RequestError, match="takes law = overlap, not deformable"):
        CASE.measure(TowerRunParameters(law="deformable"), RowEngine())


def faulty(fault):
    """Return an engine with a fault in every tower that it writes."""
    return RowEngine(spoil=lambda table, _: fault(table))


def every(table, column, change):
    return {**table, column: change(table[column])}


@pytest.mark.parametrize(
    "fault",
    [
        lambda t: {name: c[: len(c) // 30] for name, c in t.items()},
        lambda t: {name: c[:: len(c) // 5] for name, c in t.items()},
        lambda t: {name: np.delete(c, range(600, 1200), axis=0) for name, c in t.items()},
        lambda t: {name: np.delete(c, 700, axis=0) for name, c in t.items()},
        lambda t: {name: c[:-1] for name, c in t.items()},
        lambda t: {
            name: np.insert(np.delete(c, 700, 0), 9, c[8] + 0.5, 0) for name, c in t.items()
        },
        lambda t: {name: c for name, c in t.items() if name != "vx_m_per_s"},
        lambda t: {name: c for name, c in t.items() if name != "contact_force_N"},
        lambda t: every(t, "step", lambda c: 2.0 * c),
        lambda t: every(t, "step", lambda c: 0.5 * c),
        lambda t: every(t, "x_m", lambda c: c[:, :-1]),
        lambda t: every(t, "contact_force_N", lambda c: c[:, :-1]),
        lambda t: every(t, "contact_force_N", np.zeros_like),
        lambda t: every(t, "vx_m_per_s", lambda c: np.where(c == c[40, 0], np.nan, c)),
    ],
)
def test_a_series_that_lacks_something_is_a_bad_output(fault):
    with pytest.raises(EngineError) as caught:
        CASE.measure(TowerRunParameters(height=2), faulty(fault))
    assert isinstance(caught.value, EngineOutputError) or "not numbers" in str(caught.value)
    found = CASE.verification.run(faulty(fault), QUICK)
    judged = [check for check in found.checks if check.verdict is not Verdict.NOT_TESTED]
    assert {check.verdict for check in judged} == {Verdict.FAIL}
    assert found.records == []
    assert len(found.errors) == 3


@pytest.mark.parametrize(
    "fault",
    [
        lambda t: every(t, "contact_force_N", lambda c: 2.0 * c),
        lambda t: every(t, "vx_m_per_s", lambda c: 2.0 * c),
        lambda t: every(t, "vx_m_per_s", lambda c: c[:, ::-1]),
        lambda t: every(t, "contact_force_N", lambda c: c[:, ::-1]),
        lambda t: every(t, "contact_force_N", lambda c: np.roll(c, 3, axis=0)),
        lambda t: every(
            t, "contact_force_N", lambda c: c * np.where(np.arange(len(c)) > 1500, 0, 1)[:, None]
        ),
    ],
)
def test_a_quantity_that_is_wrong_fails_a_cross_code_row(fault):
    found = CASE.verification.run(faulty(fault), QUICK)
    failed = [check for check in found.checks if check.verdict is Verdict.FAIL]
    assert any(check.kind is Kind.CROSS_CODE for check in failed)


def test_the_main_engine_is_held_law_by_law(main):
    names = [check.name for check in main.checks]
    assert "tower: row, deformable law" in names
    refused = next(check for check in main.checks if check.name == "tower: row, deformable law")
    assert refused.verdict is Verdict.NOT_TESTED
    assert "law = overlap, not deformable" in refused.note
    assert main.untested == {"row/*-deformable-*": refused.note}
    assert {check.verdict for check in main.checks if check is not refused} == {Verdict.PASS}


def test_a_height_that_dies_keeps_the_others_and_its_error():
    def weak(table, case):
        return EngineCrashError("out of reach") if case.height == 19 else table

    found = CASE.verification.run(RowEngine(spoil=weak), QUICK)
    assert list(found.errors) == ["row/tower-overlap-n19-k1e6-v2"]
    died = [check.name for check in found.checks if check.engine_died]
    assert died == ["tower: row, overlap law, n = 19", "tower: impulse table"]
    assert {record.name for record in found.records} >= {"row/tower-overlap-n2-k1e6-v2"}


def test_own_solvers_need_no_engine(own):
    judged = [check for check in own.checks if check.kind is not Kind.FINDING]
    assert {check.verdict for check in judged} == {Verdict.PASS}


def test_the_last_change_of_contacts_is_the_same_in_other_units():
    """Other units round every operation differently; samples fall on other sides of a change."""
    from harness.cases.tower.run import tower, tower_record

    width = CASE.verification.regression["last_change_s"]
    for law in ("overlap", "deformable"):
        for height in (1, 2, 3, 10):
            case = Tower(height=height, law=law)
            scaled = case.replace(mass=3.0, stiffness=3e6)
            for solver, samples in (("exact", 3001), ("rk4", None)):
                one, other = (
                    tower_record(tower(c, solver=solver, samples=samples, profiles=True))
                    .quantities["last_change_s"]
                    .value
                    for c in (case, scaled)
                )
                assert abs(one - other) < 0.1 * width.width(one)
                shifted = tower_record(tower(case, solver=solver, samples=2500, profiles=True))
                assert shifted.quantities["last_change_s"].value == pytest.approx(one, rel=1e-6)


def test_an_error_within_a_part_is_a_row_and_the_others_go_on(monkeypatch):
    from harness.cases.tower import verification

    def wrong(*_):
        raise IndexError("of a part")

    monkeypatch.setattr(verification, "_laws_apart", wrong)
    monkeypatch.setattr(verification, "_same_law", lambda *_: [])  # seconds of RK4
    found = CASE.verification.run_solvers(QUICK)
    failed = [check for check in found.checks if check.verdict is Verdict.FAIL]
    assert [check.name for check in failed] == ["tower: laws apart"]
    assert not failed[0].engine_died
    assert found.evidence.impulses is not None
    assert CASE.display.sections(None, found, {})


def test_a_height_is_read_from_a_setting():
    assert parameters_of(CASE, {"height": "3"}).height == 3
    for text in ("3.5", "three", "9" * 30):
        with pytest.raises(RequestError, match=r"^--set: height = "):
            parameters_of(CASE, {"height": text})
