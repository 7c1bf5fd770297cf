"""Two spheres, or a sphere and a plane, that meet by one law: what all these cases are told."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from harness.parameters.contact_law import ContactLaw
from harness.parameters.contact_scene import Body, Plane, Vector, sphere_mass
from harness.theory import hertz_impact

Partner = Literal["wall", "sphere", "frozen"]
Interface = Literal["current", "old"]

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
        other = sphere_mass(self.second_radius, self.density)
        return self.mass * other / (self.mass + other)

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
        second = Body(
            r, sphere_mass(r, self.density), (0.0, 0.0, -r), frozen=self.partner == "frozen"
        )
        return [first, second]


def reduced_modulus(parameters: ContactSystem) -> float:
    """Return E* [Pa] of two bodies of one material."""
    assert parameters.youngs_modulus is not None
    assert parameters.poisson_ratio is not None
    return parameters.youngs_modulus / 2.0 / (1.0 - parameters.poisson_ratio**2)


def reduced_shear_modulus(parameters: ContactSystem) -> float:
    """Return G* [Pa] of two bodies of one material: G / (2 (2 - nu))."""
    assert parameters.youngs_modulus is not None
    assert parameters.poisson_ratio is not None
    nu = parameters.poisson_ratio
    return parameters.youngs_modulus / 4.0 / (1.0 + nu) / (2.0 - nu)


def hertz_spring(parameters: ContactSystem) -> float:
    """Return K of Hertz's force K overlap^(3/2) [N/m^(3/2)]."""
    return hertz_impact.stiffness(reduced_modulus(parameters), parameters.reduced_radius)
