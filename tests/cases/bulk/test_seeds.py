"""Curves of bulk runs: their columns in a table, a user's points in their figures, findings."""

import math
from dataclasses import replace

import numpy as np
import pytest

from harness.cases import drum, heap, penetration, silo
from harness.cases.bulk.seeds import Curve, Runs, against_points
from harness.cases.contract import Measured
from harness.cases.registry import get_case
from harness.cases.verification import Study
from harness.comparison.verdicts import Verdict
from harness.engines.lammps.engine import Lammps
from harness.engines.output import Output
from harness.observables.provenance import Provenance
from harness.observables.reference import Points

CASES = {module.NAME: module for module in (silo, penetration, drum, heap)}


def profile(name, series):
    """Return the profile of a run that left a series."""
    case = get_case(name)
    return case.profile(case.default, Output((), Provenance("lammps", "1"), {"series": series}))


def test_curves_of_the_silo_and_of_the_sphere_are_columns_of_the_series():
    t = np.linspace(0.0, 1.0, 5)
    assert profile("silo", dict.fromkeys(silo.COLUMNS, t) | {"remaining": 9 * t}) == {
        "time_s": t.tolist(),
        "remaining": (9 * t).tolist(),
    }
    fall = dict.fromkeys(penetration.COLUMNS, t) | {"z_m": 0.1 - t**2, "vz_m_per_s": -2 * t}
    found = profile("penetration", fall)
    assert list(found) == ["time_s", "height_m", "velocity_m_per_s", "deceleration_m_per_s2"]
    assert found["height_m"] == (0.1 - t**2).tolist()
    # its velocity grows downward by 2 m/s in each second
    assert found["deceleration_m_per_s2"] == pytest.approx([-2.0] * 5)


def test_the_drum_has_both_kinds_in_both_quadrants_over_the_turn():
    p = drum.Drum()
    steps = p.settle_steps + p.every * np.arange(5)
    rise = np.linspace(0.0, 1.0, p.grains)[:, None] < np.arange(5) / 4  # more from row to row
    x, z = np.where(rise, -1e-3, 1e-3).T, np.where(rise, 1e-3, -1e-3).T
    found = profile("drum", {"step": steps, "x_m": x, "y_m": 0 * x, "z_m": z})
    assert {len(values) for values in found.values()} == {5}
    assert found["turned_deg"][0] == 0.0
    assert found["turned_deg"][-1] == pytest.approx(
        math.degrees(4 * p.every * p.step_size * p.speed)
    )
    large, small = p.large_grains, p.small_grains
    rising = [rise[:large, row].mean() for row in range(5)]
    assert found["large_rising_ratio"] == pytest.approx(rising)
    assert found["large_falling_ratio"] == pytest.approx([1 - share for share in rising])
    rising = [rise[large:, row].sum() / small for row in range(5)]
    assert found["small_rising_ratio"] == pytest.approx(rising)
    assert found["small_falling_ratio"] == pytest.approx([1 - share for share in rising])


CURVE = Curve("a", "time (ms)", "height (mm)", ("time_s", "height_m"), "", (1e3, 1e3))


def runs(points, *heights, engine="LAMMPS"):
    """Return runs whose heights are constant, over two seconds."""
    t = np.linspace(0.0, 2.0, 9)
    curves = tuple(((t, np.full(9, height)),) for height in heights)
    return Runs(engine, ({},) * len(heights), curves, system="s", points=points)


def test_a_finding_has_how_far_the_mean_is_from_the_points_over_their_range():
    points = {CURVE.columns: Points("a.csv", (0.5, 1.0, 7.0), (4.0, 1.0, 11.0))}
    (row,) = against_points("lammps", runs(points, 1.0, 3.0), [CURVE])
    assert (row.name, row.verdict) == ("s: lammps: height_m against a.csv", Verdict.FINDING)
    # 2 of the mean, 4 and 1 of the points that the runs reach, 10 their range
    assert row.value == pytest.approx(math.sqrt((2.0**2 + 1.0**2) / 2) / 10.0)
    assert "mean of 2 runs less that of 2 of 3 points" in row.note
    assert "time_s = 0 to 2" in row.note
    (moved,) = against_points("lammps", runs(points, 2.0, 4.0), [CURVE])
    assert moved.value == pytest.approx(math.sqrt((1.0**2 + 2.0**2) / 2) / 10.0)
    exact = {CURVE.columns: Points("a.csv", (0.5, 1.0, 7.0), (2.0, 2.0, 11.0))}
    (held,) = against_points("lammps", runs(exact, 1.0, 3.0), [CURVE])
    assert held.value == 0.0


def test_points_of_another_curve_or_that_no_run_reaches_give_no_number():
    other = {("time_s", "speed"): Points("a.csv", (0.5,), (4.0,))}
    assert list(against_points("lammps", runs(other, 1.0), [CURVE])) == []
    late = {CURVE.columns: Points("a.csv", (3.0, 4.0), (4.0, 5.0))}
    (row,) = against_points("lammps", runs(late, 1.0), [CURVE])
    assert (row.verdict, math.isnan(row.value)) == (Verdict.FINDING, True)
    assert "0 of 2 points" in row.note


class Falls:
    """An engine of another or the main one: runs that all leave one curve."""

    workers = 4
    traits = Lammps.traits

    def __init__(self, name, height):
        self.name = self.title = name
        self.height = height

    def refuses(self, job):  # noqa: ARG002
        return ""

    def run(self, jobs):
        return [self.height] * len(jobs)


def test_each_engine_has_a_finding_of_the_system_that_is_named(monkeypatch):
    case = get_case("silo")
    row = {quantity.name: 1e-9 for quantity in case.quantities}
    monkeypatch.setattr(type(case), "measured", lambda *_: Measured(row))
    t = np.array([0.0, 1.0])
    monkeypatch.setattr(type(case), "curves", lambda _, __, height: ((t, np.full(2, height)),))
    points = {"silo": {("time_s", "remaining"): Points("a.csv", (0.2, 0.4), (1.0, 3.0))}}
    study = Study("quick", points=points)
    for role, name, height, expected in (
        ("main", "lammps", 2.0, 0.5),
        ("other", "liggghts", 3.0, math.sqrt(0.5)),
    ):
        findings = case.verification.run(Falls(name, height), replace(study, role=role))
        against = {r.name: r.value for r in findings.checks if "against" in r.name}
        assert against == {f"silo: {name}: remaining against a.csv": pytest.approx(expected)}
        assert findings.evidence[0].points == points["silo"]
    without = case.verification.run(Falls("lammps", 2.0), Study("quick"))
    assert not [r for r in without.checks if "against" in r.name]
