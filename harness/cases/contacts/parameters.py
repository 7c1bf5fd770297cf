"""Parameters of a sphere and its partner in contact, with the checks that cases share.

A case subclasses :class:`ContactSystem`: parameters, the scene of a run, the quantities of its
motion, and closed forms.
"""

from __future__ import annotations

import math
import sys
from abc import abstractmethod
from collections.abc import Callable, Collection, Mapping, Sequence
from functools import lru_cache
from typing import Annotated, Any, ClassVar, Literal, Self

from pydantic import Field, model_validator

from harness.cases.base import Quantity
from harness.errors import RequestError
from harness.model.base import ZERO, Vector, unit
from harness.model.law import Law
from harness.model.scene import Body, Motion, Scene, Wall, sphere
from harness.theory import contact

Partner = Literal["wall", "sphere", "frozen"]
Radius = Annotated[float, Field(ge=1e-9, le=1e3)]  # an atom is smaller, a mountain larger
Density = Annotated[float, Field(ge=1e-3, le=1e9)]  # less than a gas, and a white dwarf
Speed = Annotated[float, Field(ge=1e-9, le=1e9)]
AngularSpeed = Annotated[float, Field(ge=1e-9, le=1e9)]
Gravity = Annotated[float, Field(ge=1e-9, le=1e9)]
Duration = Annotated[float, Field(ge=1e-3, le=1e9)]
OLD_INTERFACE = {  # dampings and tangential forces of earlier contact styles, by normal force
    "hooke": ("none", "mass_velocity", "linear_nohistory", "linear_history_classic"),
    "hertz": ("none", "viscoelastic", "mindlin_classic"),
}
LEAST_OVERLAP = 4.0 * sys.float_info.epsilon / 1e-6  # [radii] that rounding spoils by 1e-6
DEEPEST_YIELD = 0.25  # [radius] flat of a sphere that yields: its law was fitted for shallow ones
DEEPEST_FLAT = 0.75  # [radius] of mdr between unequal spheres
LARGEST_SIZE_RATIO = 1e6  # three decades between the smallest overlap and the largest
MOST_STEPS = 10**9
OVERLAP_REASON = "the overlap must be above the round-off of coordinates and below the radius"


def ratios(
    scale: float | Callable[[Any], float] = 1.0, /, **meanings: str
) -> tuple[Quantity[Any], ...]:
    """Return quantities that are pure numbers of one scale, by name and meaning."""
    return tuple(Quantity(name, "1", meaning, scale) for name, meaning in meanings.items())


class ContactSystem(Law):
    """A sphere, its partner, their law, and the resolution of the contact; in SI units.

    The docstring of a case has its equations below the first line; ``quantities`` are its own.
    ``allowed`` has the words that it takes of a field, all unless given.
    """

    quantities: ClassVar[Sequence[Quantity[Any]]] = ()
    allowed: ClassVar[Mapping[str, tuple[str, ...]]] = {"heat": ("none",)}

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
            if self.partner == "wall" and getattr(self, name) is not None:
                raise self.invalid(name, "partner = 'wall' has none (sphere and frozen do)")
        if self.materials_as == "mixed" and not self.two_materials:
            reason = (
                "needs two materials (partner_youngs_modulus, partner_poisson_ratio, "
                "partner_restitution or partner_friction)"
            )
            raise self.invalid("materials_as", reason)
        for name, words in self.allowed.items():
            if getattr(self, name) not in words:
                raise self.invalid(name, f"must be {' or '.join(words)} in this case")
        if self.normal == "mdr":
            self._check_mdr()
        submodels = {self.damping, self.tangential, self.rolling, self.twisting}
        if self.interface == "old" and submodels - {*OLD_INTERFACE.get(self.normal, ())}:
            texts = (f"{normal}: {', '.join(words)}" for normal, words in OLD_INTERFACE.items())
            raise self.invalid("interface", f"has these submodels only: {'; '.join(texts)}")
        self.check()
        return self

    def _check_mdr(self) -> None:
        """Refuse what the papers do not define together with the branches of mdr."""
        parts = ("damping", "tangential", "rolling", "twisting")
        others = [part for part in parts if getattr(self, part) != "none"]
        turns = others[-1:] if self.rolling != "none" or self.twisting != "none" else []
        sizes = self.second_radius != self.radius
        alone = ", ".join(others) or "a yield_stress or bulk_response"
        rules = (
            (sizes and (self.lags or self.surface_energy or self.damping == "mdr"),
             "partner_radius", "must be the radius: normal = mdr with yield, adhesion, a bulk "
             "response or damping = mdr takes spheres of one size"),
            (self.bulk_share and self.damping == "mdr",
             "damping", "must be none or velocity: the bulk leaves nothing to the elastic contact"),
            (self.lags and turns, *turns, "must be none: a sphere that yields has no lever"),
            (self.surface_energy and (others or self.lags),
             "surface_energy", f"normal = mdr has it alone, not with {alone}"),
            (self.lags and not 0.0 <= (self.poisson_ratio or 0.0) < 0.5,
             "poisson_ratio", "must be from 0 to below 0.5: the bulk modulus must be finite"),
        )  # fmt: skip
        for is_wrong, *text in rules:
            if is_wrong:
                raise self.invalid(*text)

    def check(self) -> None:
        """Raise ValueError for values of a case that have no meaning together."""

    def invalid(self, name: str, reason: str) -> ValueError:
        """Return the error of a field, with its value and unit, and what is allowed."""
        value = f"{name} = {getattr(self, name)!r} {unit(type(self), name)}"
        return ValueError(f"{value.rstrip()}: {reason}")

    def check_range(self, name: str, low: float, high: float, reason: str) -> None:
        """Raise ValueError for a field outside a range, with the range and its reason."""
        if not low <= getattr(self, name) <= high:
            raise self.invalid(name, f"must be between {low:.4g} and {high:.4g} here: {reason}")

    @property
    def overlap_range(self) -> tuple[float, float]:
        """Return the smallest and the largest overlap with a meaning [m].

        Raise ValueError for too different radii, and where JKR's area without load, a^3 = 9 pi
        gamma R*^2 / E*, is larger than the reduced radius.
        """
        r, other = self.radius, self.second_radius
        limits = r / LARGEST_SIZE_RATIO, r * LARGEST_SIZE_RATIO
        if self.partner_radius is not None:
            self.check_range("partner_radius", *limits, "the radii are too far apart")
        if self.surface_energy and self.moduli:
            most = self.moduli[0] * self.effective_radius / 9.0 / math.pi
            reason = "the area of contact without a load must be below the reduced radius"
            self.check_range("surface_energy", 0.0, most, reason)
        radii = (r,) if self.partner == "wall" else (r, other)
        share = DEEPEST_FLAT if self.normal == "mdr" and len(set(radii)) > 1 else 1.0
        return LEAST_OVERLAP * sum(radii), share * min(radii)

    def check_overlap(self, name: str, overlap: float, power: float = 1.0) -> None:
        """Raise ValueError for a field whose overlap [m], a power of it, is out of range."""
        value, limits = getattr(self, name), self.overlap_range
        if not limits[0] <= overlap <= limits[1]:
            low, high = (value * (bound / overlap) ** (1.0 / power) for bound in limits)
            self.check_range(name, low, high, OVERLAP_REASON)

    def check_impact(self, name: str, speed: float, power: float = 1.0) -> None:
        """Raise ValueError for an impact at a normal speed [m/s] that is too deep or too shallow.

        The speed goes as a power of the field ``name``.
        """
        overlap = self.elastic_overlap(speed)
        if self.is_linear:
            overlap *= contact.largest_overlap(self.oscillator[0])
        self.check_overlap(name, overlap, power if self.normal == "hooke" else 0.8 * power)
        if self.yield_stress is not None:
            # a pressure Y on the area pi (2 R d - d^2), on each side, does at most the work of mdr
            sides = 1.0 if self.partner == "wall" else 2.0
            depth = DEEPEST_YIELD**2 - DEEPEST_YIELD**3 / 3.0
            least = 0.5 * self.effective_mass * speed**2 / (sides * math.pi * self.radius**3)
            reason = "a sphere that yields must not be pressed in by a quarter of its radius"
            self.check_range("yield_stress", least / depth, 1e30, reason)

    def replace(self, **changes: Any) -> Self:
        """Return a copy with changed fields, without coefficients that no submodel has any more."""
        if "bulk_response" in changes and not changes["bulk_response"]:
            changes.setdefault("bulk_share", None)
        return super().replace(**changes)

    @property
    def stated_law(self) -> Law:
        """Return the law that an engine gets: two stated materials as the one of both."""
        return _stated_law(self)

    # ---- one run

    @abstractmethod
    def scene(self) -> Scene:
        """Return the scene of a run. Raise RequestError for parameters that cannot be run."""

    def absent(self) -> Collection[str]:
        """Return the names of the case's quantities that a run does not have."""
        return ()

    @abstractmethod
    def observe(self, motion: Motion) -> Mapping[str, float]:
        """Return the quantities of a motion."""

    def exact(self) -> Mapping[str, float]:
        """Return the quantities with a closed form."""
        return {}

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
    def oscillator(self) -> tuple[float, float]:
        """Return zeta = eta / (2 sqrt(k m*)) and omega = sqrt(k / m*) [1/s] of a linear contact."""
        k, m = self.slope(1.0), self.effective_mass
        return self.eta(0.0) / 2.0 / math.sqrt(k * m), math.sqrt(k / m)

    @property
    def lags(self) -> bool:
        """Return whether the force depends on variables that codes advance step by step."""
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
    fields = {name: getattr(p, name) for name in Law.model_fields}
    law = Law(**{name: value for name, value in fields.items() if value is not None})
    return law.one_material if p.materials_as == "stated" else law


def quarters(duration: float, steps: float, seconds: float) -> dict[str, Any]:
    """Return step [s], steps and sampling of a time [s], with a sample after each quarter.

    Raise RequestError, which names the duration [-], for too many.
    """
    if not steps <= MOST_STEPS:
        raise RequestError(
            f"duration = {duration!r}: must be at most {duration * (MOST_STEPS / steps):.4g} here: "
            f"{MOST_STEPS:.0e} steps are allowed, this would take {steps:.3g}"
        )
    every = max(1, round(steps / 4))
    return {"step": seconds / 4 / every, "steps": 4 * every, "every": every}
