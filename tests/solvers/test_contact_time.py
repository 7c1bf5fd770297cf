"""The duration of a first contact against closed forms, and the time until a sphere yields."""

import math

import pytest
from scipy.special import beta

from harness.errors import RequestError
from harness.model.law import Law
from harness.model.scene import Scene, Wall, sphere
from harness.solvers import reference
from harness.solvers.contact_time import before, contact_time, yield_time

RADIUS, DENSITY, SPEED, K = 0.01, 2500.0, 1.0, 1e5
MASS = sphere(RADIUS, DENSITY).mass
HERTZ = Law(normal="hertz", youngs_modulus=1e8, poisson_ratio=0.3)


def impact(law, velocity=(0.0, 0.0, -SPEED), partner=None, **more):
    """Return an impact at touch: on a wall, or on a sphere, free or frozen."""
    first = sphere(RADIUS, DENSITY, position=(0.0, 0.0, RADIUS), velocity=velocity)
    if partner is None:
        return Scene(bodies=(first,), walls=(Wall(),), law=law, step=1e-9, steps=1, **more)
    second = sphere(RADIUS, DENSITY, position=(0.0, 0.0, -RADIUS), motion=partner)
    return Scene(bodies=(first, second), law=law, step=1e-9, steps=1, **more)


@pytest.mark.parametrize(("partner", "share"), [(None, 1.0), ("frozen", 1.0), ("free", 0.5)])
@pytest.mark.parametrize("zeta", [0.0, 0.2, 0.9])
def test_linear_contact(partner, share, zeta):
    omega = math.sqrt(K / (share * MASS))
    found = contact_time(impact(Law.linear(K, zeta, clipped=False), partner=partner))
    assert found == pytest.approx(math.pi / omega / math.sqrt(1.0 - zeta**2), rel=1e-10)


@pytest.mark.parametrize("zeta", [0.3, 1.0, 1.5])
def test_clipped_contact_flies_from_the_vanishing_force_to_the_surface(zeta):
    """Until x = -2 zeta x' / omega, then with that speed: 2 zeta / omega more."""
    omega = math.sqrt(K / MASS)
    if zeta < 1.0:
        ends = 2.0 * math.acos(zeta) / math.sqrt(1.0 - zeta**2)
    else:
        root = math.sqrt(zeta**2 - 1.0)
        ends = 2.0 if zeta == 1.0 else 2.0 * math.acosh(zeta) / root
    found = contact_time(impact(Law.linear(K, zeta, clipped=True)))
    assert found == pytest.approx((ends + 2.0 * zeta) / omega, rel=1e-9)


def test_elastic_contact_of_hertz():
    coefficient = 4.0 / 3.0 * HERTZ.moduli[0] * math.sqrt(RADIUS)
    overlap = (1.25 * MASS * SPEED**2 / coefficient) ** 0.4
    expected = 0.8 * beta(0.4, 0.5) * overlap / SPEED
    assert contact_time(impact(HERTZ)) == pytest.approx(expected, rel=1e-11)


def test_elastic_contact_of_mdr_is_that_of_hertz_for_a_soft_touch():
    law = Law(normal="mdr", youngs_modulus=1e8, poisson_ratio=0.3)
    slow = (0.0, 0.0, -1e-4)
    pair, hertz = (impact(one, slow, "free") for one in (law, HERTZ))
    assert contact_time(pair) == pytest.approx(contact_time(hertz), rel=1e-5)
    # at a wall the sphere is on a rigid flat
    rigid = HERTZ.replace(youngs_modulus=2e8)
    expected = contact_time(impact(rigid, slow))
    assert contact_time(impact(law, slow)) == pytest.approx(expected, rel=1e-5)


def test_attraction_and_gravity_draw_a_contact_out():
    law, alone = HERTZ.replace(normal="dmt", surface_energy=0.5), contact_time(impact(HERTZ))
    draws = impact(law), impact(law.replace(normal="jkr")), impact(HERTZ, gravity=(0, 0, -9.81))
    assert min(map(contact_time, draws)) > alone
    with pytest.raises(RequestError, match=r"surface_energy = 0.5: the contact does not end"):
        contact_time(impact(HERTZ.replace(normal="jkr", surface_energy=0.5), (0.0, 0.0, -1e-3)))


@pytest.mark.parametrize("partner", ["free", "frozen"])
def test_spheres_that_turn_about_one_another_part_earlier(partner):
    """By less than the centrifugal impulse u^2 t / 2r over that of the impact, 2 v."""
    velocity = (SPEED, 0.0, -SPEED)
    law = Law.linear(K, 0.0, clipped=False)
    straight, turns = contact_time(impact(law, partner=partner)), impact(law, velocity, partner)
    less = 1.0 - contact_time(turns) / straight
    assert 0.0 < less < SPEED**2 * straight / (2.0 * RADIUS) / (2.0 * SPEED)
    steps = 20_000
    step = contact_time(turns) / steps
    scene = before(turns.replace(step=step, steps=steps + 50, every=1), 0.5 * step)
    force = reference.run(scene).force[:, 0]
    touching = [place for place in range(len(force)) if force[place].any()]
    assert touching[-1] - touching[0] + 1 == pytest.approx(steps, abs=1)


@pytest.mark.parametrize("partner", [None, "free"])
def test_a_sphere_yields_where_the_pressure_of_hertz_reaches_the_stress(partner):
    """4 E' / (3 pi) sqrt(d / R) = Y (1 + 1.75 exp(-4.4 d / R)) on each flat."""
    law = Law(normal="mdr", youngs_modulus=1e8, poisson_ratio=0.3, yield_stress=1e6)
    scene = impact(law, partner=partner)
    until = yield_time(scene)
    steps = 4000
    run = before(scene.replace(step=until / steps, steps=steps, every=1), 0.5 * until / steps)
    elastic = reference.run(run.replace(law=law.replace(yield_stress=None)))
    x = elastic.position[-1, :, 2]
    overlap = RADIUS - x[0] if partner is None else 2.0 * RADIUS - (x[0] - x[1])
    share = overlap / RADIUS / (1.0 if partner is None else 2.0)
    pressure = 4.0 * 2.0 * law.moduli[0] / (3.0 * math.pi) * math.sqrt(share)
    assert pressure == pytest.approx(1e6 * (1.0 + 1.75 * math.exp(-4.4 * share)), rel=1e-3)
    assert contact_time(scene) > 2.0 * until
    assert yield_time(impact(law.replace(yield_stress=1e12))) == math.inf
    assert yield_time(impact(HERTZ)) == math.inf
