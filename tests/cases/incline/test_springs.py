"""What the routes of the incline know of a spring, against the force itself."""

import math
from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import quad

from harness.cases.incline.runs import follow, measured
from harness.cases.incline.system import (
    Incline,
    Motion,
    crest_energy,
    crest_place,
    energy,
    margin,
    overlaps,
    scene_of,
    settled_place,
    spring_of,
    start_of,
    values_of,
)
from harness.engines.reference import Reference
from harness.parameters.law import CLIPPED, PLASTIC
from harness.solvers.grain.row import acceleration, row_of

CASE = Incline(angle=12.0, contact=PLASTIC, steps_per_contact=400.0, phase=0.3)
LAWS = ("linear", "Hertz")


def row_in(case, law):
    return row_of(scene_of(values_of(case, "steady"), law))


def force(case, law, overlap):
    """Return the force of the kernel of the reference DEM on a grain over one sphere, at rest."""
    row = row_in(case.replace(angle=0.0), law)
    _, ay = acceleration(0.0, case.diameter - overlap, 0.0, 0.0, row)
    return case.mass * (ay + case.gravity)


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("load", [0.1, 9.81, 500.0])
def test_overlap_and_energy_are_those_of_the_force(law, load):
    spring = spring_of(CASE, law)
    overlap = spring.overlap(load)
    assert force(CASE, law, overlap) == pytest.approx(load, rel=1e-6)
    work, _ = quad(lambda x: force(CASE, law, x), 0.0, overlap, epsrel=1e-9)
    assert spring.energy_under(load) == pytest.approx(work, rel=1e-6)
    assert spring.energy(overlap, 0.0) == pytest.approx(work, rel=1e-6)
    # a change of the load, by differences
    by = 1e-4 * load
    change = spring.overlap(load + by / 2) - spring.overlap(load - by / 2)
    assert spring.change(load, by) == pytest.approx(change, rel=1e-7)


@pytest.mark.parametrize("law", LAWS)
def test_small_motions_under_a_load_have_the_rate_of_the_force(law):
    spring = spring_of(CASE, law)
    overlap = spring.overlap(9.81)
    around = overlap * np.array([1.0 - 1e-3, 1.0 + 1e-3])
    stiffness = np.ptp([force(CASE, law, x) for x in around]) / np.ptp(around)
    omega, zeta = spring.small_motion(9.81)
    assert omega == pytest.approx(math.sqrt(stiffness / CASE.mass), rel=1e-5)
    row = row_in(CASE.replace(angle=0.0), law)
    at_rest = acceleration(0.0, CASE.diameter - overlap, 0.0, 0.0, row)[1]
    sinking = acceleration(0.0, CASE.diameter - overlap, 0.0, -1e-3, row)[1]
    rate = (sinking - at_rest) / 1e-3
    assert zeta == pytest.approx(rate / (2.0 * omega), rel=1e-6)


def test_a_grain_at_rest_on_a_crest_has_no_margin_on_a_hertz_spring():
    x, tilt = crest_place(CASE, 3, "Hertz"), math.radians(CASE.angle)
    y = (3.0 * CASE.diameter - x) / math.tan(tilt)
    left = margin(CASE, 3, x, y, 0.0, 0.0, "Hertz")
    assert left == pytest.approx(0.0, abs=1e-12 * CASE.weight_energy)
    ax, ay = acceleration(x, y, 0.0, 0.0, row_in(CASE, "Hertz"))
    assert math.hypot(ax, ay) == pytest.approx(0.0, abs=1e-5 * CASE.gravity)


@pytest.mark.parametrize("law", LAWS)
def test_the_passage_starts_with_the_energy_of_the_crest_and_in_balance(law):
    start = start_of(CASE, "passage", law)
    assert energy(CASE, *start.state(), law) == pytest.approx(crest_energy(CASE, law), rel=1e-12)
    (pressed,) = (o for o in overlaps(CASE, start.x_m, start.y_m) if o > 0.0)
    # along the radius the grain is on its circle: force = weight less v^2/d, to an overlap over d
    x, y, vx, vy = start.state()
    r = math.hypot(x, y)
    pull = CASE.mass * CASE.gravity * math.cos(math.atan2(x, y) + math.radians(CASE.angle))
    centrifugal = CASE.mass * (vx * vx + vy * vy) / r
    assert force(CASE, law, pressed) == pytest.approx(pull - centrifugal, rel=1e-3)


@pytest.mark.parametrize("contact", [PLASTIC, CLIPPED], ids=lambda c: c.name)
def test_the_margin_of_a_settled_contact_is_that_on_the_crest(contact):
    """On a Hertz spring too: the passage judges before the crest, the steady route on it."""
    case = CASE.replace(contact=contact)
    engine = Reference("rk4", spring="Hertz")
    (passage,) = measured(engine, [case], "passage")
    path = follow(engine, case, start_of(case, "passage", "Hertz"), 2.0, every=10)
    margins = margin(case, 1, path.x_m, path.y_m, path.vx_m_per_s, path.vy_m_per_s, "Hertz")
    crest = np.flatnonzero(path.x_m > crest_place(case, 1, "Hertz"))[0]
    hops = contact is CLIPPED  # e = 0.24: it is judged on the crest itself
    before = crest_place(case, 1, "Hertz") - settled_place(case, "Hertz")
    assert (before == 0.0) if hops else (before > 0.1 * case.diameter)
    assert passage.motion is Motion.MOVES_ON
    assert margins[crest] == pytest.approx(passage.margin_J, abs=2e-6 * case.weight_energy)


def test_energy_is_kept_without_damping_and_never_grows_with_it():
    undamped = CASE.replace(contact=PLASTIC.replace(damping_ratio=0.0))
    for case, most in ((undamped, 1e-6), (CASE, 1.0)):
        engine = Reference("rk4", spring="Hertz")
        path = follow(engine, case, start_of(case, "passage", "Hertz"), 1.0, every=50)
        state = (path.x_m, path.y_m, path.vx_m_per_s, path.vy_m_per_s)
        change = np.diff(energy(case, *state, "Hertz")) / case.weight_energy
        assert all(after <= 1e-7 for after in change)
        assert all(abs(a) < most for a in change)
    assert not any(b < a for a, b in pairwise(path.time_s))
