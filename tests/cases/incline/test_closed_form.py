"""The function ``theory``, expected angles, and contacts that a passage cannot measure."""

import itertools
import math

import pytest

from harness.cases.incline.closed_form import (
    angles_to_compare,
    check_passage,
    expected_angle,
    most_restitution,
    rebound,
    restitution_in_steps,
    theory,
)
from harness.cases.incline.search import critical_angle
from harness.cases.incline.system import Incline
from harness.engines.reference import Reference
from harness.errors import RequestError
from harness.model.conventions import Rules
from harness.model.law import CLIPPED, SOURCE, Contact, Law, damping_ratio
from harness.model.scene import Body, Scene
from harness.solvers import reference
from harness.solvers.hard_sphere import critical_angle as by_events
from harness.theory.contact import restitution_clipped, restitution_unclipped
from harness.theory.incline import FRICTIONLESS, INTEGRATED, ROLLING
from tests.cases.common import assert_refused

HALF = Contact(restitution=0.5)


def test_keys_and_values_of_version_1():
    assert theory().to_json() == {
        "critical_angle_deg": pytest.approx(10.207818722034197, abs=1e-12),
        "shock": 0.25,
        "reading": None,
        "static_angle_deg": 30.0,
        "no_flight_bound_deg": pytest.approx(15.295344301404732, abs=1e-12),
        "well_depth": pytest.approx(0.05907301480239402),
        "gain_per_crest": pytest.approx(0.17721904440718214),
        "steady_energy": pytest.approx(0.05907301480239405),
        "restitution": None,
        "one_shock_kept_deg": None,
        "one_shock_lost_deg": None,
        "event_driven_deg": None,
        "caveat": None,
    }


def test_a_restitution_has_both_readings_and_rigid_spheres():
    found = theory(restitution=0.5)
    assert found.one_shock_kept_deg < 10.2078 < found.one_shock_lost_deg
    assert found.event_driven_deg == by_events(0.5)
    assert found.caveat
    assert theory(restitution=0.8).event_driven_deg is None
    assert theory(restitution=0.0).caveat is None


@pytest.mark.parametrize(
    ("options", "angle", "model"),
    [
        ({"friction": 0.0}, 10.207819, FRICTIONLESS),
        ({"friction": 0.5}, 6.667404, ROLLING),
        ({"friction": 0.5, "shape": "disc"}, 6.135075, ROLLING),
        ({"grain_diameter": 2.0}, 2.457224, FRICTIONLESS),
        ({"friction": 0.016}, 10.686941, INTEGRATED),
        ({"friction": 0.1}, 7.653064, INTEGRATED),
    ],
)
def test_friction_and_sizes(options, angle, model):
    found = theory(**options)
    assert found.critical_angle_deg == pytest.approx(angle, abs=1e-6)
    assert found.model == model
    assert len(found.to_frame()) == 1


def test_bounds_of_friction():
    sphere, disc = theory(friction=0.5), theory(friction=0.5, shape="disc")
    bounds = sphere.sticking_friction, sphere.rolling_friction, disc.rolling_friction
    assert bounds == pytest.approx((0.16496, 0.32848, 0.35666), abs=1e-5)
    assert sphere.shock == pytest.approx(81 / 196)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"reading": "kept"}, "only with --restitution or --impulse-ratio"),
        ({"reading": "kept", "shock": 0.1}, "only with --restitution or --impulse-ratio"),
        ({"friction": 0.5, "shock": 0.1}, "give one of them only"),
        ({"shape": "disc"}, "only with --friction"),
        ({"diameter": 2.0}, "only with --grain-diameter"),
        ({"friction": -1.0}, "friction = -1.0"),
        ({"friction": 0.5, "shape": "cube"}, "shape = 'cube'"),
        ({"grain_diameter": 101.0}, "at most 100 m"),
    ],
)
def test_options_that_are_refused(options, words):
    assert_refused(words, theory, **options)


def test_the_rebound_is_that_of_the_law_and_decides_what_is_expected():
    assert rebound(SOURCE) == pytest.approx(1e-20, rel=1e-9)
    assert rebound(CLIPPED) == pytest.approx(math.exp(-2.0))
    assert rebound(HALF.replace(effective_mass="half")) > 0.6
    assert expected_angle(Incline()) == theory().critical_angle_deg
    assert expected_angle(Incline(contact=HALF)) == by_events(rebound(HALF))
    assert expected_angle(Incline(contact=Contact(restitution=0.8))) is None
    assert expected_angle(Incline(contact=HALF, friction=0.5)) is None


def test_a_measured_angle_is_compared_with_the_theory_of_its_grain():
    assert angles_to_compare(Incline()) == {"closed_form_deg": theory().critical_angle_deg}
    for grain, key in (
        ({"friction": 0.5}, "closed_form_deg"),
        ({"friction": 0.1, "shape": "disc"}, "integrated_deg"),
        ({"grain_diameter": 2.0}, "closed_form_deg"),
    ):
        expected = theory(**grain).critical_angle_deg
        assert angles_to_compare(Incline(**grain)) == {key: expected}
    both = {"closed_form_kept_deg", "closed_form_lost_deg", "theory"}
    assert set(angles_to_compare(Incline(contact=HALF))) == both
    assert set(angles_to_compare(Incline(contact=HALF, friction=0.5))) == {"theory"}


HOPPING = [
    (Contact(restitution=0.35), 50.0, 1e6),
    (Contact(restitution=0.25, tail="clipped"), 50.0, 1e6),
    (Contact(restitution=0.325), 20.0, 1e7),
    (Contact(restitution=0.335), 100.0, 1e7),
]


@pytest.mark.parametrize(("contact", "steps", "stiffness"), HOPPING)
def test_a_contact_that_hops_to_where_a_passage_is_judged_is_refused(contact, steps, stiffness):
    case = Incline(contact=contact, steps_per_contact=steps, stiffness=stiffness)
    assert_refused(r"restitution 0.3[23]\d* at most at stiffness 1e", check_passage, case)


@pytest.mark.parametrize("tail", ["attractive", "clipped"])
@pytest.mark.parametrize(("stiffness", "steps"), [(1e5, 50.0), (1e7, 15.0)])
def test_a_contact_that_is_not_refused_slides_where_it_is_judged(tail, stiffness, steps):
    def is_allowed(case):
        try:
            check_passage(case)
        except RequestError:
            return False
        return True

    contacts = (Contact(damping_ratio=0.3 + 0.002 * n, tail=tail) for n in itertools.count())
    cases = (Incline(contact=one, steps_per_contact=steps, stiffness=stiffness) for one in contacts)
    case = next(filter(is_allowed, cases))  # rebounds the most
    with Reference() as engine:
        assert critical_angle(case, engine=engine).value > theory().critical_angle_deg


def test_a_soft_contact_is_judged_later_and_may_rebound_more():
    soft = Incline(contact=Contact(restitution=0.39), stiffness=1e4)
    assert most_restitution(soft) == pytest.approx(0.4)
    with Reference() as engine:
        found = critical_angle(soft, engine=engine)
        steady = critical_angle(soft, method="steady", engine=engine)
    assert found.value == pytest.approx(steady.value, abs=steady.uncertainty + 0.01)


@pytest.mark.parametrize("clipped", [False, True])
@pytest.mark.parametrize("scheme", ["velocity_verlet", "mfix_euler"])
@pytest.mark.parametrize("steps", [8.0, 20.0])
def test_the_restitution_in_steps_is_the_greatest_of_the_reference(steps, scheme, clipped):
    zeta = damping_ratio(0.3)
    step = math.pi / steps  # of a contact with k = m = 1
    fixed = Body(radius=0.5, mass=1.0, motion="frozen")
    found = []
    for phase in range(60):
        start = (0.0, 1.0 + step * (1.0 + (phase + 0.5) / 60), 0.0)
        grain = Body(radius=0.5, mass=1.0, position=start, velocity=(0.0, -1.0, 0.0))
        scene = Scene(bodies=(grain, fixed), law=Law.linear(1.0, zeta, clipped), step=step,
                      steps=3 * int(steps), every=3 * int(steps))  # fmt: skip
        found.append(reference.run(scene, Rules(scheme=scheme)).velocity[-1, 0, 1])
    exact = (restitution_clipped if clipped else restitution_unclipped)(zeta)
    greatest = restitution_in_steps(zeta, steps, clipped=clipped)
    assert greatest >= exact
    assert max(*found, exact) == pytest.approx(greatest, abs=0.006)
    assert max(found) <= greatest + 1e-6
