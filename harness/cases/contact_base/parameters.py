"""Two spheres, or a sphere and a plane, that meet by one law: what all these cases are told."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from harness.parameters.contact_law import ContactLaw
from harness.parameters.contact_scene import Body, Plane, Vector, sphere_mass
from harness.theory import hertz_impact

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
    def _stated(self) -> Self:
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
                known = "; ".join(f"{n}: {', '.join((*d, *t))}" for n, (d, t) in OLD.items())
                raise ValueError(f"interface = 'old': states these submodels only: {known}")
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
    return hertz_impact.stiffness(reduced_modulus(parameters), parameters.reduced_radius)
