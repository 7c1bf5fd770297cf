"""What a contact case may be told, and the one line that names what it may not."""

import math
from dataclasses import replace

import pytest

from harness.cases.contact.impact import impact
from harness.cases.contact.motion import TEMPLATE, job_of, values_of
from harness.cases.contact.parameters import ContactSystem
from harness.engines.lammps.engine import Lammps, variations
from harness.errors import RequestError
from harness.parameters.law import ContactLaw
from harness.parameters.scene import Body, ContactScene, Plane, Segment
from harness.parameters.submodels import PARTNER
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


@pytest.mark.parametrize("partner", ["wall", "sphere", "frozen"])
def test_every_value_of_a_job_has_its_variable_in_the_script(partner):
    scene = impact(USUAL.replace(partner=partner), (0.3, 0.0, -0.7), finely=True)
    job = job_of(scene, "current")
    script = Lammps.script(TEMPLATE, job.variant)
    assert set(job.values) <= script.variables
    # the rest is told by other views of the scene, and by variations of the run
    turned = {"walls_as", *(f"{name}_{axis}" for name in ("up", "drift") for axis in "xyz")}
    pair = job_of(impact(USUAL.replace(partner="sphere"), (0.3, 0.0, -0.7), finely=True), "current")
    ends = ((0.0, 0.0, 0.0), (1.0, 1.0, 1.0))
    hertz = replace(job, values={**job.values, "normal": "hertz"})
    jobs = (job, pair, hertz)
    varied = {name for one in jobs for told in variations(one, ends) for name in told.values}
    varied -= set(job.values)
    # of mdr, and of a second material, told where they are there
    branches = {"yield_stress", "bulk_response", *PARTNER}
    assert script.variables - set(job.values) == {"series"} | turned | varied | branches


LAW = ContactLaw()
FLOOR = Plane((0.0, 0.0, 0.0), (0.0, 0.0, 1.0))
BALL = Body(0.1, 1.0, (0.0, 0.0, 0.1))


@pytest.mark.parametrize(
    ("bodies", "planes", "words"),
    [
        ((BALL,) * 3, (), "bodies: scripts take one or two, got 3"),
        ((BALL,), (FLOOR, Plane((0.0, 0.0, 1.0), (1.0, 0.0, 1.0))), "planes: scripts take none"),
        ((BALL,), (FLOOR, FLOOR), "planes: scripts take none"),
    ],
)
def test_a_scene_that_scripts_have_no_words_for_is_refused(bodies, planes, words):
    with pytest.raises(RequestError, match=words):
        values_of(ContactScene(bodies, planes, LAW, step=1e-5, steps=10))


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


def test_scripts_are_told_of_the_branches_of_mdr_where_they_are_there():
    def told(**more):
        law = ContactLaw(normal="mdr", youngs_modulus=1e8, **more)
        body = Body(0.01, 0.01, (0.0, 0.0, 0.01))
        return values_of(ContactScene((body,), (), law, step=1e-6, steps=1))

    assert not {"yield_stress", "bulk_response"} & set(told())
    assert told(yield_stress=1e6)["yield_stress"] == 1e6
    assert told(bulk_response=True)["bulk_response"] == "yes"
    assert told(surface_energy=0.5)["surface_energy"] == 0.5


def test_a_moving_plane_and_two_bodies_that_are_led_are_refused():
    moving = replace(FLOOR, velocity=(1.0, 0.0, 0.0))
    with pytest.raises(RequestError, match="takes those at rest"):
        integrate(ContactScene((BALL,), (moving,), LAW, step=1e-5, steps=10))
    with pytest.raises(RequestError, match=r"velocity = .* three finite numbers"):
        replace(FLOOR, velocity=(math.nan, 0.0, 0.0))
    still, down = (0.0, 0.0, 0.0), (0.0, 0.0, -1.0)
    both = Segment(10, (down, down), (still, still))
    with pytest.raises(RequestError, match="scripts move one body"):
        values_of(ContactScene((BALL, BALL), (), LAW, step=1e-5, steps=10, segments=(both,)))
