"""Energies and places of the incline's routes, against the force of the reference DEM."""

import math

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
    start_of,
    values_of,
)
from harness.engines.reference import Reference
from harness.parameters.law import CLIPPED, PLASTIC
from harness.solvers.grain.row import acceleration, row_of

CASE = Incline(angle=12.0, contact=PLASTIC, steps_per_contact=400.0, phase=0.3)


def row_in(case):
    return row_of(scene_of(values_of(case, "steady")))


def force(case, overlap):
    """Return the force of the kernel of the reference DEM on a grain over one sphere, at rest."""
    _, ay = acceleration(0.0, case.diameter - overlap, 0.0, 0.0, row_in(case.replace(angle=0.0)))
    return case.mass * (ay + case.gravity)


def test_the_energy_of_the_crest_is_height_and_the_work_of_the_force():
    overlap = CASE.static_overlap * CASE.diameter
    weight = CASE.mass * CASE.gravity
    assert force(CASE, overlap) == pytest.approx(weight, rel=1e-6)
    work, _ = quad(lambda x: force(CASE, x), 0.0, overlap, epsrel=1e-9)
    height = weight * (CASE.diameter - overlap)
    assert crest_energy(CASE) - height == pytest.approx(work, rel=1e-6)


def test_a_grain_at_rest_on_a_crest_has_no_margin():
    x, tilt = crest_place(CASE, 3), math.radians(CASE.angle)
    y = (3.0 * CASE.diameter - x) / math.tan(tilt)
    left = margin(CASE, 3, x, y, 0.0, 0.0)
    assert left == pytest.approx(0.0, abs=1e-12 * CASE.weight_energy)
    ax, ay = acceleration(x, y, 0.0, 0.0, row_in(CASE))
    assert math.hypot(ax, ay) == pytest.approx(0.0, abs=1e-5 * CASE.gravity)


def test_the_passage_starts_with_the_energy_of_the_crest_and_in_balance():
    start = start_of(CASE, "passage")
    assert energy(CASE, *start.state()) == pytest.approx(crest_energy(CASE), rel=1e-12)
    (pressed,) = (o for o in overlaps(CASE, start.x_m, start.y_m) if o > 0.0)
    # along the radius the grain is on its circle: force = weight less v^2/d, to an overlap over d
    x, y, vx, vy = start.state()
    r = math.hypot(x, y)
    pull = CASE.mass * CASE.gravity * math.cos(math.atan2(x, y) + math.radians(CASE.angle))
    centrifugal = CASE.mass * (vx * vx + vy * vy) / r
    assert force(CASE, pressed) == pytest.approx(pull - centrifugal, rel=1e-3)


@pytest.mark.parametrize("contact", [PLASTIC, CLIPPED], ids=lambda c: c.name)
def test_the_margin_of_a_settled_contact_is_that_on_the_crest(contact):
    """The passage judges before the crest, the steady route on it."""
    case, engine = CASE.replace(contact=contact), Reference("rk4")
    (passage,) = measured(engine, [case], "passage")
    path = follow(engine, case, start_of(case, "passage"), 2.0, every=10)
    margins = margin(case, 1, path.x_m, path.y_m, path.vx_m_per_s, path.vy_m_per_s)
    crest = np.flatnonzero(path.x_m > crest_place(case, 1))[0]
    assert crest_place(case, 1) - settled_place(case) > 0.1 * case.diameter
    assert passage.motion is Motion.MOVES_ON
    assert margins[crest] == pytest.approx(passage.margin_J, abs=2e-6 * case.weight_energy)
