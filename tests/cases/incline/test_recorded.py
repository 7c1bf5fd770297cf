"""Recorded MFiX beside the reference DEM: paths, angles, and which are judged at which level."""

import math

import numpy as np
import pytest

from harness.cases.incline.angle import critical_angle_by_steady_motion
from harness.cases.incline.case import CASE
from harness.cases.incline.runs import follow, steady_runs
from harness.cases.incline.system import Motion, start_in_well
from harness.cases.incline.verification import (
    CONTACT,
    PATHS,
    START_SPEED,
    STIFFNESS,
    case_at,
    recorded_angles,
    recorded_path,
)
from harness.cases.verification import Study
from harness.comparison.verdicts import Verdict
from harness.engines.reference import Reference
from harness.errors import RequestError

ROW_SECONDS = 0.0130557  # six digits, every 20 steps at f = 50
HALF_DIGIT = 0.5e-5  # of x between 1 and 10 m, with six digits
WELLS = 20  # about what the recorded 45 s hold

JITTERED = ((1e5, 50), (1e6, 50))
"""Stiffness and factor at which the fate depends on how long one waits."""


@pytest.mark.parametrize(
    ("level", "judged", "coarse"),
    [("quick", 1, 0), pytest.param("full", 6, 3, marks=pytest.mark.slow)],
)
def test_fine_steps_are_judged_and_coarse_ones_are_findings(level, judged, coarse):
    (found,) = CASE.verification.recorded(Study(level, missing=frozenset({"mfix"}))).values()
    verdicts = [check.verdict for check in found.checks]
    assert verdicts.count(Verdict.PASS) == judged
    assert verdicts.count(Verdict.FINDING) == coarse
    assert len(verdicts) == judged + coarse == len(found.evidence)
    assert {angle.evidence for angle in found.evidence} == {"recorded"}
    assert all(angle.integrator == "mfix-euler" for angle in found.evidence)
    assert all(abs(angle.off_reference_deg) <= 0.003 for angle in found.evidence)


def test_nothing_recorded_stands_in_for_an_engine_that_is_here_or_was_not_asked_for():
    assert CASE.verification.recorded(Study(missing=frozenset({"yade"}))) == {}
    assert CASE.verification.recorded(Study()) == {}


def path_of(factor, angle, seconds, integrator="mfix-euler"):
    case, every = case_at(angle, STIFFNESS, factor), 20 * factor // 50
    start = start_in_well(case, START_SPEED)
    return follow(Reference(integrator), case, start, seconds, every=every)


def test_the_step_is_a_factor_th_of_the_damped_contact_time_of_half_the_mass():
    case = case_at(10.2, 1e6, 50)
    assert 20 * case.step == pytest.approx(ROW_SECONDS, abs=0.5e-7)
    half, stiffness = 0.5 * case.mass, case.stiffness
    eta = 2 * CONTACT.zeta * math.sqrt(stiffness * half)
    duration = math.pi / math.sqrt(stiffness / half - (eta / (2 * half)) ** 2)
    assert case.step == pytest.approx(duration / 50, rel=1e-9)


@pytest.mark.parametrize(("factor", "angle"), PATHS)
def test_the_path_is_recorded_to_its_last_digit_for_four_wells(factor, angle):
    """To 6 s, that is over four wells; each slow crest then multiplies what the digits hide."""
    path, own = recorded_path(factor, angle), path_of(factor, angle, 6.0)
    rows = len(own.time_s)
    assert np.abs(own.time_s - path.time_s[:rows]).max() < 5e-5
    # the times, too, have six digits: the row's place is known to its speed times half of one
    assert np.abs(own.x_m - path.x_m[:rows]).max() < 2 * HALF_DIGIT
    assert np.abs(own.y_m - path.y_m[:rows]).max() < 2 * HALF_DIGIT
    assert own.x_m[-1] > 3.5


def test_another_scheme_does_not_give_the_recorded_path():
    recorded, other = recorded_path(50, 10.20), path_of(50, 10.20, 6.0, "velocity-verlet")
    apart = np.abs(other.x_m - recorded.x_m[: len(other.x_m)]).max()
    assert apart > 100 * HALF_DIGIT


def critical_angle(recorded, wells):
    engine = Reference("mfix-euler")
    (stiffness, factor), angle = recorded
    case = case_at(10.2, stiffness, factor).replace(wells=wells, time_limit=100.0 * wells)
    start = start_in_well(case, START_SPEED)
    window = (angle.value - 0.06, angle.value + 0.06)
    return critical_angle_by_steady_motion(
        lambda cases: steady_runs(engine, cases, start), case, tolerance_deg=2e-4, window=window
    )


def cost(recorded):
    (stiffness, factor), _ = recorded
    slow = factor == 5000 and stiffness > 1e5
    return pytest.param(recorded, marks=[pytest.mark.slow] if slow else [])


@pytest.mark.parametrize(
    "recorded",
    [cost((at, angle)) for at, angle in recorded_angles().items() if at not in JITTERED],
    ids=lambda recorded: "k={:g}-f={}".format(*recorded[0]),
)
def test_the_recorded_critical_angle(recorded):
    assert critical_angle(recorded, WELLS).value_deg == pytest.approx(recorded[1].value, abs=3e-3)


@pytest.mark.parametrize(("stiffness", "factor"), JITTERED)
def test_where_the_fate_is_a_matter_of_how_long_one_waits_the_recorded_angle_is_in_between(
    stiffness, factor
):
    """Jitter of the contact's phase, at 4.8 steps a contact.

    Some angles last 20 wells and are trapped later: at k = 1e5 N/m from 10.162 to 10.172 deg,
    at 1e6 from 10.192 to 10.197 deg.
    """
    recorded = recorded_angles()[stiffness, factor]
    angles = recorded.value + np.arange(-0.012, 0.012, 4e-4)
    case = case_at(10.2, stiffness, factor).replace(wells=150, time_limit=15_000.0)
    runs = steady_runs(
        Reference("mfix-euler"),
        [case.replace(angle=float(a)) for a in angles],
        start_in_well(case, START_SPEED),
    )
    lasting = min(a for a, r in zip(angles, runs, strict=True) if len(r.crests.time_s) >= WELLS)
    trapped = max(a for a, r in zip(angles, runs, strict=True) if r.motion is Motion.TRAPPED)
    assert angles[0] < lasting < recorded.value < trapped < angles[-1]


def test_what_was_not_recorded_is_refused():
    with pytest.raises(RequestError, match=r"f = 50 at 10.22 deg was not recorded"):
        recorded_path(50, 10.22)
    assert len(recorded_angles()) == 9
