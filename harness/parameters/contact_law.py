"""The law of a contact with friction: normal, damping, tangential, rolling and twisting submodel.

Names and units follow the manual of LAMMPS's pair style granular, formulas the literature:
Johnson, Contact Mechanics (1985); Luding, Granular Matter 10, 235 (2008); Marshall, J. Comput.
Phys. 228, 1541 (2009); Thornton, Cummins and Cleary, Powder Technol. 233, 30 (2013); Zunker and
Kamrin, J. Mech. Phys. Solids 183, 105492 and 105493 (2024). Of their ``mdr`` this is the elastic
branch, yield, and a bulk response from the first touch on, with a constant dashpot (``velocity``)
or one of the stiffness (``mdr``), and with friction; and adhesion, alone.
"""

from __future__ import annotations

from typing import Annotated, Any, Literal, Self

from pydantic import Field, model_validator

from harness.parameters import mdr_branches
from harness.parameters.base import Parameters
from harness.parameters.contact_coefficients import MAY_TAKE, TAKES, default_of

Normal = Literal["hooke", "hertz", "dmt", "jkr", "mdr"]
Damping = Literal[
    "none", "velocity", "mass_velocity", "viscoelastic", "tsuji", "coeff_restitution", "mdr"
]
Tangential = Literal[
    "none",
    "linear_nohistory",
    "linear_history",
    "linear_history_classic",
    "mindlin",
    "mindlin/force",
    "mindlin_rescale",
    "mindlin_rescale/force",
    "mindlin_classic",
]
Rolling = Literal["none", "sds"]
Twisting = Literal["none", "sds", "marshall"]

COHESIVE = ("dmt", "jkr")

Positive = Annotated[float, Field(ge=1e-30, le=1e30)]
NotNegative = Annotated[float, Field(ge=0.0, le=1e30)]
"""Far beyond what there is; products of some of them and their powers stay in double precision."""

Friction = Annotated[float, Field(ge=0.0, le=1e9)]
"""Nothing slides from there on; a limit near the largest number overflows, and is never found."""


class ContactLaw(Parameters):
    """The law of one contact, in SI units, for two bodies of one material, or of two.

    A coefficient that its submodel does not take is None. Raise RequestError for one that is
    given all the same, and for one that is needed and has no default.
    """

    normal: Normal = Field("hooke", description="[-] elastic normal force")
    normal_stiffness: Positive | None = Field(None, description="[N/m] k_n of hooke")
    youngs_modulus: Positive | None = Field(None, description="[Pa] of hertz, dmt, jkr and mdr")
    poisson_ratio: Annotated[float, Field(gt=-1.0, le=0.5)] | None = Field(
        None, description="[-] of hertz, dmt, jkr and mdr"
    )
    partner_youngs_modulus: Positive | None = Field(
        None, description="[Pa] of what the sphere meets: as of the sphere unless given"
    )
    partner_poisson_ratio: Annotated[float, Field(gt=-1.0, le=0.5)] | None = Field(
        None, description="[-] of what the sphere meets, likewise"
    )
    surface_energy: NotNegative | None = Field(
        None,
        description="[J/m2] gamma of each surface, dmt and jkr; work of adhesion 2 gamma. Of mdr, "
        "none unless given, that of a sphere and a flat",
    )
    yield_stress: Positive | None = Field(
        None, description="[Pa] of mdr, which does not yield unless it is given"
    )
    bulk_response: bool = Field(
        False, description="[-] of mdr: the bulk responds from the first touch on (psi_b = 1)"
    )
    damping: Damping = Field("none", description="[-] rule of the normal dashpot eta_n")
    damping_coefficient: NotNegative | None = Field(
        None,
        description=(
            "[-] eta_0: eta_n = eta_0 (velocity, kg/s), eta_0 m* (mass_velocity, 1/s), eta_0 m* a "
            "(viscoelastic, 1/(m s)), a the contact radius, or eta_0 sqrt(m* k) (mdr, a pure "
            "number), k the stiffness of the contact"
        ),
    )
    restitution: Annotated[float, Field(ge=1e-6, le=1.0)] | None = Field(
        None, description="[-] that tsuji and coeff_restitution aim at"
    )
    tangential: Tangential = Field("none", description="[-] tangential force")
    tangential_stiffness: Positive | None = Field(
        None, description="[N/m] k_t of the linear springs; Mindlin's is 8 G* a"
    )
    tangential_damping: NotNegative | None = Field(
        None, description="[-] x_t: tangential dashpot over the normal one, eta_t = x_t eta_n"
    )
    friction: Friction | None = Field(None, description="[-] Coulomb's mu")
    rolling: Rolling = Field("none", description="[-] rolling resistance")
    rolling_stiffness: Positive | None = Field(
        None, description="[N/m] of the rolling displacement, whose velocity is R* (w_i-w_j) x n"
    )
    rolling_damping: NotNegative | None = Field(None, description="[kg/s] of that velocity")
    rolling_friction: Friction | None = Field(
        None, description="[-] mu_r: the torque is at most mu_r R* |F_n|"
    )
    twisting: Twisting = Field("none", description="[-] twisting resistance")
    twisting_stiffness: Positive | None = Field(None, description="[N m] per radian, sds")
    twisting_damping: NotNegative | None = Field(None, description="[N m s] per radian, sds")
    twisting_friction: Friction | None = Field(
        None, description="[m] mu_w of sds: the torque is at most mu_w |F_n|"
    )
    clipped: bool = Field(False, description="[-] no attraction at the end of a contact")

    @classmethod
    def coefficients(cls) -> set[str]:
        """Return the names of the fields that belong to a submodel."""
        needed = {name for models in TAKES.values() for names in models.values() for name in names}
        return needed.union(*MAY_TAKE.values())

    @staticmethod
    def taken(models: dict[str, Any]) -> set[str]:
        """Return the coefficients that submodels take, ``{"normal": "hooke", ...}``."""
        needed = {name for part in TAKES for name in TAKES[part].get(str(models[part]), ())}
        return needed.union(MAY_TAKE.get(str(models["normal"]), ()))

    @model_validator(mode="before")
    @classmethod
    def _fill(cls, given: Any) -> Any:
        """Give coefficients that are taken their default, and drop it of those that are not."""
        if not isinstance(given, dict):
            return given
        models = {part: given.get(part, cls.model_fields[part].default) for part in TAKES}
        values, taken = dict(given), cls.taken(models)
        optional = MAY_TAKE.get(str(models["normal"]), ())
        for name in cls.coefficients() - set(given):
            default = cls.model_fields[name].default
            if default is None and name not in optional:
                default = default_of(name, models, values)
            values[name] = default if name in taken else None
        return values

    @model_validator(mode="after")
    def _fits(self) -> Self:
        for part, models in TAKES.items():
            self._part_has_its_own(part, models)
        if self.tangential == "linear_nohistory" and self.damping == "none":
            raise ValueError(
                "tangential = 'linear_nohistory': needs a damping, its friction grows from the "
                "dashpot (damping = velocity, mass_velocity, coeff_restitution, ...)"
            )
        if "mindlin" in self.tangential and self.normal == "hooke":
            raise ValueError(
                f"tangential = {self.tangential!r}: needs a material (normal = hertz, dmt or jkr)"
            )
        if self.twisting == "marshall" and not self.tangential_spring:
            raise ValueError(
                "twisting = 'marshall': takes its coefficients from a tangential spring "
                "(tangential = linear_history, mindlin, ...)"
            )
        self._damping_fits()
        mdr_branches.check(self)
        return self

    def _part_has_its_own(self, part: str, models: dict[str, tuple[str, ...]]) -> None:
        chosen = getattr(self, part)
        mine = models.get(chosen, ())
        may = {name for names in MAY_TAKE.values() for name in names} if part == "normal" else set()
        others = may.union(*models.values()) - {*mine, *MAY_TAKE.get(chosen, ())}
        for name in sorted(others):
            if getattr(self, name) is not None:
                allowed = ", ".join(
                    model
                    for model, names in models.items()
                    if name in (*names, *MAY_TAKE.get(model, ()))
                )
                raise ValueError(
                    f"{name} = {getattr(self, name)!r}: {part} = {chosen!r} takes none "
                    f"({part} = {allowed} does)"
                )
        for name in mine:
            if getattr(self, name) is None:
                raise ValueError(f"{part} = {chosen!r}: needs {name}")

    def _damping_fits(self) -> None:
        """Raise ValueError for a damping or a clipping that the normal force has no meaning for."""
        if self.damping == "tsuji" and self.normal != "hertz":
            raise ValueError("damping = 'tsuji': is fitted to normal = hertz")
        if self.normal in COHESIVE and self.damping == "coeff_restitution":
            raise ValueError("damping = 'coeff_restitution': needs normal = hooke or hertz")
        if self.normal in COHESIVE and self.clipped:
            raise ValueError(f"clipped = True: normal = {self.normal!r} attracts (must be False)")

    def replace(self, **changes: Any) -> Self:
        """Return a copy with ``changes``; coefficients of submodels that are left are dropped."""
        models = {part: changes.get(part, getattr(self, part)) for part in TAKES}
        left = self.coefficients() - self.taken(models)
        kept = {name: value for name, value in self if name not in left and value is not None}
        return type(self)(**{**kept, **changes})

    @property
    def law(self) -> ContactLaw:
        """Return the law alone, without what a subclass adds."""
        values = {name: getattr(self, name) for name in ContactLaw.model_fields}
        return ContactLaw(**{name: value for name, value in values.items() if value is not None})

    @property
    def materials(self) -> tuple[tuple[float, float], tuple[float, float]] | None:
        """Return Young's modulus [Pa] and Poisson's ratio of both bodies; None without any."""
        if self.youngs_modulus is None or self.poisson_ratio is None:
            return None
        modulus, poisson = self.partner_youngs_modulus, self.partner_poisson_ratio
        return (self.youngs_modulus, self.poisson_ratio), (
            self.youngs_modulus if modulus is None else modulus,
            self.poisson_ratio if poisson is None else poisson,
        )

    @property
    def two_materials(self) -> bool:
        """Return whether the second body has a material of its own."""
        return self.partner_youngs_modulus is not None or self.partner_poisson_ratio is not None

    @property
    def lags(self) -> bool:
        """Return whether its force rests on a state that codes bring on step by step, behind it."""
        return self.normal == "mdr" and (self.yield_stress is not None or self.bulk_response)

    @property
    def tangential_spring(self) -> bool:
        """Return whether the tangential force has a spring."""
        return self.tangential not in ("none", "linear_nohistory")
