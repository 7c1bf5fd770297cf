"""The recorded MFiX runs, against the reference DEM in MFiX's scheme."""

import math

import numpy as np
import pytest

from harness.cases.incline.given_start import follow as follow_from
from harness.cases.incline.given_start import steady_runs
from harness.cases.incline.recorded import (
    CONTACT,
    PATHS,
    START_SPEED,
    case_at,
    recorded_angles,
    recorded_path,
)
from harness.cases.incline.result import Motion
from harness.cases.incline.routes import start_in_well
from harness.cases.incline.steady import critical_angle_by_steady_motion
from harness.cases.tower.recorded import recorded_tower, recorded_towers
from harness.engines.mfix.step import steps_per_contact
from harness.engines.reference.engine import Reference
from harness.errors import RequestError
from harness.parameters.contact import SOURCE

ROW_SECONDS = 0.0130557  # six digits, every 20 steps at f = 50
HALF_DIGIT = 0.5e-5  # of x between 1 and 10 m, with six digits
WELLS = 20  # about what the recorded 45 s hold


JITTERED = ((1e5, 50), (1e6, 50))
"""Stiffness and factor at which the fate depends on how long one waits."""


def follow(recorded, seconds):
    every = 20 * recorded.factor // 50
    start = start_in_well(recorded.case, START_SPEED)
    return follow_from(Reference("mfix-euler"), recorded.case, start, seconds, every=every)


def test_the_step_is_a_factor_th_of_the_damped_contact_time_of_half_the_mass():
    case = case_at(10.2, 1e6, 50)
    assert 20 * case.step == pytest.approx(ROW_SECONDS, abs=0.5e-7)
    half, stiffness = 0.5 * case.mass, case.stiffness
    eta = 2 * CONTACT.zeta * math.sqrt(stiffness * half)
    duration = math.pi / math.sqrt(stiffness / half - (eta / (2 * half)) ** 2)
    assert case.step == pytest.approx(duration / 50, rel=1e-9)
    undamped = CONTACT.replace(restitution=1.0)
    assert steps_per_contact(50, undamped) == pytest.approx(50 * math.sqrt(2))


@pytest.mark.parametrize(
    ("factor", "contact"),
    [(0.0, CONTACT), (math.nan, CONTACT), (50, SOURCE), (50, CONTACT.replace(restitution=0.0))],
)
def test_a_step_that_mfix_does_not_have_is_refused(factor, contact):
    with pytest.raises(RequestError):
        steps_per_contact(factor, contact)


@pytest.mark.parametrize(("factor", "angle"), PATHS)
def test_the_path_is_recorded_to_its_last_digit_for_four_wells(factor, angle):
    """To 6 s, that is over four wells; each slow crest then multiplies what the digits hide."""
    recorded = recorded_path(factor, angle)
    path, own = recorded.trajectory, follow(recorded, 6.0)
    rows = len(own.time_s)
    assert np.abs(own.time_s - path.time_s[:rows]).max() < 5e-5
    # the times, too, have six digits: the row's place is known to its speed times half of one
    assert np.abs(own.x_m - path.x_m[:rows]).max() < 2 * HALF_DIGIT
    assert np.abs(own.y_m - path.y_m[:rows]).max() < 2 * HALF_DIGIT
    assert own.x_m[-1] > 3.5


def test_another_scheme_does_not_give_the_recorded_path():
    recorded = recorded_path(50, 10.20)
    start = start_in_well(recorded.case, START_SPEED)
    other = follow_from(Reference("velocity-verlet"), recorded.case, start, 6.0, every=20)
    apart = np.abs(other.x_m - recorded.trajectory.x_m[: len(other.x_m)]).max()
    assert apart > 100 * HALF_DIGIT


def critical_angle(recorded, wells):
    engine = Reference("mfix-euler")
    case = case_at(10.2, recorded.stiffness, recorded.factor).replace(
        wells=wells, time_limit=100.0 * wells
    )

    def measure(cases):
        return steady_runs(engine, cases, start_in_well(case, START_SPEED))

    window = (recorded.value_deg - 0.06, recorded.value_deg + 0.06)
    return critical_angle_by_steady_motion(measure, case, tolerance_deg=2e-4, window=window)


def cost(recorded):
    slow = recorded.factor == 5000 and recorded.stiffness > 1e5
    return pytest.param(recorded, marks=[pytest.mark.slow] if slow else [])


@pytest.mark.parametrize(
    "recorded",
    [cost(r) for r in recorded_angles() if (r.stiffness, r.factor) not in JITTERED],
    ids=lambda r: f"k={r.stiffness:g}-f={r.factor}",
)
def test_the_recorded_critical_angle(recorded):
    assert critical_angle(recorded, WELLS).value_deg == pytest.approx(recorded.value_deg, abs=3e-3)


@pytest.mark.parametrize(("stiffness", "factor"), JITTERED)
def test_where_the_fate_is_a_matter_of_how_long_one_waits_the_recorded_angle_is_in_between(
    stiffness, factor
):
    """Jitter of the contact's phase, at 4.8 steps a contact.

    Some angles last 20 wells and are trapped later: at k = 1e5 N/m from 10.162 to 10.172 deg,
    at 1e6 from 10.192 to 10.197 deg.
    """
    (recorded,) = [r for r in recorded_angles() if (r.stiffness, r.factor) == (stiffness, factor)]
    angles = recorded.value_deg + np.arange(-0.012, 0.012, 4e-4)
    case = case_at(10.2, stiffness, factor).replace(wells=150, time_limit=15_000.0)
    runs = steady_runs(
        Reference("mfix-euler"),
        [case.replace(angle=float(a)) for a in angles],
        start_in_well(case, START_SPEED),
    )
    lasting = min(a for a, r in zip(angles, runs, strict=True) if len(r.crests.time_s) >= WELLS)
    trapped = max(a for a, r in zip(angles, runs, strict=True) if r.motion is Motion.TRAPPED)
    assert angles[0] < lasting < recorded.value_deg < trapped < angles[-1]


def test_what_was_not_recorded_is_refused():
    with pytest.raises(RequestError, match=r"f = 50 at 10.22 deg was not recorded"):
        recorded_path(50, 10.22)
    with pytest.raises(RequestError, match=r"must be 50 or 5000"):
        recorded_tower(500)
    assert len(recorded_angles()) == 9


def test_angles_and_towers_come_with_their_cases():
    for angle in recorded_angles():
        assert angle.case.angle == angle.value_deg
        assert angle.case.contact == CONTACT
        assert angle.case.stiffness == angle.stiffness
        assert angle.uncertainty_deg == 0.002
    towers = recorded_towers()
    assert [(t.factor, t.case.particles) for t in towers] == [
        (f, n) for f in (50, 5000) for n in (2, 3, 5, 10)
    ]
    for tower in towers:
        between = 1 if tower.factor == 50 else 100
        assert np.diff(tower.time) == pytest.approx(between * tower.step, abs=1e-8)
        column = f"F_top_N{tower.case.particles}"
        assert np.array_equal(tower.force, recorded_tower(tower.factor)[column])
