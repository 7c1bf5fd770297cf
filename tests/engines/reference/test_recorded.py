"""The reference DEM's schemes of MFiX, against runs recorded with MFiX 21.3.2."""

import csv
from pathlib import Path

import numpy as np
import pytest

from harness.cases.drop.case import Drop, run_drops
from harness.cases.incline.angle import critical_angle_by_steady_motion
from harness.cases.incline.runs import follow, steady_runs
from harness.cases.incline.system import Motion, start_in_well
from harness.engines.reference import Reference
from harness.reproduction.mfix import CONTACT, START_SPEED, WELLS, case_at

RECORDED = Path(__file__).parent / "recorded"
SINGLE = 2.0**-23
HALF_DIGIT = 0.5e-5  # of x between 1 and 10 m, with six digits
JITTERED = ((1e5, 50), (1e6, 50))
"""Stiffness and factor at which the fate depends on how long one waits."""


def angles():
    with (RECORDED / "critical_angles_euler.csv").open(encoding="utf-8") as file:
        return {
            (float(row["stiffness_N_per_m"]), int(row["dtsolid_factor"])): float(
                row["critical_angle_deg"]
            )
            for row in csv.DictReader(file)
        }


ANGLES = angles()


def incline_apart(integrator):
    """Return how far the reference DEM is from the recorded path over four wells, x and y [m].

    Each slow crest after them multiplies what the digits hide.
    """
    recorded = np.loadtxt(
        RECORDED / "incline_k1e6_euler_f50_th10.20.csv", delimiter=",", skiprows=1
    )
    case = case_at(10.20, 1e6, 50)
    start = start_in_well(case, START_SPEED)
    path = follow(Reference(integrator), case, start, 6.0, every=20)
    rows = min(len(path.time_s), len(recorded))
    assert np.abs(path.time_s[:rows] - recorded[:rows, 0]).max() < 5e-5
    assert path.x_m[rows - 1] > 3.5
    x = np.abs(path.x_m[:rows] - (recorded[:rows, 1] - 0.5)).max()  # from the first centre
    return x, np.abs(path.y_m[:rows] - recorded[:rows, 2]).max()


def test_the_path_is_recorded_to_its_last_digit_for_four_wells():
    # the times, too, have six digits: the row's place is known to its speed times half of one
    assert max(incline_apart("mfix-euler")) < 2 * HALF_DIGIT
    assert max(incline_apart("velocity-verlet")) > 100 * HALF_DIGIT


@pytest.mark.parametrize(
    ("stiffness", "factor"),
    [
        pytest.param(*at, marks=[pytest.mark.slow] if at in ((1e6, 5000), (1e7, 5000)) else [])
        for at in ANGLES
        if at not in JITTERED
    ],
)
def test_the_recorded_critical_angle(stiffness, factor):
    recorded = ANGLES[stiffness, factor]
    case = case_at(10.2, stiffness, factor).replace(wells=WELLS, time_limit=100.0 * WELLS)
    found = critical_angle_by_steady_motion(
        lambda cases: steady_runs(Reference("mfix-euler"), cases, start_in_well(case, START_SPEED)),
        case,
        tolerance_deg=2e-4,
        window=(recorded - 0.06, recorded + 0.06),
    )
    assert found.value_deg == pytest.approx(recorded, abs=3e-3)


@pytest.mark.parametrize(("stiffness", "factor"), JITTERED)
def test_where_the_fate_is_a_matter_of_how_long_one_waits_the_recorded_angle_is_in_between(
    stiffness, factor
):
    """Jitter of the contact's phase, at 4.8 steps a contact.

    Some angles last 20 wells and are trapped later: at k = 1e5 N/m from 10.162 to 10.172 deg,
    at 1e6 from 10.192 to 10.197 deg.
    """
    recorded = ANGLES[stiffness, factor]
    near = recorded + np.arange(-0.012, 0.012, 4e-4)
    case = case_at(10.2, stiffness, factor).replace(wells=150, time_limit=15_000.0)
    runs = steady_runs(
        Reference("mfix-euler"),
        [case.replace(angle=float(a)) for a in near],
        start_in_well(case, START_SPEED),
    )
    lasting = min(a for a, r in zip(near, runs, strict=True) if len(r.crests.time_s) >= WELLS)
    trapped = max(a for a, r in zip(near, runs, strict=True) if r.motion is Motion.TRAPPED)
    assert near[0] < lasting < recorded < trapped < near[-1]


def test_adams_bashforth_is_the_recorded_drop_and_euler_is_not():
    case = Drop(
        contact=CONTACT.replace(restitution=0.5), speed=1.0, steps_per_contact=100.0, duration=4.0
    )
    recorded = np.loadtxt(RECORDED / "drop_adams_bashforth.csv", delimiter=",", skiprows=1)
    apart = {}
    for scheme in ("mfix-adams-bashforth", "mfix-euler"):
        (run,) = run_drops(Reference(scheme), [case])
        assert run.path.time_s[::4] == pytest.approx(recorded[:, 0], rel=1e-7, abs=1e-12)
        apart[scheme] = (
            np.abs(run.path.y_m[::4] - recorded[:, 1]).max(),
            np.abs(run.path.vy_m_per_s[::4] - recorded[:, 2]).max(),
        )
    place, speed = apart["mfix-adams-bashforth"]
    assert place < 4 * SINGLE
    assert speed < 1e-7
    assert apart["mfix-euler"][1] > 1e-3
