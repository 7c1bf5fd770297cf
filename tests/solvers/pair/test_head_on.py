"""Head-on impacts of every normal law and damping against their closed forms."""

import math

import pytest
from scipy.optimize import brentq

from harness.parameters.law import ContactLaw
from harness.parameters.scene import Body, ContactScene
from harness.solvers.pair.integration import integrate
from harness.solvers.pair.normal import HERTZ as HERTZ_LAW
from harness.solvers.pair.normal import JKR, elastic
from harness.solvers.pair.system import effective_moduli
from harness.theory import contact
from tests.solvers.pair.scenes import MASS, RADIUS, STILL, impact

LINEAR = ContactLaw(normal_stiffness=1e6, damping="coeff_restitution", restitution=0.4)
HERTZ = ContactLaw(normal="hertz", youngs_modulus=7e9, damping="coeff_restitution", restitution=0.4)
MODULUS, _ = effective_moduli(HERTZ)


def rebound(law, speed=1.0):
    """Return the restitution and the path of an impact on the floor."""
    path = integrate(impact(law, (0.0, 0.0, -speed), time=2e-3))
    return path.velocities[-1, 0, 2] / speed, path


@pytest.mark.parametrize("clipped", [False, True])
@pytest.mark.parametrize("restitution", [1.0, 0.9, 0.1])
def test_a_linear_spring_with_its_dashpot(restitution, clipped):
    e, path = rebound(LINEAR.replace(restitution=restitution, clipped=clipped))
    zeta = contact.damping_ratio(restitution) if restitution < 1.0 else 0.0
    expected = contact.restitution_clipped(zeta) if clipped else restitution
    assert e == pytest.approx(expected, rel=1e-10)
    if clipped and zeta:
        free = path.of_kind("clips")[0].time * math.sqrt(1e6 / MASS)
        assert free == pytest.approx(contact.duration_clipped(zeta), rel=1e-10)


def test_velocity_and_mass_velocity_state_one_dashpot():
    eta = 2.0 * contact.damping_ratio(0.4) * math.sqrt(1e6 * MASS)
    for damping, value in (("velocity", eta), ("mass_velocity", eta / MASS)):
        law = LINEAR.replace(damping=damping, damping_coefficient=value)
        assert rebound(law)[0] == pytest.approx(0.4, rel=1e-10)


@pytest.mark.parametrize("speed", [0.01, 1.0, 30.0])
@pytest.mark.parametrize("restitution", [0.9, 0.4, 0.05])
def test_the_constant_restitution_of_hertz_at_every_speed(speed, restitution):
    e, _ = rebound(HERTZ.replace(restitution=restitution), speed)
    assert e == pytest.approx(restitution, rel=1e-10)


@pytest.mark.parametrize("clipped", [False, True])
def test_the_viscoelastic_dashpot(clipped):
    law = HERTZ.replace(damping="viscoelastic", damping_coefficient=5e6, clipped=clipped)
    k = contact.stiffness(MODULUS, RADIUS)
    relaxation = contact.relaxation(5e6, MASS, RADIUS, k)
    damping = relaxation / contact.largest_hertz_overlap(MASS, k, 1.0)
    expected = contact.impact(damping, clipped=clipped)
    # that integration has a tolerance of 1e-11
    assert rebound(law)[0] == pytest.approx(expected.restitution, rel=1e-9)


def test_unequal_spheres_without_damping():
    law = HERTZ.replace(damping="none")
    bodies = (
        Body(RADIUS, MASS, STILL, (0.0, 0.0, 0.5)),
        Body(3.0 * RADIUS, 27.0 * MASS, (0.0, 0.0, 4.0 * RADIUS), (0.0, 0.0, -0.5)),
    )
    path = integrate(ContactScene(bodies, (), law, 1e-5, 100, every=100))
    mass, radius = 27.0 / 28.0 * MASS, 0.75 * RADIUS
    k = contact.stiffness(MODULUS, radius)
    peak = path.of_kind("turns")[0]
    assert peak.overlap == pytest.approx(contact.largest_hertz_overlap(mass, k, 1.0), rel=1e-11)
    assert peak.force == pytest.approx(contact.largest_force(mass, k, 1.0), rel=1e-11)
    assert path.contact_times()[0] == pytest.approx(contact.contact_time(mass, k, 1.0), rel=1e-10)
    assert path.velocities[-1, :, 2] == pytest.approx([0.5 - 27.0 / 14.0, -0.5 + 1.0 / 14.0])


def test_the_contact_radius_of_jkr_by_root_finding():
    gamma, curvature = 5.0, 0.003
    c = math.sqrt(math.pi * gamma / MODULUS)
    fold = (0.25 * c * c * curvature**2) ** (1.0 / 3.0)
    for overlap in (-0.99 * 3.0 * fold**2 / curvature, 0.0, 1e-7, 1e-4):
        found = elastic(JKR, MODULUS, gamma, curvature, overlap)
        a = brentq(
            lambda a, x=overlap: a * a / curvature - 2.0 * c * math.sqrt(a) - x,
            fold,
            1e-2,
            xtol=1e-18,
            rtol=1e-14,
        )
        assert found.radius == pytest.approx(a, rel=1e-12)
        near = [elastic(JKR, MODULUS, gamma, curvature, overlap + d) for d in (-1e-13, 1e-13)]
        slope = (near[1].force - near[0].force) / 2e-13
        assert found.slope == pytest.approx(slope, rel=1e-3)
        assert found.growth == pytest.approx(
            math.log(near[1].radius / near[0].radius) / 2e-13, rel=1e-3
        )


def test_jkr_without_adhesion_is_hertz():
    bare = elastic(JKR, MODULUS, 1e-12, 0.01, 1e-5)
    assert bare.force == pytest.approx(elastic(HERTZ_LAW, MODULUS, 0.0, 0.01, 1e-5).force, rel=1e-6)
