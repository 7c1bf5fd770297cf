"""Parameters of a sphere and its partner in contact, and the bounds within which they have meaning.

Overlaps: coordinates are rounded, so that too small an overlap is lost; beyond the smaller radius
the centre is past the surface of the partner. Steps: velocity Verlet is off by (rate step)^2 / 24
in the phase of an oscillation, and unstable from rate step = 2 on.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Callable, Iterable, Iterator
from functools import lru_cache
from typing import Annotated, Any, ClassVar, Literal, Self

from pydantic import Field, model_validator

from harness.errors import RequestError
from harness.model.base import ZERO, Vector
from harness.model.law import SUBMODELS, Law, damping_ratio
from harness.model.scene import Body, Wall, sphere
from harness.theory import contact

Partner = Literal["wall", "sphere", "frozen"]
Radius = Annotated[float, Field(ge=1e-9, le=1e3)]  # an atom is smaller, a mountain larger
Density = Annotated[float, Field(ge=1e-3, le=1e9)]  # less than a gas, and a white dwarf
Speed = Annotated[float, Field(ge=1e-9, le=1e9)]
AngularSpeed = Annotated[float, Field(ge=1e-9, le=1e9)]
Gravity = Annotated[float, Field(ge=1e-9, le=1e9)]
Duration = Annotated[float, Field(ge=1e-3, le=1e9)]
OLD_INTERFACE = {  # dampings and tangential forces of earlier contact styles, by normal force
    "hooke": (("none", "mass_velocity"), ("none", "linear_nohistory", "linear_history_classic")),
    "hertz": (("none", "viscoelastic"), ("none", "mindlin_classic")),
}
SMALLEST_RESTITUTION = 1e-6  # of a linear contact that still ends
STRONGEST = damping_ratio(SMALLEST_RESTITUTION)
SHALLOWEST = 4.0 * sys.float_info.epsilon / 1e-6  # [radii] overlap that rounding spoils by 1e-6
DEEPEST = 0.25  # [radius] flat of a sphere that yields: its law was fitted for shallow ones
FLAT_WITHIN = 0.75  # [radius] depth of mdr's flat between unequal spheres
WIDEST = 1e6  # ratio of radii: three decades between the smallest overlap and the largest
COARSEST = 0.5  # rate times step: 1 % of a phase
MOST_STEPS = 10**9
OVERLAP_RANGE = "the overlap must be above the round-off of coordinates and below the radius"


class ContactSystem(Law):
    """A sphere, its partner, their law, and the resolution of the contact; in SI units."""

    conducts: ClassVar[bool] = False  # takes a law with heat

    # fmt: off
    bulk_response: bool = Field(
        False, description="[-] of mdr: the bulk responds from the first touch on (bulk_share = 1)")
    partner: Partner = Field("wall", description="[-] a wall, a free or a frozen sphere")
    radius: Radius = Field(0.01, description="[m] of the sphere")
    partner_radius: Radius | None = Field(
        None, description="[m] of the other sphere; as large unless given")
    density: Density = Field(2500.0, description="[kg/m3] of the spheres")
    partner_density: Density | None = Field(
        None, description="[kg/m3] of the other sphere; as dense unless given")
    materials_as: Literal["stated", "mixed"] = Field(
        "stated", description="[-] stated: an engine gets the one material that stands for two in "
        "contact; mixed: it gets both, and mixes them")
    steps_per_contact: int = Field(
        1000, ge=10, le=10**7, description="[-] steps of the time that the contact takes; of a "
        "sixteenth of it where mdr yields or its bulk responds")
    # fmt: on

    @model_validator(mode="before")
    @classmethod
    def _set_bulk_share(cls, data: Any) -> Any:
        if not isinstance(data, dict) or not data.get("bulk_response"):
            return data
        if (normal := data.get("normal")) != "mdr":
            raise ValueError(f"bulk_response = True: normal = {normal!r} has none (mdr does)")
        return data if data.get("bulk_share") is not None else {**data, "bulk_share": 1.0}

    @model_validator(mode="after")
    def _check_system(self) -> Self:
        for name in ("partner_radius", "partner_density"):
            if self.partner == "wall" and (value := getattr(self, name)) is not None:
                raise ValueError(
                    f"{name} = {value!r}: partner = 'wall' has none (partner = sphere, frozen does)"
                )
        if self.heat != "none" and not self.conducts:
            raise ValueError(f"heat = {self.heat!r}: must be none in this case")
        if self.materials_as == "mixed" and not self.two_materials:
            raise ValueError(
                "materials_as = 'mixed': needs two materials (partner_youngs_modulus or "
                "partner_poisson_ratio)"
            )
        if self.normal == "mdr":
            self._check_mdr()
        self._check_interface()
        self.check()
        return self

    def _check_mdr(self) -> None:
        """Refuse what the papers do not define together with the branches of mdr."""
        one_size = self.lags or self.surface_energy or self.damping == "mdr"
        if one_size and self.second_radius != self.radius:
            raise ValueError(
                f"partner_radius = {self.partner_radius!r}: normal = mdr with yield, adhesion, a "
                "bulk response or damping = mdr takes spheres of one size"
            )
        if self.bulk_share and self.damping == "mdr":
            raise ValueError(
                "damping = 'mdr': must be none or velocity with bulk_response = True, which "
                "leaves nothing to the elastic contact"
            )
        parts = [part for part in SUBMODELS if part not in ("normal", "heat")]
        others = [f"{part} = {getattr(self, part)!r}" for part in parts]
        others = [text for text in others if not text.endswith("'none'")]
        turning = [text for text in others if text.startswith(("rolling", "twisting"))]
        if self.lags and turning:
            raise ValueError(f"{turning[0]}: must be none: a sphere that yields has no lever")
        if self.surface_energy and (others or self.lags):
            other = others[0] if others else "a yield_stress or bulk_response"
            raise ValueError(
                f"surface_energy = {self.surface_energy!r}: normal = mdr is stated with it alone, "
                f"not with {other}"
            )
        if self.lags and not 0.0 <= (self.poisson_ratio or 0.0) < 0.5:
            raise ValueError(
                f"poisson_ratio = {self.poisson_ratio!r}: must be from 0 to below 0.5: the bulk "
                "modulus must be finite"
            )

    def _check_interface(self) -> None:
        if self.interface != "old":
            return
        dampings, tangentials = OLD_INTERFACE.get(self.normal, ((), ()))
        turns = self.rolling != "none" or self.twisting != "none"
        if turns or self.damping not in dampings or self.tangential not in tangentials:
            rows = OLD_INTERFACE.items()
            allowed = "; ".join(f"{name}: {', '.join((*d, *t))}" for name, (d, t) in rows)
            raise ValueError(f"interface = 'old': states these submodels only: {allowed}")

    def check(self) -> None:
        """Raise ValueError for values of a case that have no meaning together."""

    def replace(self, **changes: Any) -> Self:
        """Return a copy with changed fields, without coefficients of submodels that are left."""
        if "bulk_response" in changes and not changes["bulk_response"]:
            changes.setdefault("bulk_share", None)
        return super().replace(**changes)

    @property
    def stated_law(self) -> Law:
        """Return the law that an engine gets: two stated materials as the one of both."""
        return _stated_law(self)

    # ---- bodies

    @property
    def mass(self) -> float:
        """Return the mass of the sphere [kg]."""
        return sphere(self.radius, self.density).mass

    @property
    def second_radius(self) -> float:
        """Return the radius of the other sphere [m]."""
        return self.radius if self.partner_radius is None else self.partner_radius

    @property
    def second_mass(self) -> float:
        """Return the mass of the other sphere [kg]."""
        density = self.density if self.partner_density is None else self.partner_density
        return sphere(self.second_radius, density).mass

    @property
    def effective_mass(self) -> float:
        """Return m* [kg]: m against a wall or a frozen sphere."""
        if self.partner != "sphere":
            return self.mass
        return self.mass * self.second_mass / (self.mass + self.second_mass)

    @property
    def effective_radius(self) -> float:
        """Return R* [m]: r against a wall."""
        if self.partner == "wall":
            return self.radius
        return self.radius * self.second_radius / (self.radius + self.second_radius)

    @property
    def walls(self) -> tuple[Wall, ...]:
        """Return the floor z = 0 where that is the partner."""
        return (Wall(),) if self.partner == "wall" else ()

    def bodies(
        self, gap: float, velocity: Vector = ZERO, spin: Vector = ZERO, other_spin: Vector = ZERO
    ) -> tuple[Body, ...]:
        """Return the sphere, ``gap`` [m] above z = 0, and the other one below, at rest."""
        first = sphere(
            self.radius, self.density, position=(0.0, 0.0, self.radius + gap), velocity=velocity,
            angular_velocity=spin,
        )  # fmt: skip
        if self.partner == "wall":
            return (first,)
        second = Body(
            radius=self.second_radius, mass=self.second_mass, angular_velocity=other_spin,
            position=(0.0, 0.0, -self.second_radius),
            motion="frozen" if self.partner == "frozen" else "free",
        )  # fmt: skip
        return first, second

    # ---- the contact

    @property
    def is_linear(self) -> bool:
        """Return whether the normal force is a linear spring and a constant dashpot."""
        return self.normal == "hooke" and self.damping != "viscoelastic"

    @property
    def lags(self) -> bool:
        """Return whether the force rests on a state that codes bring on step by step."""
        return self.normal == "mdr" and (self.yield_stress is not None or bool(self.bulk_share))

    @property
    def hertz_coefficient(self) -> float:
        """Return K of Hertz's force K d^(3/2) [N/m^(3/2)]."""
        return self.stiffness(self.effective_radius, 1.0) / 1.5

    def slope(self, overlap: float) -> float:
        """Return the slope of the elastic force at an overlap [N/m]."""
        return self.stiffness(self.effective_radius, overlap)

    def elastic_force(self, overlap: float) -> float:
        """Return the elastic force of hooke or hertz at an overlap [N]."""
        return self.slope(overlap) * overlap / (1.0 if self.normal == "hooke" else 1.5)

    def elastic_energy(self, overlap: float) -> float:
        """Return the energy of hooke or hertz at an overlap [J]."""
        return self.elastic_force(overlap) * overlap / (2.0 if self.normal == "hooke" else 2.5)

    def elastic_overlap(self, speed: float) -> float:
        """Return the largest overlap of an elastic impact at a normal speed [m/s], in m."""
        if self.normal == "hooke":
            return speed * math.sqrt(self.effective_mass / self.slope(1.0))
        return contact.largest_hertz_overlap(self.effective_mass, self.hertz_coefficient, speed)

    def rest_overlap(self, load: float) -> float:
        """Return the overlap under a load [N] at rest [m], without attraction."""
        if self.normal == "hooke":
            return load / self.slope(1.0)
        return float((load / self.hertz_coefficient) ** (2.0 / 3.0))

    def contact_radius(self, overlap: float) -> float:
        """Return a = sqrt(R* d) [m]."""
        return math.sqrt(self.effective_radius * overlap)

    def eta(self, overlap: float) -> float:
        """Return the normal dashpot at an overlap [kg/s]."""
        return self.dashpot(self.effective_mass, self.effective_radius, overlap)

    def tangential_slope(self, overlap: float) -> float:
        """Return k_t at an overlap [N/m]: 8 G* a of a material."""
        if self.tangential_stiffness is not None:
            return self.tangential_stiffness
        shear = self.tangential_modulus or (8.0 * self.moduli[1] if self.moduli else 0.0)
        return shear * self.contact_radius(overlap)

    def twisting_limit(self, overlap: float) -> float:
        """Return the largest torque about the normal over the normal force [m]."""
        if self.twisting == "marshall":
            return 2.0 / 3.0 * self.contact_radius(overlap) * (self.friction or 0.0)
        return self.twisting_friction or 0.0

    def twisting_spring(self, overlap: float) -> tuple[float, float]:
        """Return stiffness [N m] and dashpot [N m s] of twisting; Marshall's k_t, eta_t a^2 / 2."""
        if self.twisting != "marshall":
            return self.twisting_stiffness or 0.0, self.twisting_damping or 0.0
        square = 0.5 * self.contact_radius(overlap) ** 2
        eta = (self.tangential_damping or 0.0) * self.eta(overlap)
        return square * self.tangential_slope(overlap), square * eta


@lru_cache(maxsize=4096)
def _stated_law(p: ContactSystem) -> Law:
    given = {name: getattr(p, name) for name in Law.model_fields}
    law = Law(**{name: value for name, value in given.items() if value is not None})
    return law.one_material if p.materials_as == "stated" else law


# ---- bounds


def check_range(name: str, value: float, unit: str, limits: tuple[float, float], why: str) -> None:
    """Raise ValueError for a value outside limits, with its name, the range and the reason."""
    low, high = limits
    if not low <= value <= high:
        text = f"{name} = {value!r} {unit}".rstrip()
        raise ValueError(f"{text}: must be between {low:.4g} and {high:.4g} here: {why}")


def check_words(parameters: ContactSystem, **allowed: tuple[str, ...]) -> None:
    """Raise ValueError for a field whose word a case does not take."""
    for name, words in allowed.items():
        if (value := getattr(parameters, name)) not in words:
            raise ValueError(f"{name} = {value!r}: must be one of {', '.join(words)} in this case")


def overlap_range(p: ContactSystem) -> tuple[float, float]:
    """Return the smallest and the largest overlap with a meaning [m].

    Raise ValueError for radii too far apart, and where JKR's area without load, a^3 = 9 pi gamma
    R*^2 / E*, is larger than the reduced radius.
    """
    r, other = p.radius, p.second_radius
    limits = (r / WIDEST, r * WIDEST)
    check_range("partner_radius", other, "m", limits, "the radii are too far apart")
    if p.surface_energy and p.moduli:
        most = p.moduli[0] * p.effective_radius / 9.0 / math.pi
        why = "the area of contact without a load must be smaller than the reduced radius"
        check_range("surface_energy", p.surface_energy, "J/m2", (0.0, most), why)
    radii = (r,) if p.partner == "wall" else (r, other)
    share = FLAT_WITHIN if p.normal == "mdr" and len(set(radii)) > 1 else 1.0
    return SHALLOWEST * sum(radii), share * min(radii)


def check_overlap(
    p: ContactSystem, name: str, unit: str, overlap: float, power: float = 1.0
) -> None:
    """Raise ValueError for a parameter whose overlap [m], which goes with its power, is none."""
    value, limits = getattr(p, name), overlap_range(p)
    if not limits[0] <= overlap <= limits[1]:
        low, high = (value * (bound / overlap) ** (1.0 / power) for bound in limits)
        check_range(name, value, unit, (low, high), OVERLAP_RANGE)


def check_rest(p: ContactSystem, gravity: float) -> None:
    """Raise ValueError for gravity along the normal [m/s2] that presses in too far, or too little.

    The parameter is ``gravity``.
    """
    power = 1.0 if p.normal == "hooke" else 2.0 / 3.0
    check_overlap(p, "gravity", "m/s2", p.rest_overlap(p.mass * gravity), power)


def check_impact(
    p: ContactSystem, name: str, unit: str, speed: float, value_of: Callable[[float], float],
    gravity: float = 0.0,
) -> None:  # fmt: skip
    """Raise ValueError for an impact at a normal speed [m/s] that no contact withstands.

    ``value_of`` gives the value of the parameter ``name`` for a speed. Under ``gravity`` [m/s2] a
    sphere that its weight presses in further than its speed does not bounce.
    """
    mass, (least, most) = p.effective_mass, overlap_range(p)
    stored = p.elastic_energy(most) / mass
    if stored <= 2.0 * gravity * most:
        check_range("gravity", gravity, "m/s2", (0.0, 0.5 * stored / most), OVERLAP_RANGE)
    slow = math.sqrt(2.0 * p.elastic_energy(least) / mass)
    if gravity:
        rest = p.rest_overlap(mass * gravity)
        slow = max(slow, gravity * math.sqrt(mass / p.slope(rest)))
    fast = math.sqrt(2.0 * (stored - gravity * most)) / _damped_share(p)
    if not slow <= speed <= fast:
        limits = value_of(slow), value_of(fast)
        check_range(name, getattr(p, name), unit, limits, OVERLAP_RANGE)
    if p.yield_stress is not None:
        _check_yield(p, p.yield_stress, speed)
    if p.damping_coefficient and not p.clipped:
        overlap = p.elastic_overlap(speed)
        critical = 2.0 * math.sqrt(mass * p.slope(overlap))
        highest = p.damping_coefficient * STRONGEST * critical / p.eta(overlap)
        why = "from critical damping on the contact does not end, unless it is clipped"
        check_range("damping_coefficient", p.damping_coefficient, "", (0.0, highest), why)


def _check_yield(p: ContactSystem, stress: float, speed: float) -> None:
    """Raise ValueError for a yield stress [Pa] with which an impact [m/s] goes too deep.

    A pressure Y on the area pi (2 R d - d^2), on each side, does at most the work of mdr.
    """
    flats = 1.0 if p.partner == "wall" else 2.0
    work = flats * math.pi * p.radius**3 * (DEEPEST**2 - DEEPEST**3 / 3.0)
    least = 0.5 * p.effective_mass * speed**2 / work
    why = "a sphere that yields must not be pressed in by more than a quarter of its radius"
    check_range("yield_stress", stress, "Pa", (least, 1e30), why)


def _damped_share(p: ContactSystem) -> float:
    """Return the largest overlap over that without damping; 1 for what is not linear."""
    if not p.is_linear:
        return 1.0
    ratio = 0.5 * p.eta(0.0) / math.sqrt(p.slope(1.0) * p.effective_mass)
    return contact.largest_overlap(ratio if p.clipped else min(ratio, STRONGEST))


def check_steps(p: ContactSystem, bodies: Iterable[Body], step: float, overlap: float) -> None:
    """Raise RequestError for a part of the law that a step [s] does not resolve.

    Dashpots are those at an ``overlap`` [m].
    """
    for name, rate, power in _rates(p, bodies, overlap):
        value, coarse = getattr(p, name), rate * step / COARSEST
        if value is not None and coarse > 1.0:
            most = f"must be at most {value / coarse**power:.4g}, or " if power else ""
            n = p.steps_per_contact
            raise RequestError(
                f"{name} = {value!r}: {most}needs steps_per_contact of at least "
                f"{math.ceil(n * coarse)}, not {n}: a step must resolve it"
            )


def _rates(
    p: ContactSystem, bodies: Iterable[Body], overlap: float
) -> Iterator[tuple[str, float, float]]:
    """Yield each coefficient with its rate [1/s], and the power of the rate that it goes with."""
    turning = sum(1.0 / body.moment_of_inertia for body in bodies if body.motion == "free")
    rolling = p.effective_radius**2 * turning
    slip = 3.5 / p.effective_mass
    eta = p.eta(overlap)
    yield "damping_coefficient", eta / p.effective_mass, 1.0
    yield "restitution", eta / p.effective_mass, 0.0
    yield "tangential_stiffness", math.sqrt((p.tangential_stiffness or 0.0) * slip), 2.0
    yield "tangential_damping", (p.tangential_damping or 0.0) * eta * slip, 1.0
    for part, factor in (("rolling", rolling), ("twisting", turning)):
        stiffness, damping = f"{part}_stiffness", f"{part}_damping"
        yield stiffness, math.sqrt((getattr(p, stiffness) or 0.0) * factor), 2.0
        yield damping, (getattr(p, damping) or 0.0) * factor, 1.0


def count_steps(duration: float, steps: float) -> int:
    """Return a number of steps; raise RequestError, which names the duration, for too many."""
    if not steps <= MOST_STEPS:
        most = duration * (MOST_STEPS / steps)
        raise RequestError(
            f"duration = {duration!r}: must be at most {most:.4g} here: {MOST_STEPS:.0e} steps are "
            f"allowed, this would take {steps:.3g}"
        )
    return math.ceil(steps)
