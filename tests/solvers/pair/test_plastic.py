"""mdr's yield: the law written down again, the volume kept, Boussinesq's sphere, energy, limits."""

import math

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp
from scipy.optimize import brentq

from harness.errors import RequestError
from harness.parameters.law import ContactLaw
from harness.parameters.rules import Rules
from harness.parameters.scene import Body, ContactScene, Plane
from harness.solvers.pair.integration import integrate
from harness.solvers.pair.normal import SWELLING, pressed, sprung_back, swelling
from harness.solvers.pair.system import system_of
from tests.solvers.pair.scenes import FLOOR, MASS, RADIUS

YOUNG, NU, STRESS = 1e8, 0.3, 1e6
PLANE_STRAIN, SHEAR = YOUNG / (1.0 - NU**2), YOUNG / 2.6
BULK = YOUNG / 1.2
SPHERE = 4.0 / 3.0 * math.pi * RADIUS**3
LAW = ContactLaw(normal="mdr", youngs_modulus=YOUNG, poisson_ratio=NU, yield_stress=STRESS)


def scene(wall, law=LAW, speed=1.0, time=1e-3, gap=0.0):
    first = Body(RADIUS, MASS, (0.0, 0.0, RADIUS + gap), (0.0, 0.0, -speed))
    second = Body(RADIUS, MASS, (0.0, 0.0, -RADIUS))
    bodies, planes = ((first,), (FLOOR,)) if wall else ((first, second), ())
    return ContactScene(bodies, planes, law, step=time, steps=1)


def pressure(depth, radius):
    return STRESS * (1.0 + 1.75 * math.exp(-4.4 * depth / radius))


ONSET = brentq(
    lambda d: 4.0 * PLANE_STRAIN / (3.0 * math.pi) * math.sqrt(d / RADIUS) - pressure(d, RADIUS),
    1e-9,
    RADIUS,
    xtol=1e-18,
)


def force(depth, grown):
    """Return p pi a^2 of a flat that is ``depth`` deep in the sphere as it was."""
    real, radius = depth + grown, RADIUS + grown
    square = 2.0 * radius * real - real**2 - ONSET * (RADIUS - ONSET)
    return math.pi * square * pressure(real, radius)


def strain(depth, grown):
    """Return e of e (1 + e) = -F d / (3 K V_0)."""
    q = force(depth, grown) * (RADIUS - depth) / (3.0 * BULK * SPHERE)
    return -0.5 + math.sqrt(0.25 - q)


def volume(depth, grown):
    """Return what is left of the grown sphere beside the flat, less its elastic strain."""
    real, radius = depth + grown, RADIUS + grown
    cap = math.pi / 3.0 * real**2 * (3.0 * radius - real)
    return 4.0 / 3.0 * math.pi * radius**3 - cap - SPHERE * strain(depth, grown)


def swollen(depth):
    """Return the growth of the radius by its rate: dV = 0 where that makes it grow, else none."""
    h = 1e-4 * RADIUS

    def rate(x, y):
        by_way = (volume(x + h, y[0]) - volume(x - h, y[0])) / (2.0 * h)
        by_growth = (volume(x, y[0] + h) - volume(x, y[0] - h)) / (2.0 * h)
        return [max(0.0, -by_way / by_growth)]

    path = solve_ivp(rate, (ONSET, depth), [0.0], rtol=1e-9, atol=1e-18, max_step=depth / 200.0)
    return path.y[0, -1]


def at(depth, *, wall=True, largest=0.0):
    """Return the force at a depth of a contact that swells, or opens from a largest one."""
    system = system_of(scene(wall), Rules())
    one, flats = system.contacts[0], 1.0 if wall else 2.0
    one["stage"], one["largest"] = SWELLING, flats * largest
    return pressed(system.law, one, flats * depth)


@pytest.mark.parametrize("depth", [1.5e-4, 3e-4, 1e-3])
def test_the_radius_grows_by_what_the_flat_displaces(depth):
    system = system_of(scene(wall=True), Rules())
    grown, slope = swelling(system.law, system.contacts[0], depth, RADIUS)
    assert grown == pytest.approx(swollen(depth), rel=2e-5)
    ahead, _ = swelling(system.law, system.contacts[0], depth + 1e-8, RADIUS)
    behind, _ = swelling(system.law, system.contacts[0], depth - 1e-8, RADIUS)
    assert slope == pytest.approx((ahead - behind) / 2e-8, rel=1e-6)
    begun = system.contacts[0]["swells"]
    assert volume(depth, grown) - volume(begun, 0.0) == pytest.approx(0.0, abs=1e-15 * SPHERE)
    assert at(depth).force == pytest.approx(force(depth, grown), rel=1e-13)


def test_it_yields_at_hertz_s_pressure_and_swells_once_the_volume_would_shrink():
    path = integrate(scene(wall=True))
    (yields,), (swells,) = path.of_kind("yields"), path.of_kind("swells")
    assert yields.overlap == pytest.approx(ONSET, rel=1e-12)
    h = 1e-7
    before, after = (
        volume(x + h, 0.0) - volume(x - h, 0.0)
        for x in (swells.overlap - 1e-6, swells.overlap + 1e-6)
    )
    assert before > 0.0 > after
    # the ellipse is softer than Hertz's sphere, whose pressure tells: by 3/40 of the depth over R
    jump = force(ONSET, 0.0) / yields.force - 1.0
    assert jump == pytest.approx(0.075 * ONSET / RADIUS, rel=0.01)


@pytest.mark.parametrize("largest", [3e-4, 1e-3])
def test_it_springs_back_by_how_much_the_surface_moves_more_than_the_centre(largest):
    """Boussinesq's point loads P: u = P / (4 pi G) (z^2 / s^3 + 2 (1 - nu) / s), over a circle."""
    system = system_of(scene(wall=True), Rules())
    one = system.contacts[0]
    grown, _ = swelling(system.law, one, largest, RADIUS)
    dent = sprung_back(system.law, one, largest, RADIUS)
    p = pressure(largest + grown, RADIUS + grown)
    a = math.sqrt(force(largest, grown) / (math.pi * p))

    def moved(z):
        def ring(r):
            s = math.hypot(r, z)
            return 0.5 * r * p / SHEAR * (z * z / s**3 + 2.0 * (1.0 - NU) / s)

        return quad(ring, 0.0, a, epsrel=1e-12)[0]

    surface = moved(0.0)
    centre = moved(RADIUS - largest + surface)
    assert dent.height == pytest.approx(2.0 * surface, rel=1e-9)
    assert dent.width == pytest.approx(2.0 * a, rel=1e-12)
    assert largest - dent.residual == pytest.approx(surface - centre, rel=1e-9)
    assert (largest - dent.residual) * dent.stretch == pytest.approx(surface, rel=1e-9)


def test_back_it_meets_the_force_that_it_left_and_nothing_at_the_dent():
    largest = 5e-4
    top = at(largest)
    assert at(largest * (1.0 - 1e-13), largest=largest).force == pytest.approx(top.force, rel=1e-10)
    system = system_of(scene(wall=True), Rules())
    left = sprung_back(system.law, system.contacts[0], largest, RADIUS).residual
    assert at(left, largest=largest).force == 0.0
    assert at(left + 1e-3 * (largest - left), largest=largest).force > 0.0
    both = at(4e-4, wall=False, largest=largest), at(4e-4, largest=largest)
    assert both[0].force == pytest.approx(both[1].force, rel=1e-13)
    assert both[0].slope == pytest.approx(0.5 * both[1].slope, rel=1e-13)


@pytest.mark.parametrize("depth", [2e-4, 6e-4])
def test_the_slope_is_that_of_the_force(depth):
    for largest in (0.0, 7e-4):
        h = 1e-9
        ahead, behind = at(depth + h, largest=largest), at(depth - h, largest=largest)
        told = at(depth, largest=largest).slope
        assert told == pytest.approx((ahead.force - behind.force) / (2.0 * h), rel=1e-5)


@pytest.mark.parametrize("wall", [True, False])
def test_an_impact_keeps_what_the_ellipse_gives_back(wall):
    """Its work down to the dent: (1 - u / (A/2)) E' A^2 B / 12 on each side of the flat."""
    path = integrate(scene(wall))
    flats, mass = (1.0, MASS) if wall else (2.0, MASS / 2.0)
    (turn,) = path.of_kind("turns")
    largest = turn.overlap / flats
    system = system_of(scene(wall), Rules())
    one = system.contacts[0]
    swells = one["swells"]

    def grown(x):
        return swelling(system.law, one, x, RADIUS)[0]

    elastic = system_of(scene(True, LAW.replace(yield_stress=None)), Rules())
    first = quad(
        lambda x: pressed(elastic.law, elastic.contacts[0], x).force, 0.0, ONSET, epsrel=1e-12
    )[0]
    flows = sum(
        quad(lambda x: force(x, grown(x)), *ends, epsrel=1e-12)[0]
        for ends in ((ONSET, swells), (swells, largest))
    )
    assert flats * (first + flows) == pytest.approx(0.5 * mass, rel=1e-10)
    dent = sprung_back(system.law, one, largest, RADIUS)
    back = PLANE_STRAIN * dent.height**2 * dent.width / 12.0 / dent.stretch
    left = -path.velocities[-1, 0, 2]
    left += 0.0 if wall else path.velocities[-1, 1, 2]
    assert left == pytest.approx(-math.sqrt(2.0 * flats * back / mass), rel=1e-10)
    (end,) = path.of_kind("ends")
    assert end.overlap == pytest.approx(flats * dent.residual, rel=1e-9)


def test_a_stress_that_is_not_reached_is_the_elastic_branch_to_the_bit():
    for wall in (True, False):
        plain = integrate(scene(wall, LAW.replace(yield_stress=None)))
        for stress in (1e8, 1e30):
            path = integrate(scene(wall, LAW.replace(yield_stress=stress)))
            assert np.array_equal(path.velocities, plain.velocities)
            assert not path.of_kind("yields", "swells")


def test_a_softer_sphere_gives_less_back():
    lost = [
        integrate(scene(True, LAW.replace(yield_stress=stress))).velocities[-1, 0, 2]
        for stress in (2e6, 1e6, 5e5)
    ]
    assert lost == sorted(lost, reverse=True)
    assert lost[0] < 1.0


def test_what_has_no_law_is_refused():
    second = Plane((0.0, 0.0, 3.0 * RADIUS), (0.0, 0.0, -1.0))
    one = scene(wall=True)
    with pytest.raises(RequestError, match="takes one contact, not 2"):
        integrate(ContactScene(one.bodies, (FLOOR, second), LAW, 1e-6, 1))
    with pytest.raises(RequestError, match="takes bodies that begin apart"):
        integrate(scene(wall=True, gap=-1e-5))
    falling = ContactScene(
        one.bodies, one.planes, LAW, step=0.2, steps=1, gravity=(0.0, 0.0, -9.81)
    )
    with pytest.raises(RequestError, match="takes one contact: a second one is not flat"):
        integrate(falling)
