"""The small DEM with contacts that rub: a sphere on a floor, spring, dashpot and friction."""

from dataclasses import replace

import numpy as np

from harness.engines.contract import Output
from harness.engines.traits import ContactModel, takes
from small_dem.engine import SmallDem

LINEAR = takes("hooke", "none velocity", "none linear_history")
FLOOR = {"planes": (1,), "motion_1": ("free",), "clipped": ("no",), "walls_as": ("zplane",)}


class SmallContacts(SmallDem):
    """It takes the scenes of the small DEM, and contact jobs of one sphere on a floor."""

    name = "small-contacts"
    traits = replace(SmallDem.traits, contact_models=(ContactModel("linear", {**LINEAR, **FLOOR}),))

    @classmethod
    def states(cls, template):
        """Return whether it runs a template: one with a scene, and that of the contacts."""
        return template.name == "contacts" or super().states(template)

    def run(self, jobs):
        """Run the values of contact jobs, and the scenes of the others."""
        self.check(jobs)
        outcomes = []
        for job in jobs:
            if job.template.name == "contacts":
                series = {"series": simulate(job.values)}
                outcomes.append(Output((), self.identify(), series))
            else:
                outcomes += super().run([job])
        return outcomes


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
                along *= limit / np.linalg.norm(along)
                stretch = -(along + drag) / k
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
