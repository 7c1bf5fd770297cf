"""How the systems are laid out in MFiX's box."""

import math
from itertools import pairwise

import pytest

from harness.cases.drop.parameters import Drop
from harness.cases.incline.routes import start_behind_crest, start_in_well
from harness.engines.mfix.recorded import CONTACT, case_at
from harness.engines.mfix.system import (
    drop_system,
    incline_system,
    start_displacements,
    tower_system,
)
from harness.errors import RequestError
from harness.parameters.tower import Tower


@pytest.fixture
def incline():
    case = case_at(10.2, 1e6, 500.0)
    return case, incline_system(case, start_behind_crest(case), 3, 2.0, 50)


def test_what_is_held_is_a_radius_above_the_outlet_and_comes_last(incline):
    case, system = incline
    assert all(sphere.y == 0.5 * case.diameter for sphere in system.held)
    assert system.spheres[: len(system.mobile)] == system.mobile
    assert all(sphere.x > 0.5 * case.diameter for sphere in system.held)
    assert max(s.x for s in system.held) + 0.5 * case.diameter < system.box[0]


def test_the_row_reaches_two_wells_beyond_the_last(incline):
    _, system = incline
    places = [sphere.x - system.origin[0] for sphere in system.held]
    assert places == pytest.approx([-1.0, 0.0, 1.0, 2.0, 3.0, 4.0, 5.0])


def test_a_held_sphere_starts_with_what_gravity_and_the_grain_take_in_a_step(incline):
    """The grain starts in balance: its push along the normal holds its weight's component."""
    case, system = incline
    gx, gy = system.gravity
    free, under = system.spheres[1], system.spheres[2]
    assert (free.vx, free.vy) == pytest.approx((-gx * system.step, -gy * system.step), rel=1e-12)
    (grain,), sphere = system.mobile, system.held[1]
    distance = math.hypot(grain.x - sphere.x, grain.y - sphere.y)
    nx, ny = (sphere.x - grain.x) / distance, (sphere.y - grain.y) / distance
    push = case.stiffness * (case.diameter - distance)
    eta = 2 * CONTACT.zeta * math.sqrt(case.stiffness * 0.5)
    push += eta * (grain.vx * nx + grain.vy * ny)
    taken = (under.vx - free.vx, under.vy - free.vy)
    assert taken == pytest.approx((-push * nx * system.step, -push * ny * system.step), rel=1e-9)
    assert 0.5 * case.gravity < push < case.gravity


def test_a_grain_that_just_touches_is_lifted_over_rounding():
    case = case_at(10.2, 1e6, 50.0)
    system = incline_system(case, start_in_well(case), 1, 1.0, 50)
    (grain,) = system.mobile
    gaps = [math.hypot(grain.x - s.x, grain.y - s.y) - case.diameter for s in system.held]
    assert 0.0 < min(gaps) < 1e-11
    # nothing pushes in the first step
    assert len({(s.vx, s.vy) for s in system.spheres[1:]}) == 1


def test_a_drop_stays_clear_of_the_walls():
    case = Drop(contact=CONTACT, gap=0.3, speed=2.0, sideways=-5.0, duration=200.0, every=1000)
    system = drop_system(case)
    reach = 5.0 * case.steps * case.step
    (grain,) = system.mobile
    assert reach + case.diameter < grain.x < system.box[0] - reach - case.diameter
    assert grain.y + case.speed * case.steps * case.step + case.diameter < system.box[1]


@pytest.mark.parametrize("base", ["fixed", "free"])
def test_a_tower_stands_grain_on_top_with_its_base_held_or_free_of_the_floor(base):
    case = Tower(height=3, law="overlap", stiffness=1e5, base=base)
    system = tower_system(case, 1e-5, 3000, 10)
    assert [s.y for s in system.mobile] == sorted((s.y for s in system.mobile), reverse=True)
    assert len(system.held) == (base == "fixed")
    assert system.steps == 3001
    heights = [s.y for s in (*system.mobile, *system.held)]
    assert heights == pytest.approx([system.origin[1] - i for i in range(4)])
    if base == "free":
        time = system.steps * system.step
        fall = case.speed * time + 0.5 * case.gravity * time**2
        assert heights[-1] - fall > case.each("diameter")[0]


def test_a_preloaded_tower_bears_what_is_between_each_contact_and_the_grain():
    case = Tower(height=4, law="overlap", stiffness=1e5, start="preloaded")
    displaced = start_displacements(case)
    overlaps = [a - b for a, b in pairwise(displaced)]
    unit = 9.81 / 1e5
    assert overlaps == pytest.approx([0.0, unit, 2 * unit, 3 * unit])


def test_a_gapped_tower_has_the_gap_at_every_contact():
    case = Tower(height=2, law="overlap", start="gapped", gap=0.01)
    assert start_displacements(case) == pytest.approx([0.0, 0.01, 0.02])


def test_a_damping_ratio_is_stated_as_its_restitution():
    contact = CONTACT.replace(restitution=None, damping_ratio=0.5)
    case = case_at(10.2, 1e6, 500.0).replace(contact=contact)
    system = incline_system(case, start_in_well(case), 1, 1.0, 50)
    assert system.contact.replace(damping_ratio=None, restitution=system.restitution).zeta == (
        pytest.approx(0.5, rel=1e-12)
    )


def test_a_step_that_mfix_does_not_take_is_refused():
    case = case_at(10.2, 1e6, 50.0)
    system = incline_system(case, start_in_well(case), 1, 1.0, 50)
    with pytest.raises(RequestError, match="which takes 10 or more"):
        _ = tower_system(Tower(law="overlap"), system.step * 100, 10, 1).factor
