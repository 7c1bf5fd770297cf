"""The systems as MFiX holds them: particles in a box, held ones on an outlet that stands still.

MFiX has no keyword that holds a particle. It does take over the velocity of a particle within
a radius of a mass outflow, and no longer adds forces to it (``EXITING``; 21.3.2,
``mass_outflow_dem.f`` and ``cfnewvalues.f``): at an outflow of no velocity it stays. Two
things follow. It is taken over after the first step only, so that it is put where that step
brings it to its place. And it must come after the mobile ones in ``particle_input.dat``: the
neighbour search would count the contact twice otherwise (``desgrid_mod.f``). For the same
reason no boundary is cyclic: a grain that crosses one comes back behind the others.
Read in MFiX's source, not run. What the first step costs falls with the third order.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from harness.cases.drop.parameters import Drop
from harness.cases.incline.parameters import Incline
from harness.cases.incline.routes import Start
from harness.engines.mfix.recorded import UNDAMPED
from harness.engines.mfix.step import factor
from harness.parameters.contact import Contact
from harness.parameters.tower import Tower

LIFT = 1e-12
"""[d] by which the grain of the incline is lifted: where it just touches, rounding shall not make
an overlap, which the attractive tail would hold back."""


@dataclass(frozen=True)
class Sphere:
    """Position [m] and velocity [m/s] of a particle."""

    x: float
    y: float
    vx: float = 0.0
    vy: float = 0.0


@dataclass(frozen=True)
class System:
    """A run of MFiX in SI units: spheres of one size, mobile ones first, in a box from (0, 0).

    ``origin`` is where the harness's origin is in the box; ``gravity`` has two components;
    ``steps`` are all, a frame is written every so many.
    """

    name: str
    mobile: tuple[Sphere, ...]
    held: tuple[Sphere, ...]
    origin: tuple[float, float]
    box: tuple[float, float]
    diameter: float
    density: float
    stiffness: float
    contact: Contact
    gravity: tuple[float, float]
    step: float
    steps: int
    every: int
    forces: bool = False

    @property
    def mass(self) -> float:
        """Return the mass [kg] of a sphere."""
        return self.density * math.pi / 6.0 * self.diameter**3

    @property
    def factor(self) -> float:
        """Return the ``DTSOLID_FACTOR`` of the step; raise RequestError where MFiX has none."""
        period = math.pi * math.sqrt(self.mass / self.stiffness)
        return factor(period / self.step, self.contact)

    @property
    def restitution(self) -> float:
        """Return the nominal restitution that states the contact's damping ratio."""
        if self.contact.damping_ratio is None and self.contact.restitution is not None:
            return self.contact.restitution
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
        return replace(sphere, vx=0.0 - ax * self.step, vy=0.0 - ay * self.step)


def incline_system(case: Incline, start: Start, wells: int, duration: float, every: int) -> System:
    """Return the grain on a row with room for so many wells, over ``duration`` [s]."""
    d, tilt = case.diameter, math.radians(case.angle)
    behind, ahead = 1, wells + 2
    row = 0.5 * d
    origin = ((behind + 1.5) * d, row)
    x, y, vx, vy = start.state()
    return System(
        name="INCLINE",
        mobile=(Sphere(origin[0] + x, origin[1] + y + LIFT * d, vx, vy),),
        held=tuple(Sphere(origin[0] + i * d, row) for i in range(-behind, ahead + 1)),
        origin=origin,
        box=((behind + ahead + 3) * d, 6.0 * d),
        diameter=d,
        density=case.density,
        stiffness=case.stiffness,
        contact=case.contact,
        gravity=(case.gravity * math.sin(tilt), -case.gravity * math.cos(tilt)),
        step=case.step,
        steps=every * math.ceil(duration / case.step / every * (1.0 - 1e-12)),
        every=every,
    )


def drop_system(case: Drop) -> System:
    """Return the grain above one held sphere."""
    d, time = case.diameter, case.steps * case.step
    half = 3.0 * d + abs(case.sideways) * time
    origin = (half, 0.5 * d)
    height = origin[1] + 3.0 * d + max(case.gap, 0.0) + abs(case.speed) * time
    return System(
        name="DROP",
        mobile=(Sphere(origin[0], origin[1] + d + case.gap, case.sideways, -case.speed),),
        held=(Sphere(*origin),),
        origin=origin,
        box=(2.0 * half, height),
        diameter=d,
        density=case.density,
        stiffness=case.stiffness,
        contact=case.contact,
        gravity=(0.0, -case.gravity),
        step=case.step,
        steps=case.steps,
        every=case.every,
    )


def tower_system(case: Tower, step: float, steps: int, every: int) -> System:
    """Return the tower, upright, the grain on top; its particles are equal.

    One step more than asked for: MFiX writes the forces of the step before.
    """
    (d, mass, k) = (case.each(name)[0] for name in ("diameter", "mass", "stiffness"))
    displaced = start_displacements(case)
    time = (steps + 1) * step
    fall = 0.0 if case.base == "fixed" else case.speed * time + 0.5 * case.gravity * time**2
    lowest = 0.5 * d if case.base == "fixed" else 2.0 * d + fall
    top = lowest + case.height * d + displaced[-1]
    spheres = [Sphere(2.0 * d, top - i * d - u) for i, u in enumerate(displaced)]
    spheres[0] = replace(spheres[0], vy=-case.speed)
    mobile = case.particles - (case.base == "fixed")
    return System(
        name="TOWER",
        mobile=tuple(spheres[:mobile]),
        held=tuple(spheres[mobile:]),
        origin=(2.0 * d, top),
        box=(4.0 * d, top + 2.0 * d + case.speed * time),
        diameter=d,
        density=mass * 6.0 / math.pi / d**3,
        stiffness=k,
        contact=UNDAMPED,
        gravity=(0.0, -case.gravity),
        step=step,
        steps=steps + 1,
        every=every,
        forces=True,
    )


def start_displacements(case: Tower) -> list[float]:
    """Return where the particles start [m], along the motion from where all just touch.

    Contact i of a preloaded tower carries the i - 1 particles between it and the grain,
    pressed in by their weight over k.
    """
    pressed = 0.0
    if case.start == "preloaded":
        pressed = case.each("mass")[0] * case.gravity / case.each("stiffness")[0]
    return [i * case.gap - 0.5 * i * (i - 1) * pressed for i in range(case.particles)]
