"""The scheme step by step has the limit of the integration, and departs from it as it is told."""

from dataclasses import replace

import numpy as np
import pytest

from harness.parameters.law import ContactLaw
from harness.parameters.rules import Rules
from harness.parameters.scene import ZERO, Body, ContactScene, Plane, Segment
from harness.solvers.pair.integration import integrate
from harness.solvers.pair.stepping import Departures, NotSteppedError, advance

RADIUS, MASS = 0.01, 0.01
FLOOR = Plane((0.0, 0.0, 0.0), (0.0, 0.0, 1.0))
HERTZ = {"normal": "hertz", "youngs_modulus": 1e8, "poisson_ratio": 0.3}
MINDLIN = ContactLaw(
    **HERTZ,
    damping="viscoelastic",
    damping_coefficient=4e5,
    tangential="mindlin",
    tangential_damping=0.5,
    friction=0.5,
    rolling="sds",
    rolling_stiffness=2e4,
    rolling_damping=0.5,
    rolling_friction=0.05,
)


def impact(law, steps, speed=0.3):
    body = Body(RADIUS, MASS, (0.0, 0.0, RADIUS), (speed, 0.0, -1.0))
    return ContactScene((body,), (FLOOR,), law, step=2e-3 / steps, steps=steps, every=steps)


def dragged(law, steps, depth=1e-5, length=1e-4):
    body = Body(RADIUS, MASS, (0.0, 0.0, RADIUS - depth))
    piece = Segment(steps, ((length / 1e-3, 0.0, 0.0),), ((0.0, 0.0, 0.0),))
    return ContactScene(
        (body,), (FLOOR,), law, step=1e-3 / steps, steps=steps, every=1, segments=(piece,)
    )


def error(law, steps):
    scene = impact(law, steps)
    stepped, exact = advance(scene, Rules()), integrate(scene)
    return float(
        np.abs(stepped.velocities[-1] - exact.velocities[-1]).max()
        + RADIUS * np.abs(stepped.omegas[-1] - exact.omegas[-1]).max()
    )


@pytest.mark.parametrize("law", [MINDLIN, MINDLIN.replace(damping="none", tangential_damping=0.0)])
def test_its_limit_is_the_law_as_the_reference_integration_has_it(law):
    coarse, fine = error(law, 2_000), error(law, 32_000)
    assert fine < 1e-4
    # first order, for sliding begins within a step: 16, at whatever phase of it
    assert coarse > 5.0 * fine


def test_two_spheres_keep_their_momentum():
    upper = Body(RADIUS, MASS, (0.0, 0.0, RADIUS), (0.3, 0.1, -1.0), (5.0, 0.0, 20.0))
    lower = Body(2 * RADIUS, 8 * MASS, (0.0, 0.0, -2 * RADIUS))
    scene = ContactScene((upper, lower), (), MINDLIN, step=1e-6, steps=3_000, every=1_500)
    found = advance(scene, Rules())
    momenta = np.einsum("b,sbk->sk", [MASS, 8 * MASS], found.velocities)
    assert np.ptp(momenta, axis=0).max() < 1e-15
    assert abs(found.velocities[-1, 0, 2] - found.velocities[0, 0, 2]) > 0.1


@pytest.mark.parametrize("steps", [10_000, 40_000])
def test_a_spring_that_the_limit_leaves_without_radius_keeps_half_the_friction(steps):
    law = ContactLaw(
        **HERTZ, damping="none", tangential="mindlin", tangential_damping=0.0, friction=0.1
    )
    scene = dragged(law, steps)
    for departures, expected in ((Departures(), 1.0), (Departures(cap_without_radius=True), 0.5)):
        force = advance(scene, Rules(), departures).forces[steps // 2 :, 0]
        ratio = float(np.mean(-force[:, 0] / (0.1 * force[:, 2])))
        assert ratio == pytest.approx(expected, abs=0.03)


def test_a_spring_multiplied_by_the_contact_radius_is_as_much_weaker():
    law = ContactLaw(
        normal_stiffness=1e5, damping="none", tangential="linear_history", friction=100.0
    )
    scene = dragged(law, 1_000)
    plain = advance(scene, Rules()).forces[-1, 0, 0]
    weak = advance(scene, Rules(), Departures(tangential_radius=True)).forces[-1, 0, 0]
    assert weak / plain == pytest.approx(np.sqrt(RADIUS * 1e-5), rel=1e-12)


def test_a_restart_that_loses_springs_and_an_exchange_that_turns_them():
    law = MINDLIN.replace(damping="none", tangential_damping=0.0, rolling_damping=0.0)
    body = Body(RADIUS, MASS, (0.0, 0.0, RADIUS - 1e-5))
    pieces = (
        Segment(100, ((1e-3, 0.0, 0.0),), ((0.0, 3e-1, 0.0),)),
        Segment(100, ((0.0, 0.0, 0.0),), ((0.0, 0.0, 0.0),)),
    )
    scene = ContactScene((body,), (FLOOR,), law, step=1e-6, steps=200, every=100, segments=pieces)
    plain = advance(scene, Rules())
    lost = advance(scene, Rules(), Departures(restart="springs_lost"), stops=(100,))
    turned = advance(
        scene, Rules(), Departures(exchange="turning_springs_turned"), exchanges=(100,)
    )
    assert plain.forces[1, 0, 0] != 0.0
    assert lost.forces[2, 0, 0] == 0.0
    assert np.all(turned.forces[2] == plain.forces[2])
    lever = RADIUS * plain.forces[2, 0, 0]  # what the tangential spring adds, turned in neither
    assert turned.torques[2, 0, 1] + lever == pytest.approx(-(plain.torques[2, 0, 1] + lever))


def test_a_moving_wall_at_rest_in_the_setup_cuts_the_spring_back_and_only_there():
    law = ContactLaw(
        normal_stiffness=1e5, damping="none", tangential="linear_history", friction=0.3
    )
    still = dragged(law, 100, depth=1e-4, length=1e-5)
    speed = 1.0
    moved = replace(
        still,
        planes=(Plane(FLOOR.point, FLOOR.normal, (speed, 0.0, 0.0)),),
        segments=tuple(
            replace(piece, velocities=((piece.velocities[0][0] + speed, 0.0, 0.0),))
            for piece in still.segments
        ),
    )
    plain, other = advance(still, Rules()), advance(moved, Rules())
    assert np.abs(other.forces - plain.forces).max() < 1e-9
    assert np.abs(other.positions[-1, 0, 0] - plain.positions[-1, 0, 0]) == pytest.approx(1e-3)
    dashpot = moved.law.replace(
        damping="velocity", damping_coefficient=10.0, tangential_damping=1.0
    )
    # a setup in the middle: in the first there is no spring to be cut back
    halves = [
        replace(scene, law=dashpot, segments=(replace(scene.segments[0], steps=50),) * 2)
        for scene in (moved, still)
    ]
    cut = advance(halves[0], Rules(), Departures(setup="wall_at_rest"))
    whole = advance(halves[1], Rules())
    assert abs(cut.forces[-1, 0, 0] - whole.forces[-1, 0, 0]) > 0.1 * 0.3 * cut.forces[-1, 0, 2]


def test_a_law_that_remembers_more_than_springs_is_refused():
    law = ContactLaw(
        normal="mdr", youngs_modulus=1e8, poisson_ratio=0.3, yield_stress=1e6, damping="none"
    )
    with pytest.raises(NotSteppedError, match="mdr"):
        advance(impact(law, 100), Rules())


def test_a_dashpot_alone_beyond_the_limit_has_no_force_in_a_setup():
    law = MINDLIN.replace(damping_coefficient=4e7, rolling="none", rolling_stiffness=None,
                          rolling_damping=None, rolling_friction=None)  # fmt: skip
    run = advance(dragged(law, 100), Rules())
    load = run.forces[:, 0, 2]
    assert run.forces[0, 0, 0] == 0.0
    assert run.forces[1:, 0, 0] == pytest.approx(-0.5 * load[1:])


@pytest.mark.parametrize("back", [0.0, 1.0])
def test_a_limit_of_twisting_by_the_rate_is_lost_where_nothing_twists(back):
    law = ContactLaw(
        normal="hooke", normal_stiffness=1e5, tangential="linear_history", damping="none",
        tangential_stiffness=1e5, tangential_damping=0.0, friction=0.3, twisting="sds",
        twisting_stiffness=1.0, twisting_damping=0.0, twisting_friction=1e-4,
    )  # fmt: skip
    body = Body(RADIUS, MASS, (0.0, 0.0, RADIUS - 1e-4))
    still = (0.0, 0.0, 0.0)
    pieces = (
        Segment(100, (still,), ((0.0, 0.0, 40.0),)),
        Segment(10, ((0.0, 0.0, 1e-3),), ((0.0, 0.0, -1e-6 * back),)),
    )
    scene = ContactScene((body,), (FLOOR,), law, step=1e-6, steps=110, every=10, segments=pieces)
    by_rate = Departures(twisting_limit_by_rate=True)
    ends = [
        run.torques[-1, 0, 2] / (1e-4 * run.forces[-1, 0, 2])
        for run in (advance(scene, Rules()), advance(scene, Rules(), by_rate))
    ]
    assert ends == pytest.approx([-1.0, back], abs=1e-5)


@pytest.mark.parametrize("share", [-1.0, 0.5, 1.0])
def test_a_torque_of_rolling_in_the_setup_turns_a_sphere_for_half_a_step(share):
    depth = (MASS * 9.81 / (4.0 / 3.0 * 1e8 / (2.0 * (1.0 - 0.3**2)) * RADIUS**0.5)) ** (2.0 / 3.0)
    body = Body(RADIUS, MASS, (0.0, 0.0, RADIUS - depth), ZERO, (0.0, 1e-9, 0.0))
    scene = ContactScene(
        (body,), (FLOOR,), MINDLIN, step=1e-9, steps=1, every=1, gravity=(0.0, 0.0, -9.81)
    )
    runs = [advance(scene, Rules(), Departures(rolling_in_setup=s)) for s in (0.0, share)]
    spun = runs[1].omegas[-1, 0, 1] - runs[0].omegas[-1, 0, 1]
    limit = 0.05 * RADIUS * MASS * 9.81
    assert spun == pytest.approx(share * limit * 0.5e-9 / (0.4 * MASS * RADIUS**2), rel=1e-3)
