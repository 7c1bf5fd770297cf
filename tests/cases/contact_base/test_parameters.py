"""What a contact case may be told, and the one line that names what it may not."""

import pytest

from harness.cases.contact.impact import impact
from harness.cases.contact.parameters import ContactSystem
from harness.solvers.pair.integration import integrate

USUAL = ContactSystem(tangential="linear_history", friction=0.3)


def test_two_spheres_share_mass_and_curvature():
    pair = USUAL.replace(partner="sphere", partner_radius=0.02)
    m = pair.mass
    assert pair.reduced_mass == pytest.approx(m * 8 * m / (9 * m))
    assert pair.reduced_radius == pytest.approx(0.01 * 0.02 / 0.03)
    assert USUAL.reduced_mass == USUAL.mass
    frozen = USUAL.replace(partner="frozen")
    assert (frozen.reduced_mass, frozen.reduced_radius) == (USUAL.mass, 0.005)


@pytest.mark.parametrize("partner", ["wall", "sphere", "frozen"])
def test_an_impact_touches_half_a_step_after_its_start(partner):
    scene = impact(USUAL.replace(partner=partner), (0.3, 0.0, -0.7), finely=False)
    first = scene.bodies[0]
    touch = [x + 0.5 * scene.step * v for x, v in zip(first.position, first.velocity, strict=True)]
    assert touch == pytest.approx([0.0, 0.0, 0.01], abs=1e-15)
    assert scene.steps == 1100
    assert scene.every == scene.steps


@pytest.mark.parametrize("partner", ["wall", "sphere"])
def test_a_sphere_yields_at_the_same_phase_of_a_step_on_every_rung(partner):
    told = {"normal": "mdr", "youngs_modulus": 1e8, "yield_stress": 1e6, "partner": partner}
    until = []
    for n in (50, 100, 400, 3200):
        system = ContactSystem(**told, steps_per_contact=n)
        scene = impact(system, (0.0, 0.0, -1.0), finely=True)
        path = integrate(scene)
        (yields,), (ends,) = path.of_kind("yields"), path.of_kind("ends")
        assert ends.time < scene.duration
        assert scene.step == pytest.approx(ends.time / (16 * n), rel=0.02)
        until.append(yields.time / scene.step)
    assert [steps % 1.0 for steps in until] == pytest.approx([0.5] * 4, abs=1e-6)
    assert until[1] - 0.5 == pytest.approx(2.0 * (until[0] - 0.5), rel=1e-9)
