"""Velocity Verlet, linear spring and dashpot, spheres without friction: a small DEM."""

import numba
import numpy as np

from harness.engines.base import Engine, Traits
from harness.engines.output import Provenance
from harness.engines.scenes import decided, stages_of
from harness.errors import EngineNaNError, Unsupported
from harness.model.conventions import Rules
from harness.model.scene import LOOK, Motion


@numba.njit(cache=True)
def forces(f, x, v, radius, meets, k, eta, clipped, period):
    """Set the contact force (N, 3) on each sphere.

    ``meets`` (N, N) are the pairs that can touch, ``eta`` (N, N) their dashpots [kg/s].
    """
    f[:], apart = 0.0, np.zeros(3)
    for i in range(len(x)):
        for j in range(i):
            if not meets[i, j]:
                continue
            for axis in range(3):
                apart[axis] = x[i, axis] - x[j, axis]
            if period > 0.0:
                apart[0] -= period * np.floor(apart[0] / period + 0.5)
            distance = np.sqrt(apart[0] ** 2 + apart[1] ** 2 + apart[2] ** 2)
            overlap = radius[i] + radius[j] - distance
            if overlap <= 1e-15 * (radius[i] + radius[j]):
                continue
            push = k * overlap
            for axis in range(3):
                push -= eta[i, j] * (v[i, axis] - v[j, axis]) * apart[axis] / distance
            push = max(push, 0.0) if clipped else push
            for axis in range(3):
                f[i, axis] += push * apart[axis] / distance
                f[j, axis] -= push * apart[axis] / distance


@numba.njit(cache=True)
def advance(steps, h, x, v, f, mobility, g, law):
    """Take steps in place; the dashpot feels the velocity of half a step ago, as in LAMMPS."""
    for _ in range(steps):
        kick(0.5 * h, v, f, mobility, g)
        for i in range(len(x)):
            for axis in range(3):
                x[i, axis] += h * v[i, axis]
        forces(f, x, v, *law)
        kick(0.5 * h, v, f, mobility, g)


@numba.njit(cache=True)
def kick(h, v, f, mobility, g):
    """Change the velocities by a time h under forces (N, 3) and gravity (N, 3)."""
    for i in range(len(v)):
        for axis in range(3):
            v[i, axis] += h * (mobility[i] * f[i, axis] + g[i, axis])


class SmallDem(Engine):
    """The small DEM: it takes scenes of spheres with linear springs."""

    name = "small-dem"
    traits = Traits(install_hint="pip install small-dem", versions=("1.0",))

    def identify(self):
        """Return name and version."""
        return Provenance(self.name, "1.0", how="compiled", integrator="velocity-verlet")

    def rules(self, scene):
        """Return the conventions of a scene; raise Unsupported for what it cannot state."""
        law, axes = scene.law, [body.axes for body in scene.bodies]
        if scene.walls or scene.laws or scene.segments or scene.setups or scene.drag:
            raise Unsupported("it moves spheres by one law, without walls")
        if not np.all(axes) or scene.period[1:] != (None, None):
            raise Unsupported("its spheres move along all axes, and repeat along x alone")
        if law.normal != "hooke" or law.damping == "viscoelastic":
            raise Unsupported(
                "it has linear springs, and dashpots that do not grow with the overlap"
            )
        if {law.tangential, law.rolling, law.twisting, law.heat} != {"none"}:
            raise Unsupported("it has no friction, no rolling and no heat")
        return Rules(least_overlap=1e-15, looks_set_up=False)

    def motions(self, jobs):
        """Return the motion of each scene, or the error in its place."""
        return [simulate(self.scene_of(job)) for job in jobs]


def simulate(scene):
    """Return the motion of a scene, or the error of its run."""
    x, v = (np.array([getattr(body, name) for body in scene.bodies], dtype=float)
            for name in ("position", "velocity"))  # fmt: skip
    free = np.array([body.motion == "free" for body in scene.bodies])
    mobility = np.array([moves / b.mass for moves, b in zip(free, scene.bodies, strict=True)])
    g, radius = free[:, None] * np.array(scene.gravity), [body.radius for body in scene.bodies]
    law = (np.array(radius), partners(scene, free), scene.law.normal_stiffness, dashpots(scene),
           scene.law.clipped, scene.period[0] or 0.0)  # fmt: skip
    f = np.zeros_like(x)
    forces(f, x, v, *law)
    path, stages, checked = [(0, x.copy(), v.copy(), f.copy())], None, 1
    for step in stops(scene):
        advance(step - path[-1][0], scene.step, x, v, f, mobility, g, law)
        path.append((step, x.copy(), v.copy(), f.copy()))
        if scene.stages and (len(path) >= 2 * checked or step == scene.steps):
            checked = len(path)  # ever later: what is past its end is cut below
            stages = stages_in(scene, path)
            if decided(scene, stages):
                break
    last = scene.steps if stages is None else stages[-1, 0]
    path = [row for row in path if row[0] % scene.every == 0 and row[0] <= last]
    step, x, v, f = (np.array(column, dtype=float) for column in zip(*path, strict=True))
    if not np.isfinite(np.stack([x, v, f])).all():
        return EngineNaNError("small-dem: a value is not a number")
    still = np.zeros_like(x)
    return Motion(step * scene.step, x, v, still, f, still, None, stages)


def stops(scene):
    """Yield the steps after which the motion is sampled or looked at, and the last."""
    step, strides = 0, (scene.every, LOOK) if scene.stages else (scene.every,)
    while step < scene.steps:
        step = min(scene.steps, *(step - step % stride + stride for stride in strides))
        yield step


def stages_in(scene, path):
    """Return the stages of the first body so far."""
    step, x, v, _ = (np.array(column) for column in zip(*path, strict=True))
    return stages_of(scene, step, x[:, 0, :2], v[:, 0, :2])


def partners(scene, free):
    """Return which pairs (N, N) can touch: those that a scene names, or all; one must be free."""
    named = np.full((len(free), len(free)), scene.pairs is None)
    for i, j in scene.pairs or ():
        named[i, j] = named[j, i] = True
    return named & (free[:, None] | free[None, :])


def dashpots(scene):
    """Return eta [kg/s] of each pair: frozen masses are infinite, held ones their own."""
    inverse = np.array([(b.motion != "frozen") / b.mass for b in scene.bodies])
    sums = inverse[:, None] + inverse[None, :]
    masses = np.divide(1.0, sums, out=np.ones_like(sums), where=sums > 0.0)
    return np.array([[scene.law.dashpot(m, 1.0, 0.0) for m in row] for row in masses])
