"""mdr on a rigid flat: adhesion by springs and their energy, JKR's limit, the bulk's pressure."""

import math

import pytest
from scipy.integrate import quad

from harness.errors import RequestError
from harness.parameters.law import ContactLaw
from harness.parameters.rules import Rules
from harness.parameters.scene import Body, ContactScene, Plane
from harness.solvers.pair.integration import integrate
from harness.solvers.pair.normal import fold, pressed, sunk
from harness.solvers.pair.system import system_of
from harness.theory import contact
from tests.solvers.pair.scenes import FLOOR, MASS, RADIUS, guided

YOUNG, NU, GAMMA = 1e8, 0.3, 0.5
PLANE_STRAIN, BULK = YOUNG / (1.0 - NU**2), YOUNG / 1.2
MATERIAL = {"normal": "mdr", "youngs_modulus": YOUNG, "poisson_ratio": NU}
STICKS = ContactLaw(**MATERIAL, surface_energy=GAMMA)
RESPONDS = ContactLaw(**MATERIAL, bulk_response=True)


def scene(law, wall, speed=1.0, time=1e-2):
    first = Body(RADIUS, MASS, (0.0, 0.0, RADIUS), (0.0, 0.0, -speed))
    second = Body(RADIUS, MASS, (0.0, 0.0, -RADIUS))
    bodies, planes = ((first,), (FLOOR,)) if wall else ((first, second), ())
    return ContactScene(bodies, planes, law, step=time, steps=1)


def at(law, depth, *, wall=True, largest=0.0):
    system, flats = system_of(scene(law, wall), Rules()), 1.0 if wall else 2.0
    system.contacts[0]["largest"] = flats * largest
    return pressed(system.law, system.contacts[0], flats * depth)


def gap(x):
    """Return how deep an ellipse of the half axes R and 2 R is at x from its middle, g(x)."""
    return 2.0 * RADIUS - 2.0 * math.sqrt(RADIUS**2 - x**2)


def stored(a, depth):
    """Return the energy of springs, E' for each length, up to a, pressed in or pulled."""
    return 2.0 * quad(lambda x: 0.5 * PLANE_STRAIN * (depth - gap(x)) ** 2, 0.0, a, epsrel=1e-13)[0]


def force_of(a, depth):
    return 2.0 * quad(lambda x: PLANE_STRAIN * (depth - gap(x)), 0.0, a, epsrel=1e-13)[0]


@pytest.mark.parametrize("a", [2e-4, 4e-4, 8e-4])
def test_a_contact_that_peels_gives_the_energy_of_its_springs_for_the_area(a):
    """-dU/da at a fixed depth is 2 pi a gamma, the energy of the surface laid bare."""
    force, depth = contact.mdr_force_and_depth(GAMMA, PLANE_STRAIN, RADIUS, a)
    h = 1e-4 * a
    freed = (stored(a + h, depth) - stored(a - h, depth)) / (2.0 * h)
    assert freed == pytest.approx(2.0 * math.pi * a * GAMMA, rel=1e-5)
    assert force == pytest.approx(force_of(a, depth), rel=1e-9)
    for wall in (True, False):
        found = at(STICKS, depth, wall=wall, largest=1e-3)
        assert found.force == pytest.approx(force, rel=1e-9)
        assert found.radius == pytest.approx(a, rel=1e-9)


def test_as_it_opens_the_area_stays_until_the_springs_at_its_edge_are_too_long():
    largest = 1e-4
    a = math.sqrt(largest * (RADIUS - largest / 4.0))
    length = math.sqrt(2.0 * math.pi * a * GAMMA / PLANE_STRAIN)
    assert gap(a) == pytest.approx(largest, rel=1e-12)
    for part in (0.1, 0.5, 0.99):
        depth = largest - part * length
        found = at(STICKS, depth, largest=largest)
        assert (found.radius, found.force) == pytest.approx((a, force_of(a, depth)), rel=1e-9)
    beyond = at(STICKS, largest - 1.01 * length, largest=largest)
    assert beyond.radius < a
    assert at(STICKS, largest).force == pytest.approx(force_of(a, largest), rel=1e-9)


@pytest.mark.parametrize("depth", [-5e-7, 1e-6, 9.99e-5])
def test_the_slope_of_adhesion_is_that_of_the_force(depth):
    h = 1e-11
    ahead, behind = (at(STICKS, depth + s, largest=1e-4).force for s in (h, -h))
    told = at(STICKS, depth, largest=1e-4).slope
    assert told == pytest.approx((ahead - behind) / (2.0 * h), rel=1e-4)


def test_the_fold_is_where_the_depth_is_least():
    a, last = fold(PLANE_STRAIN, GAMMA, RADIUS)
    for other in (0.99 * a, 1.01 * a):
        g, length, _ = sunk(PLANE_STRAIN, GAMMA, RADIUS, other)
        assert g - length > last
    _, told = contact.mdr_pull_off(GAMMA, PLANE_STRAIN, RADIUS)
    assert last == pytest.approx(told, rel=1e-12)
    assert fold(PLANE_STRAIN, 0.0, RADIUS) == (0.0, 0.0)


def test_pulled_it_parts_at_the_fold_with_the_largest_tension_on_the_way():
    pull = (2000, ((0.0, 0.0, 6e-3)), (0.0, 0.0, 0.0))
    path = integrate(guided(STICKS, pull, overlap=1e-5))
    tension, last = contact.mdr_pull_off(GAMMA, PLANE_STRAIN, RADIUS)
    (end,) = path.of_kind("ends")
    assert end.overlap == pytest.approx(last, rel=1e-9)
    assert -path.forces[:, 0, 2].min() == pytest.approx(tension, rel=1e-5)


def test_an_impact_with_adhesion_loses_what_it_sticks_with():
    path = integrate(scene(STICKS, wall=True, speed=0.1))
    (turn,), (end,) = path.of_kind("turns"), path.of_kind("ends")
    largest = turn.overlap
    a = math.sqrt(largest * (RADIUS - largest / 4.0))
    peels = largest - math.sqrt(2.0 * math.pi * a * GAMMA / PLANE_STRAIN)

    def pulled(depth):
        return at(STICKS, depth, largest=largest).force

    work = quad(lambda d: at(STICKS, d).force, 0.0, largest, epsabs=0.0, epsrel=1e-10)[0]
    for ends in ((end.overlap, 0.0), (0.0, peels), (peels, largest)):
        work -= quad(pulled, *ends, epsabs=0.0, epsrel=1e-8, limit=500)[0]
    left = 0.01 - path.velocities[-1, 0, 2] ** 2
    assert 0.5 * MASS * left == pytest.approx(work, rel=1e-6)
    assert work > 0.0


@pytest.mark.parametrize("depth", [1e-5, 1e-3])
def test_the_bulk_answers_to_the_displaced_part_of_its_volume(depth):
    area = math.pi * RADIUS * depth
    outside = quad(lambda z: math.pi * (RADIUS**2 - z**2), -RADIUS, RADIUS - depth, epsrel=1e-13)[0]
    for wall in (True, False):
        found = at(RESPONDS, depth, wall=wall)
        assert found.force == pytest.approx(BULK * area * depth / outside * area, rel=1e-12)
    h = 1e-4 * depth
    slope = (at(RESPONDS, depth + h).force - at(RESPONDS, depth - h).force) / (2.0 * h)
    assert at(RESPONDS, depth).slope == pytest.approx(slope, rel=1e-6)


@pytest.mark.parametrize("wall", [True, False])
def test_a_slow_impact_on_the_bulk_is_one_on_a_cubic_spring(wall):
    """F = (3 pi / 4) K delta^3 / R for shallow depths: a quartic energy, Gamma functions."""
    flats, mass = (1.0, MASS) if wall else (2.0, MASS / 2.0)
    speed = 1e-3
    path = integrate(scene(RESPONDS, wall, speed, time=1.0))
    spring = 0.75 * math.pi * BULK / RADIUS / flats**3
    deepest = (2.0 * mass * speed**2 / spring) ** 0.25
    (turn,) = path.of_kind("turns")
    # the cap is 3/4 (delta / R)^2 of the volume
    shallow = (deepest / flats / RADIUS) ** 2
    assert turn.overlap == pytest.approx(deepest, rel=shallow)
    lasts = 2.0 * deepest / speed * math.sqrt(math.pi) * math.gamma(1.25) / math.gamma(0.75)
    assert path.contact_times()[0] == pytest.approx(lasts, rel=shallow)
    left = 1.0 if wall else 0.0  # the other sphere has it all
    assert path.velocities[-1, 0, 2] / speed == pytest.approx(left, abs=1e-9)


def test_a_wall_of_lammps_magnifies_every_branch():
    depth = 1e-4
    for law, largest in ((STICKS, 2e-4), (RESPONDS, 0.0)):
        system = system_of(scene(law, wall=True), Rules(wall_force="magnified"))
        system.contacts[0]["largest"] = largest
        more = pressed(system.law, system.contacts[0], depth)
        told = 1.0 + math.exp(10.7 * depth / RADIUS - 10.0)
        plain = at(law, depth, largest=largest)
        assert more.force / plain.force == pytest.approx(told, rel=1e-12)
        slope = told * plain.slope + (told - 1.0) * 10.7 / RADIUS * plain.force
        assert more.slope == pytest.approx(slope, rel=1e-12)


def test_the_bulk_of_a_sphere_between_plates_has_no_law_here():
    second = Plane((0.0, 0.0, 3.0 * RADIUS), (0.0, 0.0, -1.0))
    one = scene(RESPONDS, wall=True)
    with pytest.raises(RequestError, match="a bulk response takes one contact, not 2"):
        integrate(ContactScene(one.bodies, (FLOOR, second), RESPONDS, 1e-6, 1))
