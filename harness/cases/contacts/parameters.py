"""Parameters of a sphere and its partner in contact."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Annotated, Any, ClassVar, Literal, Self

from pydantic import Field, model_validator

from harness.model.base import ZERO, Vector
from harness.model.law import SUBMODELS, Law
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
                "materials_as = 'mixed': needs two materials (partner_youngs_modulus, "
                "partner_poisson_ratio, partner_restitution or partner_friction)"
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
