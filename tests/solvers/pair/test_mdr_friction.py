"""Friction beside mdr: a march by steps of the law written down again, limits, refusals."""

import math

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.interpolate import CubicSpline
from scipy.optimize import brentq

from harness.errors import RequestError
from harness.parameters.law import ContactLaw
from harness.parameters.rules import Rules
from harness.parameters.scene import Body, ContactScene, Segment
from harness.solvers.pair import geometry
from harness.solvers.pair.geometry import levers
from harness.solvers.pair.integration import integrate
from harness.solvers.pair.normal import SWELLING, grown, sprung_back
from harness.solvers.pair.system import system_of
from tests.solvers.pair.scenes import FLOOR, MASS, RADIUS
from tests.solvers.pair.test_plastic import (
    BULK,
    LAW,
    NU,
    ONSET,
    PLANE_STRAIN,
    SHEAR,
    YOUNG,
    force,
    volume,
)

MU, STIFFNESS = 0.3, 5e4
MINDLIN = 8.0 * SHEAR / (2.0 * (2.0 - NU))
"""[Pa] 8 G* of equal materials."""
ELASTIC = ContactLaw(normal="mdr", youngs_modulus=YOUNG, poisson_ratio=NU)
SPRING = {"tangential": "linear_history", "tangential_stiffness": STIFFNESS, "friction": MU}
SOLID = {"tangential": "mindlin", "friction": MU}
HERTZ = Rules(mdr_friction="hertz")
OBLIQUE = (0.7, 0.0, -0.7)


def scene(law, velocity=OBLIQUE, omega=(0.0, 0.0, 0.0), *, wall=True, time=1.5e-3):
    first = Body(RADIUS, MASS, (0.0, 0.0, RADIUS), velocity, omega)
    second = Body(RADIUS, MASS, (0.0, 0.0, -RADIUS))
    bodies, planes = ((first,), (FLOOR,)) if wall else ((first, second), ())
    return ContactScene(bodies, planes, law, step=time, steps=1)


def after(law, rules=None, **more):
    """Return velocity along x and spin times radius after an impact, [m/s]."""
    path = integrate(scene(law, **more), rules)
    assert path.of_kind("ends")
    return np.array([path.velocities[-1, 0, 0], RADIUS * path.omegas[-1, 0, 1]])


def swollen():
    """Return by how much the radius has grown at a depth [m], as a function."""
    system = system_of(scene(LAW), Rules())
    begun = system.contacts[0]["swells"]
    kept, depths = volume(begun, 0.0), np.linspace(begun, 4e-4, 60)
    more = [brentq(lambda g, d=d: volume(d, g) - kept, 0.0, 1e-3, xtol=1e-16) for d in depths[1:]]
    table = CubicSpline(depths, [0.0, *more])
    return lambda depth: float(table(depth)) if depth > begun else 0.0


SWOLLEN = swollen()


class Normal:
    """Force, contact radius and growth of a sphere on a floor, that yields or does not."""

    def __init__(self, law):
        system = system_of(scene(LAW), Rules())
        self.law, self.contact = system.law, system.contacts[0]
        self.yields, self.bulk, self.most = law.yield_stress is not None, law.bulk_response, 0.0

    def __call__(self, depth):
        if depth <= 0.0:
            return 0.0, 0.0, 0.0
        if self.bulk:
            rest = quad(lambda z: math.pi * (RADIUS**2 - z**2), -RADIUS, RADIUS - depth)[0]
            area = math.pi * RADIUS * depth
            return BULK * area * depth / rest * area, 0.0, 0.0
        if not self.yields or max(depth, self.most) < ONSET:
            return *ellipse(4.0 * RADIUS, 2.0 * RADIUS, depth), 0.0
        if depth >= self.most:
            self.most, more = depth, SWOLLEN(depth)
            square = (depth + more) * (2.0 * RADIUS + more - depth) - ONSET * (RADIUS - ONSET)
            return force(depth, more), math.sqrt(square), more
        more = SWOLLEN(self.most)
        self.contact["stage"] = SWELLING
        dent = sprung_back(self.law, self.contact, self.most, RADIUS)
        return *ellipse(dent.height, dent.width, (depth - dent.residual) * dent.stretch), more


def ellipse(height, width, depth):
    """Return the force of springs, E' for a length, under an ellipse of two axes, and its edge."""
    if depth <= 0.0:
        return 0.0, 0.0
    angle = math.acos(max(-1.0, 1.0 - 2.0 * depth / height))
    area = angle - math.sin(angle) * math.cos(angle)
    return 0.25 * PLANE_STRAIN * height * width * area, 0.5 * width * math.sin(angle)


def marched(law, steps, hertz=False, swells=True):
    """Return velocity along x and spin times radius [m/s] by leapfrog steps of the law."""
    normal, h = Normal(law), 1.5e-3 / steps
    depth, down, along, spin, q = 0.0, 0.7, 0.7, 0.0, 0.0
    for _ in range(steps):
        depth += 0.5 * h * down
        pull, a, more = normal(depth)
        lever = RADIUS + (more if swells else 0.0)
        k = STIFFNESS
        if law.tangential == "mindlin":
            apparent = math.sqrt((RADIUS + more) * max(depth + more, 0.0))
            k = MINDLIN * apparent if hertz else 2.0 * MINDLIN * a
        f = 0.0
        if pull > 0.0:
            q += h * (along - lever * spin)
            f = max(-MU * pull, min(MU * pull, -k * q))
            q = -f / k
        else:
            q = 0.0
        down -= h * pull / MASS
        along += h * f / MASS
        spin -= h * f * lever / (0.4 * MASS * lever**2)
        depth += 0.5 * h * down
    return np.array([along, RADIUS * spin])


@pytest.mark.parametrize(
    ("law", "rules"),
    [
        (ELASTIC.replace(**SPRING), Rules()),
        (ELASTIC.replace(**SOLID), Rules()),
        (ELASTIC.replace(**SOLID), HERTZ),
        (LAW.replace(**SPRING), Rules()),
        (LAW.replace(**SOLID), Rules()),
        (LAW.replace(**SOLID), HERTZ),
    ],
)
def test_a_march_by_steps_of_the_law_comes_to_the_same(law, rules):
    hertz, expected = rules == HERTZ, after(law, rules)
    coarse, fine = (marched(law, n, hertz) for n in (4000, 8000))
    # of first order, but where sliding begins or ends within a step: a quarter of what the radius
    # that grows is worth, which follows
    assert 2.0 * fine - coarse == pytest.approx(expected, abs=3e-6)
    if law.yield_stress is not None:
        as_it_was = marched(law, 8000, hertz, swells=False)
        assert np.abs(as_it_was - fine).max() > 1e-5


@pytest.mark.parametrize("wall", [True, False])
def test_without_friction_nothing_changes_along_the_surface(wall):
    for law in (ELASTIC, LAW, ELASTIC.replace(bulk_response=True)):
        more = {"wall": wall, "time": 6e-3}
        bare = integrate(scene(law, **more)).velocities[-1]
        rubbed = law.replace(**{**SPRING, "friction": 0.0})
        assert np.array_equal(integrate(scene(rubbed, **more)).velocities[-1], bare)
        if law.bulk_response:
            continue
        # of a faint friction what changes is in proportion; its spring turns ever faster with less
        faint = (law.replace(**{**SOLID, "friction": mu}) for mu in (0.01, 0.02))
        less, more_of_it = (integrate(scene(one, **more)).velocities[-1] - bare for one in faint)
        np.testing.assert_allclose(more_of_it, 2.0 * less, rtol=0.0, atol=1e-5)
        assert 1e-3 < np.abs(less).max() < 0.0141  # Coulomb: 0.01 times twice 0.7 at most


@pytest.mark.parametrize("part", [SPRING, SOLID])
def test_a_stress_that_is_not_reached_is_the_elastic_branch_to_the_bit(part):
    stiff = after(LAW.replace(yield_stress=1e30, **part))
    assert np.array_equal(stiff, after(ELASTIC.replace(**part)))


@pytest.mark.parametrize(
    ("wall", "depth"), [(True, 1e-5), (True, 1e-3), (False, 1e-5), (False, 1e-3)]
)
def test_a_small_shear_meets_the_stiffness_of_mindlin_or_of_hertz(wall, depth):
    """8 G* a, G* = G / (2 - nu) at a rigid wall: one side of two equal spheres'."""
    overlap = depth if wall else 2.0 * depth
    still, shear = (0.0, 0.0, 0.0), (1e-3, 0.0, 0.0)
    first = Body(RADIUS, MASS, (0.0, 0.0, RADIUS - overlap))
    second = Body(RADIUS, MASS, (0.0, 0.0, -RADIUS))
    bodies, planes = ((first,), (FLOOR,)) if wall else ((first, second), ())
    piece = Segment(1, (shear, still)[: len(bodies)], (still, still)[: len(bodies)])
    law = ELASTIC.replace(**SOLID)
    guided = ContactScene(bodies, planes, law, step=1e-6, steps=1, segments=(piece,))
    _, a = ellipse(4.0 * RADIUS, 2.0 * RADIUS, depth)
    for rules, k in (
        (Rules(), MINDLIN * a * (2.0 if wall else 1.0)),
        (HERTZ, MINDLIN * math.sqrt(RADIUS * depth)),
    ):
        found = integrate(guided, rules).springs[-1, 0, 0, 0]
        assert found == pytest.approx(-k * 1e-9, rel=1e-6)


@pytest.mark.parametrize("flats", [1.0, 2.0])
def test_levers_and_radius_grow_with_the_overlap_and_stay_as_it_opens(flats):
    system = system_of(scene(LAW, wall=flats == 1.0), Rules())
    one = system.contacts[0]
    depth, h = flats * 2e-4, 1e-9
    assert grown(system.law, one, depth) == (0.0, 0.0)
    one["stage"] = SWELLING
    more, rate = grown(system.law, one, depth)
    assert more == pytest.approx(SWOLLEN(2e-4), rel=1e-6)
    ends = [levers(system, 0, geometry.RADIUS, depth + part)[0][0] for part in (-h, h)]
    told = levers(system, 0, geometry.RADIUS, depth)[0]
    assert told == pytest.approx((RADIUS + more, (ends[1] - ends[0]) / (2.0 * h)), rel=1e-5)
    assert told[1] == rate
    # the place of the contact is half of what is left between the centres
    to_contact = levers(system, 0, geometry.CONTACT_POINT, depth)[0]
    if flats == 2.0:
        assert to_contact == (RADIUS - 0.5 * depth, -0.5)
    one["largest"] = depth
    assert grown(system.law, one, 0.5 * depth) == (more, 0.0)


def test_a_bulk_that_responds_from_the_first_touch_on_leaves_nothing_to_yield():
    both = LAW.replace(bulk_response=True)
    for law in (both, both.replace(yield_stress=1.0)):
        found = integrate(scene(law, time=6e-3))
        plain = integrate(scene(ELASTIC.replace(bulk_response=True), time=6e-3))
        assert np.array_equal(found.velocities, plain.velocities)
        assert not found.of_kind("yields", "swells")


@pytest.mark.parametrize("law", [LAW, ELASTIC.replace(bulk_response=True)])
@pytest.mark.parametrize("damping", [("velocity", 2.0), ("mdr", 0.25)])
def test_a_dashpot_beside_a_branch_adds_its_force(law, damping):
    """m v' = -F - eta v up to the end of the force: eta_0, or c sqrt(m 2 E' a) at a wall."""
    kind, coefficient = damping
    if law.bulk_response and kind == "mdr":
        return
    damped = law.replace(damping=kind, damping_coefficient=coefficient)
    path = integrate(scene(damped, (0.0, 0.0, -0.7), time=6e-3))
    normal = Normal(law)

    def eta(a):
        k = 2.0 * PLANE_STRAIN * a
        return coefficient * (math.sqrt(MASS * k) if kind == "mdr" else 1.0)

    found = []
    for h in (4e-7, 2e-7):
        normal, depth, v = Normal(law), 0.0, 0.7
        while True:
            depth += 0.5 * h * v
            push, a, _ = normal(depth)
            if push <= 0.0:
                break
            half = 0.5 * h * eta(a) / MASS  # of the middle of the step
            v = ((1.0 - half) * v - h * push / MASS) / (1.0 + half)
            depth += 0.5 * h * v
        found.append(-v)
    # that a constant dashpot acts in a part of the last step is less than h eta / m
    assert found[1] == pytest.approx(path.velocities[-1, 0, 2], rel=2e-7 * eta(1e-3) / MASS)


def test_a_dashpot_of_the_stiffness_has_none_beside_the_bulk():
    with pytest.raises(RequestError, match="damping = 'mdr': must be none or velocity beside bulk"):
        ELASTIC.replace(bulk_response=True, damping="mdr", damping_coefficient=0.25)


@pytest.mark.parametrize(
    ("told", "beside"),
    [
        ({"yield_stress": 1e6}, "yield_stress = 1000000.0"),
        ({"bulk_response": True}, "bulk_response = True"),
        ({"damping": "velocity", "damping_coefficient": 1.0}, "damping = 'velocity'"),
        (SPRING, "tangential = 'linear_history'"),
    ],
)
def test_adhesion_is_refused_beside_anything_for_what_lammps_makes_of_it(told, beside):
    with pytest.raises(RequestError) as error:
        ELASTIC.replace(surface_energy=0.5, **told)
    assert f"not beside {beside}: LAMMPS's adhesion fades with the step" in str(error.value)


def test_resistance_to_rolling_is_refused_of_a_sphere_that_swells():
    rolls = {"rolling_stiffness": 1.0, "rolling_damping": 0.0, "rolling_friction": 0.1}
    with pytest.raises(RequestError, match="rolling = 'sds': must be none beside yield_stress"):
        LAW.replace(rolling="sds", **rolls)
    assert ELASTIC.replace(rolling="sds", **rolls).rolling == "sds"
