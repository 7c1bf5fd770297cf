"""The judge of the incline: what an honest engine gets, and faults that must not pass."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from harness.cases.incline import checks as single_runs
from harness.cases.incline import verification
from harness.cases.incline.case import CASE
from harness.cases.incline.checks import RECURSION_CASE, InclineEvidence, Verifying, recursion
from harness.cases.incline.verification import against_the_reference
from harness.cases.verification import Study
from harness.comparison.verdicts import Kind, Verdict
from harness.comparison.verification import Findings
from harness.engines.reference import Reference
from harness.errors import EngineMissingError, EngineOutputError
from harness.theory.incline import critical_angle
from tests.engine_doubles import TRAITS, Clamped, Crashing, Twin


@pytest.fixture(scope="module")
def found():
    return CASE.verification.run(Twin(), Study("quick"))


def verifying(engine, level="quick"):
    evidence = InclineEvidence(engine.title, critical_angle())
    return Verifying(engine, Study(level), Findings("incline", engine.name), evidence)


def failed(rows):
    return {row.name for row in rows if row.verdict is Verdict.FAIL}


def test_an_honest_engine_holds_and_its_rows_bear_its_name(found):
    assert not failed(found.checks)
    names = [check.name for check in found.checks]
    assert "incline: critical angle, Twin extrapolated" in names
    assert not any("LAMMPS" in name for name in names)
    (headline,) = found.headlines
    assert headline.who == "Twin"
    assert headline.value == pytest.approx(headline.expected, abs=3e-4)
    kinds = {check.kind for check in found.checks}
    assert kinds == {Kind.ANALYTIC, Kind.CROSS_CODE, Kind.FINDING}


def test_a_contact_that_the_engine_does_not_have_is_not_tested():
    found = CASE.verification.run(Clamped(), Study("quick"))
    assert not failed(found.checks)
    untested = {c.name: c.note for c in found.checks if c.verdict is Verdict.NOT_TESTED}
    assert "tail = clipped" in untested["incline: steady against passage, source contact"]
    assert "tail = clipped" in untested["incline: source contact, passage at 10.2 deg"]
    assert found.evidence.extrapolated is not None


def test_an_engine_that_dies_leaves_a_failed_row_for_each_part_and_errors_by_record():
    found = CASE.verification.run(Crashing(), Study("quick"))
    died = [check for check in found.checks if check.engine_died]
    assert {check.log for check in died} == {"input\nlast words\n"}
    assert len(failed(found.checks)) >= 8
    assert "crashing/incline-passage-plastic-k1e6-100-steps-8-phases" in found.errors
    assert "crashing/incline-path-source-10.2-deg" in found.errors
    assert found.published["extrapolated"] is None


def test_a_part_that_raises_anything_at_all_is_a_failed_row(monkeypatch):
    def broken(*_, **__):
        raise IndexError("list index out of range")

    monkeypatch.setattr(verification, "recursion", broken)
    monkeypatch.setattr(single_runs, "critical_angle", broken)
    found = CASE.verification.run(Twin(), Study("quick"))
    rows = {check.name: check for check in found.checks if check.verdict is Verdict.FAIL}
    assert set(rows) == {"incline: energy after each shock", "incline: scale invariance"}
    row = rows["incline: energy after each shock"]
    assert row.note == "IndexError: list index out of range"
    assert row.triage == "harness error"
    assert not row.engine_died


def at(values, angle):
    """Return values with another angle in the runs of the recursion alone."""
    changed = values["angle"] == RECURSION_CASE.angle and values["route"] == "steady"
    return {**values, "angle": angle} if changed else values


def test_a_grain_that_is_trapped_on_the_way_does_not_pass_the_recursion():
    rows = recursion(verifying(Twin(lambda values: at(values, 10.0))))
    assert "incline: wells passed at 10.6 deg" in failed(rows)


def test_the_width_of_the_recursion_does_not_come_from_the_engine_that_is_judged():
    honest = recursion(verifying(Twin()))[-1]
    soft = Twin(lambda values: {**values, "stiffness": 0.1 * values["stiffness"]})
    judged = recursion(verifying(soft))[-1]
    assert judged.tolerance == honest.tolerance
    assert judged.verdict is Verdict.FAIL


def test_an_uncertainty_that_is_too_large_does_not_widen_the_tolerance(found):
    rows = {check.name: check for check in found.checks}
    row = rows["incline: the stated uncertainty holds the closed form"]
    assert row.uncertainty > row.tolerance == 3e-4
    route = rows["incline: steady against passage, source contact"]
    assert route.tolerance <= 7e-3


def sampled(change):
    """Return a fault of the path of runs that are sampled in the steady route."""

    def fault(job, output):
        if job.sampled and job.values["route"] == "steady":
            series = change(dict(output.tables["series"]))
            return replace(output, tables={**output.tables, "series": series})
        return output

    return Twin(change_output=fault)


def rows_kept(keep):
    return lambda table: {name: column[keep(column)] for name, column in table.items()}


@pytest.mark.parametrize(
    "keep",
    [
        lambda column: slice(0, len(column) // 30),
        lambda _: slice(0, -1),
        lambda column: np.r_[0:40, 60 : len(column)],
        lambda column: np.r_[0:40, 41 : len(column)],
    ],
    ids=["3 %", "last", "hole", "one"],
)
def test_a_path_that_lacks_samples_is_no_result(keep):
    with pytest.raises(EngineOutputError, match=r"rows of a series|samples missing in between"):
        verification._motions(verifying(sampled(rows_kept(keep))))


def test_a_path_without_a_column_is_no_result():
    def without(table):
        del table["vy_m_per_s"]
        return table

    with pytest.raises(EngineOutputError, match="vy_m_per_s"):
        verification._motions(verifying(sampled(without)))


@pytest.mark.parametrize(
    ("change", "shown"),
    [
        (
            lambda t: {**t, "vx_m_per_s": t["vy_m_per_s"], "vy_m_per_s": t["vx_m_per_s"]},
            "largest velocity apart",
        ),
        (lambda t: {**t, "x_m": t["x_m"] * (1.0 + 1e-5)}, "largest distance"),
        (lambda t: {**t, "time_s": 2.0 * t["time_s"]}, "against the reference DEM"),
        (lambda t: t, None),
    ],
    ids=["velocities", "place", "clock", "honest"],
)
def test_another_path_does_not_pass_beside_the_reference(change, shown):
    told = verifying(sampled(change))
    verification._motions(told)
    names = failed(against_the_reference(told))
    paths = {name.partition(",")[0] for name in names}
    assert (any(shown in name for name in names) and len(paths) == 2) if shown else not names


def test_a_slope_off_by_one_in_ten_thousand_shows_in_the_crests():
    class Off(Twin):
        def run_scenes(self, scenes, *names):
            tilted = [(s.gravity[0] * (1.0 - 1e-4), s.gravity[1]) for s in scenes]
            changed = zip(scenes, tilted, strict=True)
            return super().run_scenes([replace(s, gravity=g) for s, g in changed], *names)

    told = verifying(Off())
    recursion(told)
    assert any("crests at 10.6 deg" in name for name in failed(against_the_reference(told)))


def test_the_reference_dem_is_not_held_against_itself():
    (row,) = against_the_reference(verifying(Reference()))
    assert row.verdict is Verdict.NOT_TESTED
    assert "this is the reference DEM" in row.note


def test_an_engine_with_few_digits_is_judged_by_its_angles_alone():
    class Six(Twin):
        traits = replace(TRAITS, digits=6)

    told = verifying(Six())
    verification._motions(told)
    recursion(told)
    assert not any("path at" in c.name or "crests" in c.name for c in against_the_reference(told))


def test_a_twin_is_held_against_the_engine_and_closed():
    class Executable(Twin):
        closed = False

        def close(self):
            type(self).closed = True

    class Both(Twin):
        def twin(self):
            return Executable(lambda values: {**values, "steps_per_contact": 51.0})

    (row,) = single_runs.two_ways(verifying(Both()))
    assert row.verdict is Verdict.FAIL
    assert Executable.closed

    class Absent(Twin):
        def twin(self):
            raise EngineMissingError("no executable beside the library")

    (row,) = single_runs.two_ways(verifying(Absent()))
    assert row.verdict is Verdict.NOT_TESTED
    assert "no executable" in row.note


@pytest.mark.live
def test_lammps_is_the_committed_baseline_to_the_last_bit_in_its_passages():
    from harness.cases.incline.checks import passages
    from harness.engines.registry import open_engine
    from harness.store.baseline import read_baseline

    name = "lammps/incline-path-plastic-10.2-deg"
    known = read_baseline(Path(__file__).parents[3] / "reports" / "baseline").records[name]
    with open_engine("lammps") as engine:
        told = verifying(engine)
        assert passages(told) == []
    (found,) = [r for r in told.findings.records if r.name == name]
    wanted = known.quantities["margin_over_mgd"].value
    assert found.quantities["margin_over_mgd"].value == wanted
