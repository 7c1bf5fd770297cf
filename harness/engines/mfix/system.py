"""A scene in MFiX's terms: its step, its box, its particles, held ones on an outlet at rest.

MFiX has no keyword that holds a particle. It does take over the velocity of a particle within
a radius of a mass outflow, and no longer adds forces to it (``EXITING``; 21.3.2,
``mass_outflow_dem.f`` and ``cfnewvalues.f``): at an outflow of no velocity it stays. Two
things follow. It is taken over after the first step only, so that it is put where that step
brings it to its place. And it must come after the mobile ones in ``particle_input.dat``: the
neighbour search would count the contact twice otherwise (``desgrid_mod.f``). For the same
reason no boundary is cyclic: a grain that crosses one comes back behind the others.
The error of the first step falls with the third order.

The outflow is the floor of the box. So a scene's fixed particles must be level; particles in a
line along x stand upright in the box, x downward, and only the last may be fixed.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, replace
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from harness.errors import RequestError
from harness.parameters.law import Contact
from harness.parameters.scene import ContactScene

Scheme = Literal["EULER", "ADAMS_BASHFORTH"]
"""MFiX's names of its integrators (``DES_INTG_METHOD``)."""

REFERENCE: dict[Scheme, str] = {
    "EULER": "mfix-euler",
    "ADAMS_BASHFORTH": "mfix-adams-bashforth",
}
"""The reference DEM's names of them."""

FIRST_STEP: dict[Scheme, float] = {"EULER": 1.0, "ADAMS_BASHFORTH": 0.5}
"""The part of h a by which the first step's displacement h v + part h^2 a falls behind or ahead:
x+ = x + h (v + h a), and x + h/2 (v + v + h a)."""

LEAST_FACTOR = 10.0
"""What MFiX takes at least for ``DTSOLID_FACTOR`` (21.3.2, ``check_solids_dem.f``)."""


def steps_per_contact(factor: float, contact: Contact) -> float:
    """Return the steps per pi sqrt(m/k) that MFiX takes at a ``DTSOLID_FACTOR``.

    MFiX divides the duration of a damped contact, with m_eff = m/2 also against
    a fixed sphere, pi / sqrt(k/m_eff - (eta / (2 m_eff))^2), by the factor. With eta = 2 zeta
    sqrt(k m_eff) that is pi sqrt(m/k) / sqrt(2 (1 - zeta^2)): at e = 1e-20 it is ten times
    as long, and MFiX's default factor of 50 means 4.8 steps. Raise RequestError for a factor
    that is not positive, or a contact without such a duration (zeta >= 1) or without m/2.
    """
    if not (math.isfinite(factor) and factor > 0.0):
        raise RequestError(f"factor = {factor!r}: must be finite and greater than 0")
    return factor * _steps_of_factor_one(contact)


def factor(steps: float, contact: Contact) -> float:
    """Return the ``DTSOLID_FACTOR`` of so many steps per pi sqrt(m/k).

    The inverse of :func:`steps_per_contact`, with its errors. Raise RequestError below the
    10 that MFiX takes at least.
    """
    wanted = steps / _steps_of_factor_one(contact)
    if not wanted >= LEAST_FACTOR:
        least = LEAST_FACTOR * _steps_of_factor_one(contact)
        raise RequestError(
            f"steps_per_contact = {steps:g} is DTSOLID_FACTOR = {wanted:.4g} in MFiX, which takes "
            f"{LEAST_FACTOR:g} or more: must be at least {least:.4g} with this contact"
        )
    return wanted


def _steps_of_factor_one(contact: Contact) -> float:
    if contact.effective_mass != "half":
        raise RequestError(
            "effective_mass = 'full': MFiX takes half the mass, must be 'half' "
            "(--set contact.effective_mass=half, of critical-angle --half-mass)"
        )
    if contact.zeta >= 1.0:
        raise RequestError(
            f"damping ratio = {contact.zeta:g}: MFiX's contact time asks for less than 1"
        )
    return math.sqrt(2.0 * (1.0 - contact.zeta**2))


LIFT = 1e-12
"""[d] by which a particle over a row is lifted: where it just touches, rounding shall not make
an overlap, which the attractive tail would hold back."""

BEHIND, BEYOND = 1, 2
"""Spheres of a row behind its first one, and beyond where the last stage ends."""

EQUAL = 1e-9
"""Relative difference of masses, or diameters, that are equal."""


@dataclass(frozen=True)
class Sphere:
    """Position [m] and velocity [m/s] of a particle."""

    x: float
    y: float
    vx: float = 0.0
    vy: float = 0.0


class Layout(NamedTuple):
    """Mobile and held spheres, where the scene's origin is in the box, and the box."""

    mobile: tuple[Sphere, ...]
    held: tuple[Sphere, ...]
    origin: tuple[float, float]
    box: tuple[float, float]


def upright_line(scene: ContactScene, steps: int) -> Layout:
    """Return particles in a line, upright, the first on top, the last held or clear of the floor.

    The first particle's place is the origin.
    """
    if scene.fixed[:-1].any():
        raise RequestError("of particles in a line it holds the last alone")
    d, time, falls = float(scene.diameter[0]), steps * scene.step, max(scene.gravity[0], 0.0)
    along, velocity = scene.position[:, 0], scene.velocity[:, 0]
    if np.any(np.diff(along) <= 0.0):
        raise RequestError("particles in a line must come in order")
    speed = float(np.abs(velocity).max())
    fall = 0.0 if scene.fixed[-1] else speed * time + 0.5 * falls * time**2
    lowest = 0.5 * d if scene.fixed[-1] else 2.0 * d + fall
    top = lowest + float(along[-1] - along[0])
    spheres = tuple(
        Sphere(2.0 * d, top - float(x - along[0]), 0.0, 0.0 - float(v))
        for x, v in zip(along, velocity, strict=True)
    )
    count = np.count_nonzero(~scene.fixed)
    origin = (2.0 * d, top + float(along[0]))
    box = (4.0 * d, top + 2.0 * d + speed * time)
    return Layout(spheres[:count], spheres[count:], origin, box)


def over_a_row(scene: ContactScene) -> Layout:
    """Return a particle over a row that is long enough for the stages of a periodic one."""
    d, row = float(scene.diameter[0]), 0.5 * float(scene.diameter[0])
    if np.count_nonzero(~scene.fixed) != 1 or not scene.stages:
        raise RequestError(
            "it has no periodic row: a scene must say by its stages how far its particle goes"
        )
    x0, y0 = scene.position[1]
    end = max(stage.place for stage in scene.stages) - x0
    ahead = math.ceil(end / d * (1.0 - EQUAL)) + BEYOND
    first = (BEHIND + 1.5) * d
    x, y = (float(value) for value in scene.position[0] - scene.position[1])
    grain = Sphere(first + x, row + y + LIFT * d, *(float(v) for v in scene.velocity[0]))
    held = tuple(Sphere(first + i * d, row) for i in range(-BEHIND, ahead + 1))
    box = ((BEHIND + ahead + 3) * d, 6.0 * d)
    return Layout((grain,), held, (float(first - x0), float(row - y0)), box)


def over_spheres(scene: ContactScene, steps: int) -> Layout:
    """Return particles over level fixed ones, with room to fly about for the whole run."""
    d, time = float(scene.diameter[0]), steps * scene.step
    x0, y0 = (float(value) for value in scene.position[scene.fixed].min(axis=0))
    x, y = scene.position[:, 0] - x0, scene.position[:, 1] - y0
    speed = np.abs(scene.velocity).max(axis=0)
    pulls = 0.5 * np.maximum(np.array([abs(scene.gravity[0]), scene.gravity[1]]), 0.0) * time**2
    reach = float(speed[0] * time + pulls[0]) + 3.0 * d
    floor = 0.5 * d
    start = reach - min(float(x.min()), 0.0)
    top = floor + 2.0 * d + max(float(y.max()), d) + float(speed[1] * time + pulls[1])
    spheres = tuple(
        Sphere(start + float(x), floor + float(y), float(vx), float(vy))
        for x, y, (vx, vy) in zip(x, y, scene.velocity, strict=True)
    )
    count = np.count_nonzero(~scene.fixed)
    box = (float(np.ptp(x)) + 2.0 * reach, top)
    return Layout(spheres[:count], spheres[count:], (start - x0, floor - y0), box)


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
        if (nominal := self.contact.stated_restitution) is not None:
            return nominal
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


def system_of(
    name: str, scene: ContactScene, steps: int, every: int, scheme: Scheme = "EULER"
) -> System:
    """Return the system of the first ``steps`` of a scene, a frame every so many steps.

    Raise RequestError for a scene that MFiX cannot hold, or whose forces a scheme does not tell.
    """
    return replace(_in_box(name, scene, steps, every, scheme), scheme=scheme)


def _in_box(name: str, scene: ContactScene, steps: int, every: int, scheme: Scheme) -> System:
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
    name: str, scene: ContactScene, layout: Layout, steps: int, every: int, upright: bool = False
) -> System:
    gx, gy = scene.gravity
    return System(
        name=re.sub(r"\W", "_", name).upper()[:40],
        **layout._asdict(),
        diameter=float(scene.diameter[0]),
        mass=float(scene.mass[0]),
        stiffness=scene.stiffness,
        contact=scene.contact,
        gravity=(gy, -gx) if upright else (gx, gy),
        step=scene.step,
        steps=steps,
        every=every,
        upright=upright,
        forces=scene.forces,
    )


def _check(scene: ContactScene) -> None:
    for values, name in ((scene.diameter, "diameter"), (scene.mass, "mass")):
        if np.ptp(values) > EQUAL * values[0]:
            raise RequestError(f"its spheres have one {name}")
    if scene.spring != "linear":
        raise RequestError("its spring is linear")
    mobile = np.count_nonzero(~scene.fixed)
    if scene.fixed[:mobile].any():
        raise RequestError("its fixed particles must come last")
