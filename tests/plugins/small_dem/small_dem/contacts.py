"""The small DEM with contacts that rub: a sphere on planes, spring, dashpot and friction."""

from dataclasses import replace

import numpy as np

from harness.engines.contract import scenes_and_others
from harness.errors import EngineNaNError, Unsupported
from harness.model.conventions import Rules
from harness.model.motion import Motion
from harness.model.scene import Body, Scene, Wall
from small_dem.engine import SmallDem

SPHERE = ("radius", "mass", "inertia", "position", "velocity", "angular_velocity")
SCENE = ("law", "gravity", "step", "steps", "every")


def conventions(scene):
    """Return the conventions of a scene, LAMMPS's; raise Unsupported for what it cannot state."""
    law, walls = scene.law, [Wall(point=w.point, direction=w.direction) for w in scene.walls]
    ball = Body(**{name: getattr(scene.bodies[0], name) for name in SPHERE})
    if scene != Scene(bodies=[ball], walls=walls, **{name: getattr(scene, name) for name in SCENE}):
        raise Unsupported("it moves one free sphere on planes at rest, and has no drag or boundary")
    words = {law.damping, law.tangential, law.rolling, law.twisting, law.heat}
    if law.normal != "hooke" or words - {"none", "velocity", "linear_history"}:
        raise Unsupported("it has linear springs, a constant dashpot and friction alone")
    return Rules()


class SmallContacts(SmallDem):
    """It takes the scenes of the small DEM, and those of a sphere on planes."""

    name = "small-contacts"
    traits = replace(SmallDem.traits, conventions=conventions)

    def run(self, jobs):
        """Run scenes of spheres and walls here, and the other jobs in the small DEM."""
        self.check(jobs)
        return scenes_and_others(jobs, self.run_scene_jobs, super().run)

    def motions(self, jobs):
        """Return the motion of each scene, or the error in its place."""
        return [simulate(self.scene_of(job)) for job in jobs]


def simulate(scene):
    """Return the motion of a sphere, samples (M, 1, 3), or the error of its run."""
    ball, g, samples = scene.bodies[0], np.array([scene.gravity, np.zeros(3)]), []
    x, u = np.array(ball.position), np.array([ball.velocity, ball.angular_velocity])
    inertia = np.array([[ball.mass], [ball.moment_of_inertia]])
    stretches, load = np.zeros((len(scene.walls), 3)), np.zeros((2, 3))
    for step in range(scene.steps + 1):
        if step:
            u = u + 0.5 * scene.step * (load / inertia + g)
            x = x + scene.step * u[0]
        load = np.zeros((2, 3))  # force and torque
        for wall, stretch in zip(scene.walls, stretches, strict=True):
            load += plane_load(scene.law, ball.radius, x, u, wall, stretch, scene.step * (step > 0))
        if step:
            u = u + 0.5 * scene.step * (load / inertia + g)
        if step % scene.every == 0:
            samples.append((x, *u, *load))
    table = np.array(samples)
    if not np.isfinite(table).all():
        return EngineNaNError("small-contacts: a value is not a number")
    time = scene.step * scene.every * np.arange(len(table))
    return Motion(time, *(table[:, [part]] for part in range(5)))


def plane_load(law, radius, x, u, wall, stretch, h):
    """Return force and torque of a plane (2, 3); its spring grows in place for a time h."""
    (v, w), up = u, np.array(wall.direction)
    overlap, arm = radius - (x - wall.point) @ up, -radius * up
    if overlap <= 0.0:
        stretch[:] = 0.0
        return np.zeros((2, 3))
    eta, along = law.damping_coefficient or 0.0, np.zeros(3)
    normal = law.normal_stiffness * overlap - eta * (v @ up)
    normal = max(normal, 0.0) if law.clipped else normal
    if law.tangential == "linear_history":
        slip = v - (v @ up) * up + np.cross(w, arm)
        drag, k = law.tangential_damping * eta * slip, law.tangential_stiffness
        stretch += h * slip
        along = -k * stretch - drag
        if (size := np.linalg.norm(along)) > (limit := law.friction * abs(normal)):
            grown = stretch.any()  # before, no friction where a run begins, as in LAMMPS
            along *= limit / size * grown
            stretch[:] = -(along + drag) / k * grown
    return np.array([normal * up + along, np.cross(arm, along)])
