"""Parameters of the incline, its energies and starts, and what is refused."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from harness.cases.incline.runs import (
    crest_radius,
    end_of,
    margin,
    overlaps,
    scene_of,
    settled_before,
    start_of,
)
from harness.cases.incline.system import Incline
from harness.model.law import CONTACTS, PLASTIC, Contact
from harness.theory import incline as theory
from tests.cases.common import assert_refused

ROUGH = {"contact": PLASTIC, "steps_per_contact": 100.0, "friction": 0.5}
GRAINS = st.sampled_from([{}, {"grain_diameter": 2.0}, ROUGH, {**ROUGH, "shape": "disc"}])


def growth(zeta, steps_per_contact, half_angle):
    """Return the spectral radius of a step of velocity Verlet in the well, k = m = 1."""
    step = math.pi / steps_per_contact
    normals = [np.array([math.sin(a), math.cos(a)]) for a in (half_angle, -half_angle)]
    springs = sum(np.outer(n, n) for n in normals)
    one, none = np.eye(2), np.zeros((2, 2))
    # state: position, velocity, force of the last evaluation
    kick = np.block([[one, none, none], [none, one, 0.5 * step * one], [none, none, one]])
    drift = np.block([[one, step * one, none], [none, one, none], [none, none, one]])
    force = np.block([[one, none, none], [none, one, none], [-springs, -2 * zeta * springs, none]])
    return max(abs(np.linalg.eigvals(kick @ force @ drift @ kick)))


@pytest.mark.parametrize("zeta", [0.01, 0.99768, 5.0, 20.0])
@pytest.mark.parametrize("size", [1.0, 2.0, 0.85])
def test_stability_bound_is_that_of_the_spectral_radius(zeta, size):
    contact = Contact(damping_ratio=zeta)
    case = Incline(contact=contact, steps_per_contact=500.0, grain_diameter=size)
    low, high = 0.1, 1000.0
    for _ in range(60):
        middle = math.sqrt(low * high)
        stable = growth(zeta, middle, case.half_angle) <= 1.0 + 1e-9
        low, high = (low, middle) if stable else (middle, high)
    assert case.fewest_steps_per_contact == pytest.approx(high, rel=1e-6)


@pytest.mark.parametrize("contact", CONTACTS.values(), ids=CONTACTS)
def test_a_step_at_the_bound_is_refused_and_just_above_it_allowed(contact):
    bound = Incline(contact=contact, steps_per_contact=100.0).fewest_steps_per_contact
    Incline(contact=contact, steps_per_contact=bound * (1 + 1e-12))
    words = r"^steps_per_contact = \S+ is unstable .*must be great"
    assert_refused(words, Incline, contact=contact, steps_per_contact=bound)


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"angle": 30.1}, "angle = 30.1 deg: must be less than or equal to 30"),
        ({"angle": math.nan}, "angle = nan deg: must be"),
        ({"stiffness": 0.0}, "stiffness = 0.0 N/m: must be greater than 0"),
        ({"gravity": -1.0}, "gravity = -1.0 m/s2: must be greater than 0"),
        ({"spheres": 3}, "spheres = 3: must be greater than or equal to 4"),
        ({"phase": 1.5}, "phase = 1.5: must be less than or equal to 1"),
        ({"wells": 0}, "wells = 0: must be greater than or equal to 1"),
        ({"time_limit": 1e308}, r"time_limit = 1e\+308: must be at most 1e\+30"),
        ({"contact": "wet"}, "must be one of source, clipped, plastic"),
        ({"stiffness": 900.0}, r"stiffness = 900 N/m .*at least 981 N/m"),
        ({"diameter": 1e-150}, "beyond floating point"),
        ({"friction": -0.1}, "friction = -0.1: must be greater than or equal to 0"),
        ({"shape": "cube"}, "shape = 'cube': must be 'sphere' or 'disc'"),
        ({"grain_diameter": 5.0}, r"grain_diameter = 5 m: must be at most 4.5 m, half of a row"),
        ({"grain_diameter": 0.5}, r"grain_diameter = 0.5 m: must be at least 0.8\d+ m at friction"),
        ({**ROUGH, "grain_diameter": 0.6}, r"must be at least 0.6\d+ m at friction 0.5, a smaller"),
    ],
)
def test_bad_input_is_one_line_with_name_value_and_what_is_allowed(values, words):
    assert_refused(words, Incline, **values)


@given(st.floats(0.0, 19.0), st.integers(1, 50), GRAINS)
def test_a_grain_at_rest_on_a_crest_has_no_margin(angle, well, grain):
    case = Incline(angle=angle, **grain)
    tilt, r = math.radians(angle), crest_radius(case)
    x, y = well * case.diameter - r * math.sin(tilt), r * math.cos(tilt)
    assert margin(case, well, (x, y, 0.0, 0.0)) == pytest.approx(0.0, abs=1e-12 * well)
    assert x == pytest.approx(end_of(case, "steady", well))


@given(st.floats(0.0, 29.0), st.floats(0.0, 1.0), GRAINS)
def test_a_passage_starts_with_the_energy_of_the_crest_behind_it(angle, phase, grain):
    case = Incline(angle=angle, phase=phase, **grain)
    x, y, vx, vy, spin = start_of(case, "passage")
    rotation = 0.5 * case.inertia * case.mass * (0.5 * case.grain * spin) ** 2
    left = margin(case, 0, (x, y, vx, vy)) + rotation / case.weight_energy
    assert left == pytest.approx(0.0, abs=1e-12)
    assert max(overlaps(case, x, y)) > 0.0
    assert (spin < 0.0) == (case.friction > 0.0)  # it rolls along +x on what is below


@given(GRAINS)
def test_steady_motion_starts_between_two_spheres_along_the_tangent_of_the_one_ahead(grain):
    case = Incline(**grain)
    x, y, vx, vy, _ = start_of(case, "steady")
    assert overlaps(case, x, y) == pytest.approx((0.0, 0.0), abs=1e-15)
    assert vx * (x - case.diameter) + vy * y == pytest.approx(0.0, abs=1e-15)
    assert math.hypot(vx, vy) == pytest.approx(0.48 * math.sqrt(9.81))


def test_a_passage_ends_before_the_crest_but_past_the_well_and_on_it_where_the_grain_may_slide():
    plain, slides = Incline(angle=10.0, stiffness=1e7), Incline(**{**ROUGH, "friction": 0.1})
    assert 0.5 < end_of(plain, "passage", 1) < end_of(plain, "steady", 1)
    assert settled_before(slides) == 0.0
    assert end_of(slides, "passage", 1) == end_of(slides, "steady", 1)


def test_a_grain_rolls_all_along_from_the_friction_of_the_theory_on():
    bound = theory.rolling_friction(30.0, 0.4)
    angle = theory.critical_angle_without_loss(30.0, 0.4)
    case = Incline(**{**ROUGH, "friction": bound * (1 - 1e-9), "angle": angle})
    assert case.ends_on_crest
    assert not case.replace(friction=bound * (1 + 1e-9)).ends_on_crest
    assert not Incline().ends_on_crest


def test_the_scene_is_the_system():
    case = Incline(**ROUGH, grain_diameter=2.0)
    scene = scene_of(case, "steady", 10)
    grain, *row = scene.bodies
    assert (grain.radius, grain.mass) == (1.0, pytest.approx(8.0))
    assert {body.motion for body in row} == {"frozen"}
    assert len(scene.stages) == case.wells
    assert scene.law.tangential_stiffness == pytest.approx(2e6 / 7)
    half = scene_of(Incline(contact=Contact(restitution=0.0, effective_mass="half")), "passage")
    assert {body.motion for body in half.bodies[1:]} == {"held"}
    disc = scene_of(Incline(**ROUGH, shape="disc"), "passage").bodies[0]
    assert disc.moment_of_inertia == pytest.approx(0.5 * disc.mass * disc.radius**2)
