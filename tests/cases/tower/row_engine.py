"""An engine of rows of particles under the overlap law, that stands in for real ones."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numba import njit

from harness.cases.tower.system import case_of
from harness.engines.contract import Engine, Output
from harness.engines.traits import Traits
from harness.observables.provenance import Provenance


class RowEngine(Engine):
    """Semi-implicit Euler, or velocity Verlet where its traits say so."""

    name = "row"
    title = "Row"
    traits = Traits(install_hint="pip install row", versions=("1",), integrator="velocity-verlet")

    def __init__(self, change=lambda case: case, spoil=lambda table, _: table):
        """Run ``change(case)`` in place of a case, and return ``spoil(table, case)``."""
        self.change, self.spoil, self.jobs = change, spoil, []

    def identify(self):
        return Provenance(self.name, "1", how="in-process")

    def run(self, jobs):
        self.check(jobs)
        self.jobs += jobs
        return [self._output(job.values) for job in jobs]

    def _output(self, values):
        asked = case_of(values)
        case, every = self.change(asked), values["series_every"]
        step = asked.contact_period / values["steps_per_contact"]
        steps = round(values["duration"] * asked.contact_time / step)
        half_kick = self.traits.integrator == "velocity-verlet"
        rate = case.each("stiffness")[0] / case.each("mass")[0]
        x, v, f = row_of_particles(
            case.particles, rate, case.gravity, case.speed, step, steps, every, half_kick
        )
        table = {
            "step": every * np.arange(len(x), dtype=float),
            "x_m": x + case.each("diameter")[0] * np.arange(case.particles),
            "vx_m_per_s": v,
            "contact_force_N": f * case.each("mass")[0],
        }
        spoiled = self.spoil(table, asked)
        if not isinstance(spoiled, dict):
            return spoiled
        return Output((), self.identify(), {"series": spoiled})


class Half(RowEngine):
    """Semi-implicit Euler, as MFiX."""

    name = "half"
    traits = replace(RowEngine.traits, integrator="mfix-euler")


@njit(cache=True)
def row_of_particles(particles, stiffness, gravity, speed, step, steps, every, half_kick):
    """Return displacements, velocities and forces (per mass) of an overlap row on a fixed base."""
    rows = steps // every + 1
    x, v, f = np.zeros(particles), np.zeros(particles), np.zeros(particles - 1)
    xs, vs = np.zeros((rows, particles)), np.zeros((rows, particles))
    fs = np.zeros((rows, particles - 1))
    v[0] = speed
    vs[0] = v
    share = 0.5 if half_kick else 1.0
    for i in range(1, steps + 1):
        for j in range(particles - 1):
            v[j] += share * step * (gravity + (f[j - 1] if j else 0.0) - f[j])
        x += step * v
        for j in range(particles - 1):
            f[j] = stiffness * max(x[j] - x[j + 1], 0.0)
        if half_kick:
            for j in range(particles - 1):
                v[j] += share * step * (gravity + (f[j - 1] if j else 0.0) - f[j])
        if i % every == 0:
            xs[i // every], vs[i // every], fs[i // every] = x, v, f
    return xs, vs, fs
