"""What the laws conserve, and what their rules do not."""

import dataclasses

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from harness.parameters.rules import Rules
from harness.solvers.pair.integration import integrate
from tests.solvers.pair.scenes import (
    ELASTIC,
    HERTZ,
    LINEAR,
    RADIUS,
    collision,
    impact,
    kinetic_energy,
    momentum,
)

CONSISTENT = [
    Rules(torque_lever=lever, velocity_lever=lever) for lever in ("contact_point", "radius")
]
HERTZ_ELASTIC = HERTZ.replace(
    damping="none", tangential="mindlin/force", tangential_damping=0.0, friction=100.0
)


def stored(path, law):
    """Return the energy of the linear springs of one contact [J]."""
    overlap = np.maximum(path.overlaps[:, 0], 0.0)
    shear = (path.springs[:, 0, 0] ** 2).sum(axis=1)
    return 0.5 * law.normal_stiffness * overlap**2 + 0.5 * shear / law.tangential_stiffness


@pytest.mark.parametrize("rules", CONSISTENT)
def test_energy_without_dissipation_where_velocity_and_torque_have_one_lever(rules):
    """Within the contact: what its spring holds as it ends is lost."""
    scene = collision(ELASTIC, time=2e-4, samples=10)
    path = integrate(scene, rules)
    assert not path.of_kind("slides", "ends")
    energy = kinetic_energy(scene, path) + stored(path, ELASTIC)
    assert energy == pytest.approx(energy[0], rel=1e-12)
    assert np.ptp(stored(path, ELASTIC)) > 0.1 * energy[0]


def test_two_levers_do_work_in_the_ratio_of_half_the_overlap_to_the_radius():
    """The slip is larger than what the torque works against by (omega_i + omega_j) overlap / 2."""
    scene = collision(ELASTIC, time=2e-4, samples=400)
    path = integrate(scene)
    energy = kinetic_energy(scene, path) + stored(path, ELASTIC)
    normal = np.diff(path.positions, axis=1)[:, 0]
    normal /= -np.linalg.norm(normal, axis=1)[:, None]
    spin = np.cross(path.omegas.sum(axis=1), normal)
    power = -(path.springs[:, 0, 0] * spin).sum(axis=1) * 0.5 * path.overlaps[:, 0]
    work = np.trapezoid(power, path.times)
    assert energy[-1] - energy[0] == pytest.approx(-work, rel=1e-4)
    assert abs(work) > 1e-6 * energy[0]


@pytest.mark.parametrize("law", [LINEAR, HERTZ, HERTZ_ELASTIC])
def test_momentum_and_angular_momentum_of_a_pair(law):
    scene = collision(law, samples=10)
    path = integrate(scene)
    for values in np.moveaxis(momentum(scene, path), 1, 0):
        size = np.abs(values).max()
        assert np.abs(values - values[0]).max() < 1e-13 * size
    assert len(path.contact_times()) == 1


def test_levers_of_the_full_radius_lose_angular_momentum():
    scene = collision(ELASTIC, time=2e-4)
    rules = Rules(torque_lever="radius", velocity_lever="radius")
    angular = momentum(scene, integrate(scene, rules))[:, 1]
    assert np.abs(angular[-1] - angular[0]).max() > 1e-6 * np.abs(angular).max()


@pytest.mark.parametrize("law", [LINEAR, HERTZ])
def test_a_wall_conserves_angular_momentum_about_its_points(law):
    """Forces of a plane act in it: m r v_x - I omega_y (and v_y) stay, by the lever r."""
    path = integrate(impact(law, (1.0, 0.5, -1.0), (30.0, 100.0, 200.0)))
    kept = path.velocities[:, 0, :2] + 0.4 * RADIUS * path.omegas[:, 0, 1::-1] * (1.0, -1.0)
    assert kept[-1] == pytest.approx(kept[0], rel=1e-13)
    assert path.omegas[-1, 0, 2] == pytest.approx(200.0, rel=1e-14)


@pytest.mark.parametrize("law", [LINEAR, HERTZ])
def test_turned_and_seen_from_a_moving_frame(law):
    scene = collision(law)
    path = integrate(scene)
    turn = Rotation.from_rotvec([0.7, -1.9, 0.4])
    drift = np.array([0.3, -0.2, 0.5])

    def moved(body):
        position, velocity, omega = turn.apply([body.position, body.velocity, body.omega])
        velocity = velocity + drift
        return dataclasses.replace(
            body, position=tuple(position), velocity=tuple(velocity), omega=tuple(omega)
        )

    other = integrate(dataclasses.replace(scene, bodies=tuple(map(moved, scene.bodies))))
    # positions lose digits against the overlap as the frame turns: 1e-16 of 0.03 m in 1e-4 m
    assert other.velocities[-1] - drift == pytest.approx(turn.apply(path.velocities[-1]), abs=1e-10)
    assert other.omegas[-1] == pytest.approx(turn.apply(path.omegas[-1]), abs=1e-8)


def test_renumbered():
    scene = collision(HERTZ)
    path = integrate(scene)
    other = integrate(dataclasses.replace(scene, bodies=scene.bodies[::-1]))
    assert other.velocities[-1, ::-1] == pytest.approx(path.velocities[-1], abs=1e-12)
    assert other.omegas[-1, ::-1] == pytest.approx(path.omegas[-1], abs=1e-10)
