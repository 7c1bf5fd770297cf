"""A scene as MFiX holds it: particles in a box, held ones on an outlet that stands still.

MFiX has no keyword that holds a particle. It does take over the velocity of a particle within
a radius of a mass outflow, and no longer adds forces to it (``EXITING``; 21.3.2,
``mass_outflow_dem.f`` and ``cfnewvalues.f``): at an outflow of no velocity it stays. Two
things follow. It is taken over after the first step only, so that it is put where that step
brings it to its place. And it must come after the mobile ones in ``particle_input.dat``: the
neighbour search would count the contact twice otherwise (``desgrid_mod.f``). For the same
reason no boundary is cyclic: a grain that crosses one comes back behind the others.
What the first step costs falls with the third order.

The outflow is the floor of the box. So a scene's fixed particles must be level; particles in a
line along x stand upright in the box, x downward, and only the last may be fixed.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from harness.engines.mfix.layout import (
    EQUAL,
    Layout,
    Sphere,
    over_a_row,
    over_spheres,
    upright_line,
)
from harness.engines.mfix.step import FIRST_STEP, Scheme, factor
from harness.engines.scene import Scene
from harness.errors import RequestError
from harness.parameters.contact import Contact

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class System:
    """A run of MFiX in SI units: spheres of one size, mobile ones first, in a box from (0, 0).

    ``origin`` is where the scene's origin is in the box, ``upright`` says that the scene's x
    points downward in it; ``gravity`` has two components. ``steps`` are all, a frame is written
    every so many steps of the clock, which starts at ``first`` steps. ``forces``: frames of
    contact forces are written as well.
    """

    name: str
    mobile: tuple[Sphere, ...]
    held: tuple[Sphere, ...]
    origin: tuple[float, float]
    box: tuple[float, float]
    diameter: float
    mass: float
    stiffness: float
    contact: Contact
    gravity: tuple[float, float]
    step: float
    steps: int
    every: int
    upright: bool = False
    forces: bool = False
    scheme: Scheme = "EULER"

    @property
    def first(self) -> int:
        """Return the steps that the clock shows at the start.

        Forces are those of the step before a frame. With a clock that starts at ``every`` - 1
        frames are written after 1, 1 + ``every``, ... steps, whose forces acted in the states
        at 0, ``every``, ... steps.
        """
        return self.every - 1 if self.forces else 0

    @property
    def density(self) -> float:
        """Return the density [kg/m3] of a sphere."""
        return self.mass * 6.0 / math.pi / self.diameter**3

    @property
    def factor(self) -> float:
        """Return the ``DTSOLID_FACTOR`` of the step; raise RequestError where MFiX has none."""
        period = math.pi * math.sqrt(self.mass / self.stiffness)
        return factor(period / self.step, self.contact)

    @property
    def restitution(self) -> float:
        """Return the nominal restitution that states the contact's damping ratio."""
        if (stated := self.contact.stated_restitution) is not None:
            return stated
        zeta = self.contact.zeta
        return math.exp(-math.pi * zeta / math.sqrt(1.0 - zeta * zeta))

    @property
    def spheres(self) -> tuple[Sphere, ...]:
        """Return all spheres as MFiX reads them, held ones with what their first step takes."""
        return (*self.mobile, *(self._at_rest_after_a_step(sphere) for sphere in self.held))

    def _at_rest_after_a_step(self, sphere: Sphere) -> Sphere:
        """Return a held sphere with the velocity that gravity and contacts take in a step."""
        ax, ay = self.gravity
        eta = 2.0 * self.contact.zeta * math.sqrt(0.5 * self.stiffness * self.mass)
        for other in self.mobile:
            dx, dy = sphere.x - other.x, sphere.y - other.y
            distance = math.hypot(dx, dy)
            if distance < self.diameter:
                nx, ny = dx / distance, dy / distance
                approach = other.vx * nx + other.vy * ny
                push = self.stiffness * (self.diameter - distance) + eta * approach
                ax, ay = ax + push * nx / self.mass, ay + push * ny / self.mass
        part = FIRST_STEP[self.scheme] * self.step
        return replace(sphere, vx=0.0 - ax * part, vy=0.0 - ay * part)


def contact_in(scene: Scene) -> Contact:
    """Return the contact of a scene."""
    known = scene.restitution is not None
    return Contact(
        restitution=scene.restitution,
        damping_ratio=None if known else scene.damping_ratio,
        tail=scene.tail,
        effective_mass=scene.effective_mass,
    )


def system_of(name: str, scene: Scene, steps: int, every: int, scheme: Scheme = "EULER") -> System:
    """Return the system of the first ``steps`` of a scene, a frame every so many steps.

    Raise RequestError for a scene that MFiX cannot hold, or whose forces a scheme does not tell.
    """
    return replace(_in_box(name, scene, steps, every, scheme), scheme=scheme)


def _in_box(name: str, scene: Scene, steps: int, every: int, scheme: Scheme) -> System:
    _check(scene)
    if scene.forces and scheme != "EULER":
        # a frame has the forces of the step before: the state they belong to follows from it there
        raise RequestError(f"it tells the forces of a state in scheme EULER only, not in {scheme}")
    in_a_line = scene.mass.size > 1 and np.ptp(scene.position[:, 1]) == 0.0
    if in_a_line and scene.gravity[1] == 0.0 and not scene.velocity[:, 1].any():
        return _system(name, scene, upright_line(scene, steps + 1), steps + 1, every, upright=True)
    if scene.forces:
        raise RequestError("its forces are those of particles in a line")
    fixed = scene.position[scene.fixed]
    if not fixed.size or np.ptp(fixed[:, 1]) > 0.0:
        raise RequestError("it holds particles on the floor of its box: fixed ones must be level")
    if scene.period is None:
        return _system(name, scene, over_spheres(scene, steps), steps, every)
    steps = every * math.ceil(steps / every)
    return _system(name, scene, over_a_row(scene), steps, every)


def _system(
    name: str, scene: Scene, layout: Layout, steps: int, every: int, upright: bool = False
) -> System:
    gx, gy = scene.gravity
    return System(
        name=re.sub(r"\W", "_", name).upper()[:40],
        **layout._asdict(),
        diameter=float(scene.diameter[0]),
        mass=float(scene.mass[0]),
        stiffness=scene.stiffness,
        contact=contact_in(scene),
        gravity=(gy, -gx) if upright else (gx, gy),
        step=scene.step,
        steps=steps,
        every=every,
        upright=upright,
        forces=scene.forces,
    )


def _check(scene: Scene) -> None:
    """Raise RequestError for what no layout can hold."""
    for values, what in ((scene.diameter, "diameter"), (scene.mass, "mass")):
        if np.ptp(values) > EQUAL * values[0]:
            raise RequestError(f"its spheres have one {what}")
    if scene.spring != "linear":
        raise RequestError("its spring is linear")
    mobile = np.count_nonzero(~scene.fixed)
    if scene.fixed[:mobile].any():
        raise RequestError("its fixed particles must come last")
