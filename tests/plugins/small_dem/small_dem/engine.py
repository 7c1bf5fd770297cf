"""Velocity Verlet, linear spring and dashpot, in the plane: a small DEM."""

import time

import numba
import numpy as np

from harness.engines.contract import Engine, Output
from harness.engines.traits import Traits
from harness.errors import EngineNaNError
from harness.observables.provenance import Provenance


@numba.njit(cache=True)
def forces(x, v, mass, diameter, fixed, gravity, k, zeta, half, clipped, period):
    """Return the force (N, 2) on each particle: gravity and the contacts of all pairs."""
    f = mass.reshape(-1, 1) * gravity
    for i in range(len(x)):
        for j in range(i):
            dx, dy = x[i, 0] - x[j, 0], x[i, 1] - x[j, 1]
            if period > 0.0:
                dx -= period * np.round(dx / period)
            distance = np.hypot(dx, dy)
            overlap = 0.5 * (diameter[i] + diameter[j]) - distance
            if overlap <= 0.0 or (fixed[i] and fixed[j]):
                continue
            nx, ny = dx / distance, dy / distance
            m = mass[i] * mass[j] / (mass[i] + mass[j])
            if (fixed[i] or fixed[j]) and not half:
                m = mass[j] if fixed[i] else mass[i]
            parting = (v[i, 0] - v[j, 0]) * nx + (v[i, 1] - v[j, 1]) * ny
            push = k * overlap - 2.0 * zeta * np.sqrt(k * m) * parting
            push = max(push, 0.0) if clipped else push
            for p, sign in ((i, 1.0), (j, -1.0)):
                f[p, 0], f[p, 1] = f[p, 0] + sign * push * nx, f[p, 1] + sign * push * ny
    return f


@numba.njit(cache=True)
def advance(steps, h, x, v, f, mass, fixed, law):
    """Take steps in place; the dashpot feels the velocity of half a step ago, as in LAMMPS."""
    mobile = np.where(fixed, 0.0, 0.5 * h / mass).reshape(-1, 1)
    for _ in range(steps):
        v += mobile * f
        x += h * v
        f[:] = forces(x, v, *law)
        v += mobile * f


class SmallDem(Engine):
    """The small DEM: it takes any scene of spheres with linear springs."""

    name = "small-dem"
    traits = Traits(install_hint="pip install small-dem", versions=("1.0",),
                    integrator="velocity-verlet")  # fmt: skip

    def identify(self):
        """Return name and version."""
        return Provenance(self.name, "1.0", how="compiled", integrator="velocity-verlet")

    def run(self, jobs):
        """Run the scene of each job."""
        self.check(jobs)
        outputs = []
        for job in jobs:
            try:
                outputs.append(self.simulate(job.template.scene(job.values)))
            except EngineNaNError as error:
                outputs.append(error)
        return outputs

    def simulate(self, s):
        """Return the motion of a scene, a sample every so many steps."""
        started, every, samples, looks = time.perf_counter(), s.every or 50, [], 1
        x, v = s.position.copy(), s.velocity.copy()
        law = (s.mass, s.diameter, s.fixed, np.array(s.gravity), s.stiffness, s.damping_ratio,
               s.effective_mass == "half", s.tail == "clipped", s.period or 0.0)  # fmt: skip
        f = forces(x, v, *law)
        for step in range(0, s.steps + every, every):
            samples.append((step, x.copy(), v.copy(), f.copy()))
            table = self.table(samples, s.step) if len(samples) >= looks else {}
            looks *= 2 if table else 1
            if step >= s.steps or (table and s.decided and s.decided(table)):
                break
            advance(every, s.step, x, v, f, s.mass, s.fixed, law)
        if not np.isfinite(x).all():
            raise EngineNaNError("small-dem: a position is not a number")
        series = {"series": self.table(samples, s.step)}
        return Output((), self.identify(), series, seconds=time.perf_counter() - started)

    def table(self, samples, h):
        """Return the samples as columns."""
        step, x, v, f = (np.array(column, dtype=float) for column in zip(*samples, strict=True))
        return {"step": step, "time_s": step * h, "x_m": x[..., 0], "y_m": x[..., 1],
                "vx_m_per_s": v[..., 0], "vy_m_per_s": v[..., 1], "fx_N": f[..., 0]}  # fmt: skip
