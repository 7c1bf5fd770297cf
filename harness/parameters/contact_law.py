"""The law of a contact with friction: normal, damping, tangential, rolling and twisting submodel.

Names and units follow the manual of LAMMPS's pair style granular, formulas the literature:
Johnson, Contact Mechanics (1985); Luding, Granular Matter 10, 235 (2008); Marshall, J. Comput.
Phys. 228, 1541 (2009); Thornton, Cummins and Cleary, Powder Technol. 233, 30 (2013); Zunker and
Kamrin, J. Mech. Phys. Solids 183, 105492 (2024), of whose ``mdr`` this is the elastic branch:
neither yield nor adhesion nor a bulk response, and dashpots that it does not scale (``velocity``).
"""

from __future__ import annotations

from typing import Annotated, Any, Literal, Self

from pydantic import Field, model_validator

from harness.parameters.base import Parameters

Normal = Literal["hooke", "hertz", "dmt", "jkr", "mdr"]
Damping = Literal["none", "velocity", "mass_velocity", "viscoelastic", "tsuji", "coeff_restitution"]
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

_MATERIAL = ("youngs_modulus", "poisson_ratio")
_SLIDER = ("tangential_damping", "friction")

TAKES: dict[str, dict[str, tuple[str, ...]]] = {
    "normal": {
        "hooke": ("normal_stiffness",),
        "hertz": _MATERIAL,
        "dmt": (*_MATERIAL, "surface_energy"),
        "jkr": (*_MATERIAL, "surface_energy"),
        "mdr": _MATERIAL,
    },
    "damping": {
        **dict.fromkeys(("velocity", "mass_velocity", "viscoelastic"), ("damping_coefficient",)),
        **dict.fromkeys(("tsuji", "coeff_restitution"), ("restitution",)),
    },
    "tangential": {
        "linear_nohistory": _SLIDER,
        "linear_history": ("tangential_stiffness", *_SLIDER),
        "linear_history_classic": ("tangential_stiffness", *_SLIDER),
        "mindlin": _SLIDER,
        "mindlin/force": _SLIDER,
        "mindlin_rescale": _SLIDER,
        "mindlin_rescale/force": _SLIDER,
        "mindlin_classic": _SLIDER,
    },
    "rolling": {"sds": ("rolling_stiffness", "rolling_damping", "rolling_friction")},
    "twisting": {"sds": ("twisting_stiffness", "twisting_damping", "twisting_friction")},
}
"""The coefficients that each submodel takes."""

COHESIVE = ("dmt", "jkr")

_DEFAULTS: dict[str, float] = {
    "normal_stiffness": 1e6,
    "youngs_modulus": 70e9,
    "poisson_ratio": 0.3,
    "surface_energy": 0.1,
    "restitution": 0.9,
    "tangential_stiffness": 2e6 / 7.0,
    "tangential_damping": 0.0,
    "friction": 0.3,
}
"""What a submodel is given where nobody says otherwise; coefficients that are not here must be."""

Positive = Annotated[float, Field(ge=1e-30, le=1e30)]
NotNegative = Annotated[float, Field(ge=0.0, le=1e30)]
"""Far beyond what there is; products of some of them and their powers stay in double precision."""

Friction = Annotated[float, Field(ge=0.0, le=1e9)]
"""Nothing slides from there on; a limit near the largest number overflows, and is never found."""


class ContactLaw(Parameters):
    """The law of one contact, in SI units, for two bodies of one material.

    A coefficient that its submodel does not take is None. Raise RequestError for one that is
    given all the same, and for one that is needed and has no default.
    """

    normal: Normal = Field("hooke", description="[-] elastic normal force")
    normal_stiffness: Positive | None = Field(None, description="[N/m] k_n of hooke")
    youngs_modulus: Positive | None = Field(None, description="[Pa] of hertz, dmt, jkr and mdr")
    poisson_ratio: Annotated[float, Field(gt=-1.0, le=0.5)] | None = Field(
        None, description="[-] of hertz, dmt, jkr and mdr"
    )
    surface_energy: NotNegative | None = Field(
        None, description="[J/m2] gamma of each surface, dmt and jkr; work of adhesion 2 gamma"
    )
    damping: Damping = Field("none", description="[-] rule of the normal dashpot eta_n")
    damping_coefficient: NotNegative | None = Field(
        None,
        description=(
            "[-] eta_0: eta_n = eta_0 (velocity, kg/s), eta_0 m* (mass_velocity, 1/s) or "
            "eta_0 m* a (viscoelastic, 1/(m s)), a the contact radius"
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
        return {name for models in TAKES.values() for names in models.values() for name in names}

    @staticmethod
    def taken(models: dict[str, Any]) -> set[str]:
        """Return the coefficients that submodels take, ``{"normal": "hooke", ...}``."""
        return {name for part in TAKES for name in TAKES[part].get(str(models[part]), ())}

    @model_validator(mode="before")
    @classmethod
    def _fill(cls, given: Any) -> Any:
        """Give coefficients that are taken their default, and drop it of those that are not."""
        if not isinstance(given, dict):
            return given
        models = {part: given.get(part, cls.model_fields[part].default) for part in TAKES}
        values, taken = dict(given), cls.taken(models)
        for name in cls.coefficients() - set(given):
            default = cls.model_fields[name].default
            default = _default(name, models, values) if default is None else default
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
        return self

    def _part_has_its_own(self, part: str, models: dict[str, tuple[str, ...]]) -> None:
        chosen = getattr(self, part)
        mine = models.get(chosen, ())
        others = {name for names in models.values() for name in names} - set(mine)
        for name in sorted(others):
            if getattr(self, name) is not None:
                allowed = ", ".join(model for model, names in models.items() if name in names)
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
        if self.normal == "mdr" and self.damping not in ("none", "velocity"):
            raise ValueError(f"damping = {self.damping!r}: normal = mdr takes none or velocity")
        if self.normal == "mdr" and self.tangential != "none":
            raise ValueError(f"tangential = {self.tangential!r}: normal = mdr takes none")

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
    def tangential_spring(self) -> bool:
        """Return whether the tangential force has a spring."""
        return self.tangential not in ("none", "linear_nohistory")


def _default(name: str, models: dict[str, Any], given: dict[str, Any]) -> float | None:
    """Return the default of a coefficient beside the others; None where there is none."""
    if name == "tangential_stiffness" and given.get("normal_stiffness") is not None:
        return 2.0 * float(given["normal_stiffness"]) / 7.0  # as in _DEFAULTS, to the bit
    if name == "tangential_damping" and models["tangential"] == "linear_nohistory":
        return 1.0
    return _DEFAULTS.get(name)
