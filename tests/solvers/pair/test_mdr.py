"""mdr's elastic branch: an ellipse that sinks into springs, Hertz's limit, walls, refusals."""

import math

import numpy as np
import pytest
from scipy.integrate import quad

from harness.cases.head_on import HeadOn
from harness.errors import RequestError
from harness.parameters.law import ContactLaw
from harness.parameters.rules import Rules
from harness.parameters.scene import Body, ContactScene
from harness.solvers.pair.integration import integrate
from harness.theory import contact
from tests.solvers.pair.scenes import FLOOR, MASS, RADIUS

YOUNG, NU = 1e8, 0.3
LAW = ContactLaw(normal="mdr", youngs_modulus=YOUNG, poisson_ratio=NU)
PLANE_STRAIN = YOUNG / (1.0 - NU**2)


def force(overlap, *, wall, rules=None):
    """Return the force of a sphere that is pressed into a floor, or into another as large."""
    first = Body(RADIUS, MASS, (0.0, 0.0, RADIUS - overlap))
    second = Body(RADIUS, MASS, (0.0, 0.0, -RADIUS), frozen=True)
    bodies, planes = ((first,), (FLOOR,)) if wall else ((first, second), ())
    path = integrate(ContactScene(bodies, planes, LAW, 1e-12, 1), rules)
    return path.forces[0, 0, 2]


def sunk(depth):
    """Return the force of springs, 2 E / (1 - nu^2) for a length of both sides, on an ellipse.

    Its half axes are R across and 2 R along the motion (Zunker and Kamrin 2024, A = 4 R, B = 2 R).
    """

    def spring(angle):  # x = R sin(angle): smooth at the edge
        edge = 1.0 - depth / (2.0 * RADIUS)
        sinking = 2.0 * RADIUS * (math.cos(angle) - edge)
        return PLANE_STRAIN * sinking * RADIUS * math.cos(angle)

    half = math.acos(1.0 - depth / (2.0 * RADIUS))
    return quad(spring, -half, half, epsabs=0.0, epsrel=1e-13)[0]


@pytest.mark.parametrize("depth", [1e-6, 1e-4, 1e-3, 5e-3])
def test_a_sphere_on_a_flat_is_an_ellipse_that_sinks_into_springs(depth):
    # the quadrature's own cos(angle) - edge has eps R over the depth
    assert force(depth, wall=True) == pytest.approx(sunk(depth), rel=1e-10 + 1e-16 * RADIUS / depth)
    assert force(2.0 * depth, wall=False) == pytest.approx(force(depth, wall=True), rel=1e-13)


def test_it_is_hertz_to_the_first_order_and_softer_by_three_eightieths_of_overlap_over_radius():
    """2 theta - sin 2 theta = 16/3 x^(3/2) (1 - 3/10 x ...), x = overlap / (8 R)."""
    for overlap in (1e-5, 2e-4):
        spring = contact.stiffness(PLANE_STRAIN / 2.0, RADIUS / 2.0)
        ratio = force(overlap, wall=False) / (spring * overlap**1.5)
        x = overlap / (8.0 * RADIUS)
        assert 1.0 - ratio == pytest.approx(0.3 * x, rel=x)
    # as was measured with LAMMPS of 22 Jul 2025: 14.641 N where Hertz has 14.652 N
    assert force(2e-4, wall=False) == pytest.approx(14.64102073, rel=1e-9)


def test_an_elastic_impact_gives_all_back_and_its_work_is_the_integral_of_the_force():
    ball = Body(RADIUS, MASS, (0.0, 0.0, RADIUS), (0.0, 0.0, -1.0))
    for rules in (Rules(), Rules(wall_force="magnified")):
        path = integrate(ContactScene((ball,), (FLOOR,), LAW, 1e-5, 100, every=100), rules)
        assert path.velocities[-1, 0, 2] == pytest.approx(1.0, rel=1e-12)
        (turn,) = path.of_kind("turns")
        work, _ = quad(lambda d, rules=rules: force(d, wall=True, rules=rules), 0.0, turn.overlap)
        assert work == pytest.approx(0.5 * MASS, rel=1e-8)


SECOND = 0.02
"""[m] radius of the larger of two unequal spheres."""


def flats(largest):
    """Return the depths [m] of the flat through the circle in which two unequal spheres cross."""
    apart = RADIUS + SECOND - largest
    place = (apart**2 + RADIUS**2 - SECOND**2) / (2.0 * apart)  # from the first centre
    return RADIUS - place, SECOND - (apart - place)


def between_unequal(overlap, largest):
    """Return the mean of the forces [N] on either side of the flat, by the springs of each."""
    depths = (depth * overlap / largest for depth in flats(largest))
    radii = (RADIUS, SECOND)
    # springs of one sphere of radius R at the depth d: R^2/r^2 times those of r at d r/R
    sides = (sunk(d * RADIUS / r) * (r / RADIUS) ** 2 for d, r in zip(depths, radii, strict=True))
    return 0.5 * sum(sides)


def unequal(overlap, speed=0.0, heavy=MASS):
    first = Body(RADIUS, MASS, (0.0, 0.0, RADIUS + SECOND - overlap), (0.0, 0.0, speed))
    return first, Body(SECOND, heavy, (0.0, 0.0, 0.0), frozen=True)


@pytest.mark.parametrize("overlap", [1e-6, 1e-4, 2e-3])
def test_unequal_spheres_take_the_mean_of_both_sides_of_the_flat_in_their_circle(overlap):
    path = integrate(ContactScene(unequal(overlap), (), LAW, 1e-12, 1))
    expected = between_unequal(overlap, overlap)
    assert path.forces[0, 0, 2] == pytest.approx(expected, rel=1e-9 + 1e-15 * RADIUS / overlap)
    reduced = RADIUS * SECOND / (RADIUS + SECOND)
    hertz = contact.stiffness(PLANE_STRAIN / 2.0, reduced) * overlap**1.5
    assert expected == pytest.approx(hertz, rel=overlap / RADIUS)


def test_unequal_spheres_come_back_along_another_curve_and_give_more_than_they_took():
    """The flat stays where it was at the largest overlap: its share of the overlap is kept."""
    scene = ContactScene(unequal(0.0, -5.0), (), LAW, 1e-6, 1600, every=1)
    path = integrate(scene)
    (turn,) = path.of_kind("turns")
    back = (path.times > turn.time) & (path.overlaps[:, 0] > 1e-5)
    assert back.sum() > 100
    overlaps, forces = path.overlaps[back, 0][::40], path.forces[back, 0, 2][::40]
    expected = [between_unequal(overlap, turn.overlap) for overlap in overlaps]
    np.testing.assert_allclose(forces, expected, rtol=1e-9)
    taken, given = (
        quad(lambda d, at=at: between_unequal(d, at or d), 0.0, turn.overlap, epsrel=1e-12)[0]
        for at in (0.0, turn.overlap)
    )
    assert taken == pytest.approx(0.5 * MASS * 25.0, rel=1e-9)
    returned = path.velocities[-1, 0, 2] / 5.0
    assert returned**2 - 1.0 == pytest.approx(given / taken - 1.0, rel=1e-4)
    assert returned > 1.0 + 1e-6


def test_a_contact_that_is_loaded_on_takes_up_the_curve_that_it_left():
    """Gravity presses again: past the largest overlap before, the flat moves on."""
    scene = ContactScene(
        unequal(1e-4, 0.6), (), LAW.replace(damping="velocity", damping_coefficient=2.0),
        1e-6, 3000, every=1, gravity=(0.0, 0.0, -2e4),
    )  # fmt: skip
    path = integrate(scene)
    assert path.of_kind("reloads")
    after = path.of_kind("reloads")[0].time
    one = int(np.argmax(path.times > after)) + 3
    overlap, closing = path.overlaps[one, 0], -path.velocities[one, 0, 2]
    assert closing > 0.0
    expected = between_unequal(overlap, overlap) + 2.0 * closing
    assert path.forces[one, 0, 2] == pytest.approx(expected, rel=1e-9)


def test_a_wall_of_lammps_pushes_harder():
    overlap = 2e-4
    more = force(overlap, wall=True, rules=Rules(wall_force="magnified"))
    told = 1.0 + math.exp(10.7 * overlap / RADIUS - 10.0)
    assert more / force(overlap, wall=True) == pytest.approx(told, rel=1e-13)
    pair = force(overlap, wall=False, rules=Rules(wall_force="magnified"))
    assert pair == force(overlap, wall=False)


def test_a_dashpot_adds_its_force():
    law = LAW.replace(damping="velocity", damping_coefficient=2.0)
    ball = Body(RADIUS, MASS, (0.0, 0.0, RADIUS - 1e-4), (0.0, 0.0, -1.0))
    path = integrate(ContactScene((ball,), (FLOOR,), law, 1e-12, 1))
    assert path.forces[0, 0, 2] == pytest.approx(force(1e-4, wall=True) + 2.0, rel=1e-13)
    assert np.all(path.torques == 0.0)


STIFF = LAW.replace(damping="mdr", damping_coefficient=0.25)


def bodies_of(system, overlap, speed):
    """Return bodies and planes of a sphere that meets a wall or another, and its reduced mass."""
    first = Body(RADIUS, MASS, (0.0, 0.0, RADIUS - overlap), (0.0, 0.0, -speed))
    if system == "wall":
        return (first,), (FLOOR,), MASS
    frozen = system == "frozen sphere"
    second = Body(RADIUS, MASS, (0.0, 0.0, -RADIUS), frozen=frozen)
    return (first, second), (), MASS if frozen else MASS / 2.0


SYSTEMS = ("wall", "two spheres", "frozen sphere")


@pytest.mark.parametrize("speed", [1.0, -0.5])
@pytest.mark.parametrize("overlap", [1e-6, 2e-4])
@pytest.mark.parametrize("system", SYSTEMS)
def test_a_dashpot_that_goes_with_the_stiffness_has_the_slope_of_the_force(system, overlap, speed):
    bodies, planes, reduced = bodies_of(system, overlap, speed)
    path = integrate(ContactScene(bodies, planes, STIFF, 1e-12, 1))
    # k = 2 E_eff a, a the edge of an ellipse 2 R deep and R wide; E_eff is twice as large at a wall
    depth = overlap if planes else 0.5 * overlap
    a = RADIUS * math.sqrt(1.0 - (1.0 - depth / (2.0 * RADIUS)) ** 2)
    k = 2.0 * PLANE_STRAIN * a / (1.0 if planes else 2.0)
    more = path.forces[0, 0, 2] - sunk(depth)
    # that of the quadrature of the elastic force
    within = 1e-16 * RADIUS / depth + 1e-9
    assert more == pytest.approx(0.25 * math.sqrt(reduced * k) * speed, rel=within)
    h = 1e-2 * overlap
    rise = (force(overlap + h, wall=bool(planes)) - force(overlap - h, wall=bool(planes))) / 2.0 / h
    assert k == pytest.approx(rise, rel=1e-4)  # a difference: k h^2/24 relative to overlap^2


@pytest.mark.parametrize("system", SYSTEMS)
def test_of_a_shallow_contact_it_returns_what_a_secant_dashpot_of_hertz_does(system):
    """k is 3/2 F/overlap there: eta_0 sqrt(3/2) = sqrt(5) zeta, a restitution whatever the speed.

    To the first order in overlap / R, below 1e-5, of which mdr is softer by less than a tenth.
    """
    bodies, planes, _ = bodies_of(system, 0.0, 1e-5)
    path = integrate(ContactScene(bodies, planes, STIFF, 3e-2, 1))
    last = path.velocities[-1, :, 2]
    returned = (last[0] - (last[1] if len(bodies) > 1 else 0.0)) / 1e-5
    zeta = 0.25 * math.sqrt(0.3)
    expected = math.exp(-math.pi * zeta / math.sqrt(1.0 - zeta**2))
    assert returned == pytest.approx(expected, rel=1e-6)


def test_the_magnified_wall_of_lammps_leaves_its_dashpot():
    bodies, planes, _ = bodies_of("wall", 2e-4, 1.0)
    rules = Rules(wall_force="magnified")
    found = [
        integrate(ContactScene(bodies, planes, STIFF, 1e-12, 1), one).forces[0, 0, 2]
        - force(2e-4, wall=True, rules=one)
        for one in (Rules(), rules)
    ]
    assert found[0] == pytest.approx(found[1], rel=1e-13)


@pytest.mark.parametrize(
    ("told", "message"),
    [
        (
            {"damping": "viscoelastic"},
            "damping = 'viscoelastic': needs normal = hooke, hertz, dmt or",
        ),
        ({"normal": "hertz", "damping": "mdr"}, "damping = 'mdr': needs normal = mdr"),
        (
            {"partner": "sphere", "partner_radius": 0.02, "damping": "mdr"},
            "partner_radius = 0.02: normal = mdr with yield, adhesion, a bulk response or damping",
        ),
        (
            {"partner": "sphere", "partner_radius": 0.02, "yield_stress": 1e6},
            "partner_radius = 0.02: normal = mdr with yield, adhesion, a bulk response or",
        ),
    ],
)
def test_what_it_is_not_stated_with_is_refused(told, message):
    more = {"damping_coefficient": 1.0} if told.get("damping") else {}
    with pytest.raises(RequestError, match=message):
        HeadOn(**{"normal": "mdr", "youngs_modulus": YOUNG, **told, **more})
