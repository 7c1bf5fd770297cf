"""The small DEM with contacts that rub: a sphere on a floor, spring, dashpot and friction."""

from dataclasses import replace

import numpy as np

from harness.engines.contract import Output
from harness.errors import Unsupported
from harness.model.conventions import Rules
from harness.model.scene import Wall
from small_dem.engine import SmallDem

LAW = {"normal": "hooke", "damping": "none velocity", "tangential": "none linear_history",
       "rolling": "none", "twisting": "none", "heat": "none", "interface": "current"}  # fmt: skip


def conventions(scene):
    """Return its conventions, the default ones; raise Unsupported for what it does not state."""
    for part, words in LAW.items():
        if getattr(scene.law, part) not in words.split():
            raise Unsupported(f"takes {part} = {words}, not {getattr(scene.law, part)}")
    if scene.law.clipped:
        raise Unsupported("does not clip")
    (body, *others), walls = scene.bodies, [wall.replace(point=(0, 0, 0)) for wall in scene.walls]
    if others or body.motion != "free" or walls != [Wall()] or scene.segments or scene.drag:
        raise Unsupported("takes one sphere on a floor at rest")
    return Rules()


class SmallContacts(SmallDem):
    """It takes the scenes of the small DEM, and those of one sphere on a floor."""

    name = "small-contacts"
    traits = replace(SmallDem.traits, conventions=conventions)

    def run(self, jobs):
        """Run the contacts with friction, and the scenes of the others."""
        self.check(jobs)
        outcomes = []
        for job in jobs:
            if job.scene is not None:
                series = {"series": simulate(values_of(job.scene))}
                outcomes.append(Output((), self.identify(), series))
            else:
                outcomes += super().run([job])
        return outcomes


def values_of(scene):
    """Return the law and the sphere of a scene as values by name."""
    (body,), (floor,) = scene.bodies, scene.walls
    values = {**dict(scene.law), "step_size": scene.step, "steps": scene.steps,
              "series_every": scene.every, "mass_1": body.mass, "radius_1": body.radius,
              "floor": floor.point[2]}  # fmt: skip
    vectors = {"": body.position, "v": body.velocity, "w": body.angular_velocity}
    for part, vector in vectors.items():
        values |= {f"{part}{axis}_1": x for axis, x in zip("xyz", vector, strict=True)}
    return values | {f"gravity_{axis}": g for axis, g in zip("xyz", scene.gravity, strict=True)}


def simulate(job):
    """Return the samples of a job: columns (M, 1), at the start and after every so many steps."""
    h, m, r, start = job["step_size"], job["mass_1"], job["radius_1"], job["floor"]
    x, v, w = (np.array([job[f"{part}{axis}_1"] for axis in "xyz"]) for part in ("", "v", "w"))
    g = np.array([job[f"gravity_{axis}"] for axis in "xyz"])
    up, stretch, samples = np.array([0.0, 0.0, 1.0]), np.zeros(3), []

    def forces(h):
        nonlocal stretch
        overlap, arm = r - (x[2] - start), -r * up
        if overlap <= 0.0:
            stretch = np.zeros(3)
            return np.zeros(3), np.zeros(3)
        eta = job["damping_coefficient"] if job["damping"] == "velocity" else 0.0
        normal = job["normal_stiffness"] * overlap - eta * v[2]
        along = np.zeros(3)
        if job["tangential"] == "linear_history":
            slip = v - v[2] * up + np.cross(w, arm)
            drag, k = job["tangential_damping"] * eta * slip, job["tangential_stiffness"]
            stretch = stretch + h * slip
            along = -k * stretch - drag
            limit = job["friction"] * abs(normal)
            if np.linalg.norm(along) > limit:
                # without a spring, as at the start, LAMMPS has no friction
                along *= limit / np.linalg.norm(along) if stretch.any() else 0.0
                stretch = -(along + drag) / k if h else stretch
        return normal * up + along, np.cross(arm, along)

    f, t = forces(0.0)
    for step in range(job["steps"] + 1):
        if step % job["series_every"] == 0:
            samples.append(np.concatenate([[step], x, v, w, f, t]))
        v, w = v + 0.5 * h * (f / m + g), w + 0.5 * h * t / (0.4 * m * r * r)
        x = x + h * v
        f, t = forces(h)
        v, w = v + 0.5 * h * (f / m + g), w + 0.5 * h * t / (0.4 * m * r * r)
    columns = [f"{part}{axis}{unit}" for part, unit in (("", "_m"), ("v", "_m_per_s"),
               ("w", "_rad_per_s"), ("f", "_N"), ("t", "_N_m")) for axis in "xyz"]  # fmt: skip
    table = np.array(samples)
    return {"step": table[:, 0], **{n: table[:, [i]] for i, n in enumerate(columns, 1)}}
