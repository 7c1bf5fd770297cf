"""Parameters of two spheres, or a sphere and a plane, in contact by one law, and their scales.

The scales bound where a contact case has a meaning. Overlaps: coordinates of spheres are rounded,
so that too small an overlap is not resolved; and from the smaller radius on the centre is beyond
the surface of the partner. Steps: velocity Verlet is off by (rate times step)^2 / 24 in the phase
of an oscillation, and unstable from 2 on.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Callable, Iterator
from typing import Annotated, Any, Literal, Self

from pydantic import Field, model_validator

from harness.errors import RequestError
from harness.parameters.law import ContactLaw
from harness.parameters.scene import Body, ContactScene, Plane, Vector, sphere_mass
from harness.theory import contact

Partner = Literal["wall", "sphere", "frozen"]
Interface = Literal["current", "old"]
Materials = Literal["stated", "mixed"]

Radius = Annotated[float, Field(ge=1e-9, le=1e3)]
"""[m]: an atom is smaller, a mountain larger."""

Density = Annotated[float, Field(ge=1e-3, le=1e9)]
"""[kg/m3]: from less than a gas to that of a white dwarf."""

Speed = Annotated[float, Field(ge=1e-9, le=1e9)]
"""[m/s]: up to that of light, where the mechanics of all this ends."""

Turning = Annotated[float, Field(ge=1e-9, le=1e9)]
"""[rad/s]: a turn in two centuries, and what tears everything."""

Gravity = Annotated[float, Field(ge=1e-9, le=1e9)]
"""[m/s2]"""

Duration = Annotated[float, Field(ge=1e-3, le=1e9)]
"""In units of the case."""

OLD = {
    "hooke": (("none", "mass_velocity"), ("none", "linear_nohistory", "linear_history_classic")),
    "hertz": (("none", "viscoelastic"), ("none", "mindlin_classic")),
}
"""Dampings and tangential forces of the old contact styles, by the normal force."""

FLOOR = Plane((0.0, 0.0, 0.0), (0.0, 0.0, 1.0))


class ContactSystem(ContactLaw):
    """The first sphere, what it meets, and how finely the contact is resolved."""

    partner: Partner = Field(
        "wall", description="[-] what the sphere meets: a wall, a free or a frozen sphere"
    )
    radius: Radius = Field(0.01, description="[m] of the sphere")
    partner_radius: Radius | None = Field(
        None, description="[m] of the sphere that it meets; as large unless given"
    )
    density: Density = Field(2500.0, description="[kg/m3] of the spheres")
    partner_density: Density | None = Field(
        None, description="[kg/m3] of the sphere that it meets; as dense unless given"
    )
    materials_as: Materials = Field(
        "stated",
        description="[-] stated: an engine gets the one material that stands for two in contact; "
        "mixed: it gets both, and mixes them",
    )
    interface: Interface = Field(
        "current", description="[-] old: an engine's earlier contact styles, where it has some"
    )
    steps_per_contact: int = Field(
        1000,
        ge=10,
        le=10**7,
        description="[-] steps of the time that the contact takes; of a sixteenth of it where mdr "
        "yields or its bulk responds",
    )

    @model_validator(mode="after")
    def _check_stated(self) -> Self:
        if self.partner == "wall" and self.partner_radius is not None:
            raise ValueError(
                f"partner_radius = {self.partner_radius!r}: partner = 'wall' has none "
                "(partner = sphere, frozen does)"
            )
        if self.partner == "wall" and self.partner_density is not None:
            raise ValueError(
                f"partner_density = {self.partner_density!r}: partner = 'wall' has none "
                "(partner = sphere, frozen does)"
            )
        if self.materials_as == "mixed" and not self.two_materials:
            raise ValueError(
                "materials_as = 'mixed': needs two materials (partner_youngs_modulus or "
                "partner_poisson_ratio)"
            )
        if (
            (self.lags or self.surface_energy or self.damping == "mdr")
            and self.normal == "mdr"
            and (self.second_radius != self.radius)
        ):
            raise ValueError(
                f"partner_radius = {self.partner_radius!r}: normal = mdr with yield, adhesion, a "
                "bulk response or damping = mdr takes spheres of one size"
            )
        if self.interface == "old":
            dampings, tangentials = OLD.get(self.normal, ((), ()))
            further = self.rolling != "none" or self.twisting != "none"
            if further or self.damping not in dampings or self.tangential not in tangentials:
                allowed = "; ".join(f"{n}: {', '.join((*d, *t))}" for n, (d, t) in OLD.items())
                raise ValueError(f"interface = 'old': states these submodels only: {allowed}")
        self.check()
        return self

    def check(self) -> None:
        """Raise ValueError for values of a case that have no meaning together."""

    @property
    def mass(self) -> float:
        """Return the sphere's mass [kg]."""
        return sphere_mass(self.radius, self.density)

    @property
    def second_radius(self) -> float:
        """Return the radius of the sphere that it meets [m]."""
        return self.radius if self.partner_radius is None else self.partner_radius

    @property
    def reduced_mass(self) -> float:
        """Return m* [kg]: m against a wall or a frozen sphere."""
        if self.partner != "sphere":
            return self.mass
        return self.mass * self.second_mass / (self.mass + self.second_mass)

    @property
    def second_mass(self) -> float:
        """Return the mass of the sphere that it meets [kg]."""
        density = self.density if self.partner_density is None else self.partner_density
        return sphere_mass(self.second_radius, density)

    @property
    def reduced_radius(self) -> float:
        """Return R* [m]: r against a wall."""
        if self.partner == "wall":
            return self.radius
        return self.radius * self.second_radius / (self.radius + self.second_radius)

    @property
    def planes(self) -> tuple[Plane, ...]:
        """Return the wall that it meets, z = 0, or nothing."""
        return (FLOOR,) if self.partner == "wall" else ()

    def bodies(self, gap: float, velocity: Vector, omega: Vector = (0.0, 0.0, 0.0)) -> list[Body]:
        """Return the sphere, ``gap`` [m] above z = 0, and the one that it meets, at rest below."""
        first = Body(self.radius, self.mass, (0.0, 0.0, self.radius + gap), velocity, omega)
        if self.partner == "wall":
            return [first]
        r = self.second_radius
        second = Body(r, self.second_mass, (0.0, 0.0, -r), frozen=self.partner == "frozen")
        return [first, second]


def reduced_modulus(parameters: ContactLaw) -> float:
    """Return E* [Pa] of two bodies: 1/E* is the sum of (1 - nu^2) / E."""
    assert parameters.materials is not None
    (young, poisson), (other, its) = parameters.materials
    if not parameters.two_materials:
        return young / 2.0 / (1.0 - poisson**2)
    return young * other / (other * (1.0 - poisson**2) + young * (1.0 - its**2))


def reduced_shear_modulus(parameters: ContactLaw) -> float:
    """Return G* [Pa] of two bodies: 1/G* is the sum of (2 - nu) / G, G = E / (2 (1 + nu))."""
    assert parameters.materials is not None
    (young, poisson), (other, its) = parameters.materials
    if not parameters.two_materials:
        return young / 4.0 / (1.0 + poisson) / (2.0 - poisson)
    shear, another = young / 2.0 / (1.0 + poisson), other / 2.0 / (1.0 + its)
    return shear * another / (another * (2.0 - poisson) + shear * (2.0 - its))


def one_material(parameters: ContactLaw) -> tuple[float, float]:
    """Return E [Pa] and nu of the one material that has E* and G* of two in contact.

    Two equal bodies have r = G*/E* = (1 - nu) / (2 (2 - nu)), hence nu = (1 - 4 r) / (1 - 2 r),
    and E = 2 (1 - nu^2) E*. For 1/r of a pair is a mean of those of both materials, nu lies
    between theirs; of one Poisson's ratio E = 2 E_1 E_2 / (E_1 + E_2).
    """
    modulus = reduced_modulus(parameters)
    ratio = reduced_shear_modulus(parameters) / modulus
    poisson = (1.0 - 4.0 * ratio) / (1.0 - 2.0 * ratio)
    return 2.0 * (1.0 - poisson**2) * modulus, poisson


def hertz_spring(parameters: ContactSystem) -> float:
    """Return K of Hertz's force K overlap^(3/2) [N/m^(3/2)]."""
    return contact.stiffness(reduced_modulus(parameters), parameters.reduced_radius)


SMOOTH = 1e-6
"""Of a quantity's size: the width of a limit where the law is smooth over the run."""

SHALLOWEST = 4.0 * sys.float_info.epsilon / SMOOTH
"""Of the radii: both coordinates are rounded, before and after a step, to eps each; what they are
off by is then a millionth of the overlap, the width of a limit."""

STRONGEST = contact.damping_ratio(SMOOTH)
"""Damping ratio whose restitution, for a linear spring, is no more than the width of a limit."""

COARSEST = 0.5
"""Rate times step: off by 1 % in the phase, a quarter of what is unstable."""

MOST_STEPS = 10**9
"""Of a run: a quarter of an hour where a step takes a microsecond, which none does."""

DEEPEST = 0.25
"""[radius] of a flat in a sphere that yields: its law has been fitted for shallow ones."""

FLAT_WITHIN = 0.75
"""[R] depth of mdr's flat between unequal spheres beyond which LAMMPS moves it."""
WIDEST = 1e6
"""Ratio of two radii: leaves three decades between the smallest overlap and the largest."""


def between(name: str, value: float, unit: str, limits: tuple[float, float], why: str) -> None:
    """Raise ValueError for a value that is not within limits, in words that name all of it."""
    low, high = limits
    if not low <= value <= high:
        text = f"{name} = {value!r} {unit}".rstrip()
        raise ValueError(f"{text}: must be between {low:.4g} and {high:.4g} here: {why}")


def overlaps(parameters: ContactSystem) -> tuple[float, float]:
    """Return the smallest and the largest overlap that have a meaning [m].

    Raise ValueError for radii too far apart, and for an attraction that needs a larger one: the
    area of JKR at no load, a^3 = 9 pi gamma R*^2 / E*, must be within R*.
    """
    r, other = parameters.radius, parameters.second_radius
    between(
        "partner_radius", other, "m", (r / WIDEST, r * WIDEST), "the radii are too far apart"
    )  # fmt: skip
    if parameters.surface_energy:
        most = reduced_modulus(parameters) * parameters.reduced_radius / 9.0 / math.pi
        between(
            "surface_energy", parameters.surface_energy, "J/m2", (0.0, most),
            "the area of contact without a load must be smaller than the reduced radius",
        )  # fmt: skip
    sizes = (r,) if parameters.partner == "wall" else (r, other)
    most = FLAT_WITHIN if parameters.normal == "mdr" and len(set(sizes)) > 1 else 1.0
    return SHALLOWEST * sum(sizes), most * min(sizes)


def meets(parameters: ContactSystem, *partners: str) -> None:
    """Raise ValueError for something that the sphere of a case does not meet."""
    if parameters.partner not in partners:
        allowed = ", ".join(partners)
        raise ValueError(f"partner = {parameters.partner!r}: must be one of {allowed} in this case")


WHY_OVERLAP = "the overlap must be above the round-off of coordinates and below the smaller radius"


def pressed(
    parameters: ContactSystem, name: str, unit: str, overlap: float, power: float = 1.0
) -> None:
    """Raise ValueError for a parameter that gives an overlap [m] without a meaning.

    The overlap goes with its ``power``.
    """
    value, (least, most) = getattr(parameters, name), overlaps(parameters)
    if not least <= overlap <= most:
        limits = [value * (bound / overlap) ** (1.0 / power) for bound in (least, most)]
        between(name, value, unit, (limits[0], limits[1]), WHY_OVERLAP)


def energy(parameters: ContactSystem, overlap: float) -> float:
    """Return the elastic energy of an overlap [J]."""
    if parameters.normal_stiffness is not None:
        return 0.5 * parameters.normal_stiffness * overlap * overlap
    stored: float = 0.4 * hertz_spring(parameters) * overlap**2.5
    return stored


def stiffness(parameters: ContactSystem, overlap: float) -> float:
    """Return the slope of the elastic force at an overlap [N/m]."""
    k = parameters.normal_stiffness
    return 1.5 * hertz_spring(parameters) * math.sqrt(overlap) if k is None else k


def rests(parameters: ContactSystem, gravity: float) -> None:
    """Raise ValueError for a sphere that gravity along the normal [m/s2] presses in too far.

    Or so little that it is not resolved. ``gravity`` is that part of the parameter.
    """
    power = 2.0 / 3.0 if parameters.normal_stiffness is None else 1.0
    load = parameters.mass * gravity
    pressed(parameters, "gravity", "m/s2", rest_overlap(parameters, load), power)


def rest_overlap(parameters: ContactSystem, load: float) -> float:
    """Return the overlap under a load [N] at rest [m]; attraction is not taken into account."""
    if parameters.normal_stiffness is not None:
        return load / parameters.normal_stiffness
    overlap: float = (load / hertz_spring(parameters)) ** (2.0 / 3.0)
    return overlap


def dashpots(parameters: ContactSystem, overlap: float) -> float:
    """Return eta_n at an overlap [kg/s]; for one of a restitution that of a linear spring."""
    mass = parameters.reduced_mass
    spring = math.sqrt(mass * stiffness(parameters, overlap))
    if parameters.restitution is not None:
        return 2.0 * contact.damping_ratio(parameters.restitution) * spring
    return parameters.dashpot.eta(
        parameters.damping_coefficient or 0.0,
        mass=mass,
        radius=_contact_radius(parameters, overlap),
        stiffness=stiffness(parameters, overlap),
    )


def elastic_force(parameters: ContactSystem, overlap: float) -> float:
    """Return the elastic force of hooke or hertz at an overlap [N]."""
    power = 1.0 if parameters.normal_stiffness is not None else 1.5
    return stiffness(parameters, overlap) * overlap / power


def twisting_limit(parameters: ContactSystem, overlap: float) -> float:
    """Return the largest torque about the normal over the normal force [m]; Marshall's 2/3 a mu.

    0 where nothing resists twisting.
    """
    if parameters.twisting == "marshall":
        return 2.0 / 3.0 * _contact_radius(parameters, overlap) * (parameters.friction or 0.0)
    return parameters.twisting_friction or 0.0


def twisting_spring(parameters: ContactSystem, overlap: float) -> tuple[float, float]:
    """Return stiffness [N m] and dashpot [N m s] of twisting; Marshall's k_t, eta_t by a^2 / 2."""
    if parameters.twisting != "marshall":
        return parameters.twisting_stiffness or 0.0, parameters.twisting_damping or 0.0
    a, k = _contact_radius(parameters, overlap), tangential_stiffness(parameters, overlap)
    eta = (parameters.tangential_damping or 0.0) * dashpots(parameters, overlap)
    return 0.5 * k * a * a, 0.5 * eta * a * a


def tangential_stiffness(parameters: ContactSystem, overlap: float) -> float:
    """Return k_t at an overlap [N/m]: 8 G* a of a material, a the contact radius."""
    k = parameters.tangential_stiffness
    if k is None and parameters.materials is not None:
        k = 8.0 * reduced_shear_modulus(parameters) * _contact_radius(parameters, overlap)
    return k or 0.0


def _contact_radius(parameters: ContactSystem, overlap: float) -> float:
    return math.sqrt(parameters.reduced_radius * overlap)


def check_impact(
    parameters: ContactSystem,
    name: str,
    unit: str,
    speed: float,
    value_of: Callable[[float], float],
    gravity: float = 0.0,
) -> None:
    """Raise ValueError for an impact at a normal speed [m/s] that no contact withstands.

    ``value_of`` gives the value of the parameter for a speed. Held against the elastic energy, and
    under ``gravity`` [m/s2] its work: a sphere that its weight presses in further than its speed
    lies, and does not bounce.
    """
    mass, (least, most) = parameters.reduced_mass, overlaps(parameters)
    stored = energy(parameters, most) / mass
    if stored <= 2.0 * gravity * most:
        between("gravity", gravity, "m/s2", (0.0, 0.5 * stored / most), WHY_OVERLAP)
    slow = math.sqrt(2.0 * energy(parameters, least) / mass)
    if gravity:
        rest = rest_overlap(parameters, mass * gravity)
        slow = max(slow, gravity * math.sqrt(mass / stiffness(parameters, rest)))
    fast = math.sqrt(2.0 * (stored - gravity * most)) / _damped(parameters)
    if not slow <= speed <= fast:
        limits = value_of(slow), value_of(fast)
        between(name, getattr(parameters, name), unit, limits, WHY_OVERLAP)
    if parameters.yield_stress is not None:
        _yields(parameters, parameters.yield_stress, speed)
    coefficient, overlap = parameters.damping_coefficient, elastic_overlap(parameters, speed)
    if coefficient:
        critical = 2.0 * math.sqrt(mass * stiffness(parameters, overlap))
        most = coefficient * STRONGEST * critical / dashpots(parameters, overlap)
        why = "from critical damping on the contact does not end"
        between("damping_coefficient", coefficient, "", (0.0, most), why)


def _yields(parameters: ContactSystem, stress: float, speed: float) -> None:
    """Raise ValueError for a yield stress [Pa] with which an impact [m/s] goes too deep.

    A pressure of it on the area of a sphere cut at delta, pi (2 R delta - delta^2), on each side of
    a flat, does at most as much work as the contact of mdr.
    """
    flats = 1.0 if parameters.partner == "wall" else 2.0
    work = flats * math.pi * parameters.radius**3 * (DEEPEST**2 - DEEPEST**3 / 3.0)
    least = 0.5 * parameters.reduced_mass * speed**2 / work
    why = "a sphere that yields must not be pressed in by more than a quarter of its radius"
    between("yield_stress", stress, "Pa", (least, 1e30), why)


def elastic_overlap(parameters: ContactSystem, speed: float) -> float:
    """Return the largest overlap of an elastic impact at a normal speed [m/s], in m."""
    mass, k = parameters.reduced_mass, parameters.normal_stiffness
    if k is None:
        return contact.largest_hertz_overlap(mass, hertz_spring(parameters), speed)
    return speed * math.sqrt(mass / k)


def _damped(parameters: ContactSystem) -> float:
    """Return the largest overlap over that without damping: of a linear spring; else 1."""
    if parameters.normal_stiffness is None:
        return 1.0
    k = parameters.normal_stiffness
    ratio = 0.5 * dashpots(parameters, 0.0) / math.sqrt(k * parameters.reduced_mass)
    return contact.largest_overlap(min(ratio, STRONGEST))


def resolved(parameters: ContactSystem, scene: ContactScene, overlap: float) -> ContactScene:
    """Return a scene; raise RequestError for a part of its law that its step does not resolve.

    Dashpots are those at an ``overlap`` [m].
    """
    for name, rate, power in _rates(parameters, scene, overlap):
        value, coarse = getattr(parameters, name), rate * scene.step / COARSEST
        if value is not None and coarse > 1.0:
            most = f"must be at most {value / coarse**power:.4g}, or " if power else ""
            n = parameters.steps_per_contact
            raise RequestError(
                f"{name} = {value!r}: {most}needs steps_per_contact of at least "
                f"{math.ceil(n * coarse)}, not {n}: a step must resolve it"
            )
    return scene


def _rates(
    parameters: ContactSystem, scene: ContactScene, overlap: float
) -> Iterator[tuple[str, float, float]]:
    """Yield each coefficient with its rate [1/s], and the power of the rate that it goes with."""
    free = [body for body in scene.bodies if not body.frozen]
    turning = sum(1.0 / body.inertia for body in free)
    rolling = parameters.reduced_radius**2 * turning
    slip = 3.5 / parameters.reduced_mass
    eta = dashpots(parameters, overlap)
    yield "damping_coefficient", eta / parameters.reduced_mass, 1.0
    yield "restitution", eta / parameters.reduced_mass, 0.0
    yield "tangential_stiffness", math.sqrt((parameters.tangential_stiffness or 0.0) * slip), 2.0
    yield "tangential_damping", (parameters.tangential_damping or 0.0) * eta * slip, 1.0
    yield "rolling_stiffness", math.sqrt((parameters.rolling_stiffness or 0.0) * rolling), 2.0
    yield "rolling_damping", (parameters.rolling_damping or 0.0) * rolling, 1.0
    yield "twisting_stiffness", math.sqrt((parameters.twisting_stiffness or 0.0) * turning), 2.0
    yield "twisting_damping", (parameters.twisting_damping or 0.0) * turning, 1.0


def counted(parameters: Any, steps: float) -> int:
    """Return a number of steps; raise RequestError, which names duration, for too many."""
    if not steps <= MOST_STEPS:
        duration, most = parameters.duration, parameters.duration * (MOST_STEPS / steps)
        raise RequestError(
            f"duration = {duration!r}: must be at most {most:.4g} here: "
            f"{MOST_STEPS:.0e} steps are allowed, this would take {steps:.3g}"
        )
    return math.ceil(steps)
