"""How the systems are laid out in MFiX's box."""

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from harness.cases.drop import case as drop
from harness.cases.drop.case import Drop
from harness.cases.incline.system import start_behind_crest, start_in_well
from harness.cases.incline.verification import CONTACT, case_at
from harness.cases.tower import system as tower
from harness.cases.tower.system import Timing
from harness.engines.mfix.system import system_of
from harness.errors import RequestError
from harness.parameters.tower import Tower


@pytest.fixture
def incline(incline_of):
    case = case_at(10.2, 1e6, 500.0)
    return case, incline_of(case, start_behind_crest(case), 3, 2.0, 50)[1]


def drop_scene(case):
    return drop.scene_of(drop.values_of(case))


def tower_scene(case, steps_per_contact=1000.0, every=10):
    timing = Timing(3.0, 0.0, 0, every, steps_per_contact)
    return tower.scene_of(tower.values_of(case, timing))


def tower_system(case, steps=3000, every=10, **how):
    return system_of("tower", tower_scene(case, every=every, **how), steps, every)


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


def test_a_grain_that_just_touches_is_lifted_over_rounding(incline_of):
    case = case_at(10.2, 1e6, 50.0)
    _, system = incline_of(case, start_in_well(case), 1, 1.0, 50)
    (grain,) = system.mobile
    gaps = [math.hypot(grain.x - s.x, grain.y - s.y) - case.diameter for s in system.held]
    assert 0.0 < min(gaps) < 1e-11
    # nothing pushes in the first step
    assert len({(s.vx, s.vy) for s in system.spheres[1:]}) == 1


def test_a_drop_stays_clear_of_the_walls():
    case = Drop(contact=CONTACT, gap=0.3, speed=2.0, sideways=-5.0, duration=200.0, every=1000)
    system = system_of("drop", drop_scene(case), case.steps, case.every)
    reach = 5.0 * case.steps * case.step
    (grain,) = system.mobile
    assert reach + case.diameter < grain.x < system.box[0] - reach - case.diameter
    assert grain.y + case.speed * case.steps * case.step + case.diameter < system.box[1]


@pytest.mark.parametrize("base", ["fixed", "free"])
def test_a_tower_stands_grain_on_top_with_its_base_held_or_free_of_the_floor(base):
    case = Tower(height=3, law="overlap", stiffness=1e5, base=base)
    system = tower_system(case)
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
    system = tower_system(case)
    heights = [s.y for s in (*system.mobile, *system.held)]
    overlaps = [1.0 - (above - below) for above, below in pairwise(heights)]
    unit = 9.81 / 1e5
    assert overlaps == pytest.approx([0.0, unit, 2 * unit, 3 * unit], abs=1e-14)


def test_a_gapped_tower_has_the_gap_at_every_contact():
    system = tower_system(Tower(height=2, law="overlap", start="gapped", gap=0.01))
    heights = [s.y for s in (*system.mobile, *system.held)]
    assert [above - below for above, below in pairwise(heights)] == pytest.approx([1.01, 1.01])


def test_frames_of_forces_come_a_step_after_the_samples():
    """The clock begins at every - 1 steps, for the force of the step before a frame."""
    for every in (1, 3, 10):
        system = tower_system(Tower(height=2, law="overlap"), every=every)
        assert (system.first + 1) % every == 0
        assert (system.first + system.steps) % every == 3000 % every


def test_a_damping_ratio_is_stated_as_its_restitution(incline_of):
    contact = CONTACT.replace(restitution=None, damping_ratio=0.5)
    case = case_at(10.2, 1e6, 500.0).replace(contact=contact)
    _, system = incline_of(case, start_in_well(case), 1, 1.0, 50)
    assert system.contact.replace(damping_ratio=None, restitution=system.restitution).zeta == (
        pytest.approx(0.5, rel=1e-12)
    )


def test_a_step_that_mfix_does_not_take_is_refused():
    case = Tower(law="overlap")
    with pytest.raises(RequestError, match="which takes 10 or more"):
        _ = tower_system(case, steps_per_contact=14.0).factor
    assert tower_system(case, steps_per_contact=14.2).factor > 10.0


def row_scene():
    """Return three particles in a line, the last fixed."""
    return tower_scene(Tower(height=2, law="overlap"))


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"fixed": np.array([False, True, True])}, "it holds the last alone"),
        ({"fixed": np.array([True, False, False])}, "must come last"),
        ({"position": np.array([[0.0, 0.0], [2.0, 0.0], [1.0, 0.0]])}, "must come in order"),
        ({"mass": np.array([1.0, 1.0, 2.0])}, "have one mass"),
        ({"diameter": np.array([1.0, 1.0, 2.0])}, "have one diameter"),
        ({"gravity": (0.0, -9.81)}, "forces are those of particles in a line"),
        ({"gravity": (0.0, -9.81), "forces": False, "fixed": np.full(3, False)}, "must be level"),
    ],
)
def test_a_scene_that_mfix_cannot_hold_is_refused(changes, said):
    arrays = {n: v for n, v in changes.items() if isinstance(v, np.ndarray)}
    others = {n: v for n, v in changes.items() if n not in arrays}
    scene = replace(row_scene().with_spheres(**arrays), **others)
    with pytest.raises(RequestError, match=said):
        system_of("line", scene, 100, 10)


def test_an_endless_row_without_stages_is_refused(incline_of):
    case = case_at(10.2, 1e6, 500.0)
    scene, _ = incline_of(case, start_in_well(case), 1, 1.0, 50)
    with pytest.raises(RequestError, match="must say by its stages how far"):
        system_of("row", replace(scene, stages=()), 100, 10)


def test_a_row_may_begin_elsewhere(incline_of):
    case = case_at(10.2, 1e6, 500.0)
    scene, system = incline_of(case, start_in_well(case), 2, 1.0, 50)
    stages = tuple(replace(stage, place=stage.place + 3.25) for stage in scene.stages)
    moved = replace(scene, stages=stages).with_spheres(
        position=scene.position + np.array([3.25, -1.0])
    )
    there = system_of("incline", moved, system.steps, 50)
    assert there.held == system.held
    assert there.box == system.box
    assert there.origin == pytest.approx((system.origin[0] - 3.25, system.origin[1] + 1.0))
