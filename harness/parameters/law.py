"""Contact laws: spring, dashpot and friction of a contact, in SI units.

:class:`ContactLaw` is the law with friction: a normal, damping, tangential, rolling and twisting
submodel, which :mod:`harness.parameters.submodels` lists, and their coefficients.

:class:`Contact` is the dissipation of the frictionless cases, whose spring is theirs. The force
along the normal is ``k * overlap - eta * separation speed`` with ``eta = 2 * zeta * sqrt(k *
m_eff)``; near the end of a contact it becomes attractive, the *tail*, which a code keeps or clips
to zero.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Annotated, Any, Literal, Self

from pydantic import BeforeValidator, Field, model_validator

from harness.parameters.allowed import Allowed, allowed_in
from harness.parameters.base import Parameters
from harness.parameters.submodels import (
    COEFFICIENTS,
    DAMPING,
    SUBMODELS,
    Damping,
    Dashpot,
    Normal,
    Rolling,
    Submodel,
    Tangential,
    Twisting,
    dashpot_coefficient,
)

Tail = Literal["attractive", "clipped"]
EffectiveMass = Literal["full", "half"]


class Contact(Parameters):
    """Dissipation of the linear spring-dashpot contact.

    ``damping_ratio`` wins over ``restitution`` when both are given, as on the
    command line. Restitution 0 is critical damping.
    """

    name: str = Field("custom", description="[-] what reports call this contact")
    restitution: Annotated[float, Field(ge=0.0, le=1.0)] | None = Field(
        None, description="[-] nominal coefficient of restitution"
    )
    damping_ratio: Annotated[float, Field(ge=0.0, le=100.0)] | None = Field(
        None, description="[-] zeta, 1 is critical damping"
    )
    tail: Tail = Field("attractive", description="[-] rule for the attractive tail")
    effective_mass: EffectiveMass = Field(
        "full", description="[-] against a fixed sphere: m (full) or m/2 (half)"
    )

    @model_validator(mode="after")
    def _has_damping(self) -> Contact:
        if self.restitution is None and self.damping_ratio is None:
            raise ValueError("a contact needs a restitution (0 to 1) or a damping ratio (0 to 100)")
        return self

    def replace(self, **changes: Any) -> Self:
        """Return a copy with ``changes``; a restitution alone takes the damping ratio's place."""
        if changes.get("restitution") is not None:
            changes.setdefault("damping_ratio", None)
        return super().replace(**changes)

    @property
    def stated_restitution(self) -> float | None:
        """Return the restitution that states the damping, None where a damping ratio does."""
        return self.restitution if self.damping_ratio is None else None

    @property
    def mass_text(self) -> str:
        """Return the effective mass against a fixed sphere, as reports write it."""
        return "m" if self.effective_mass == "full" else "m/2"

    @property
    def zeta(self) -> float:
        """Return the damping ratio: |ln e| / sqrt(pi^2 + ln^2 e), 1 for e = 0 (critical)."""
        if self.damping_ratio is not None:
            return self.damping_ratio
        assert self.restitution is not None
        if self.restitution == 0.0:
            return 1.0
        logarithm = abs(math.log(self.restitution))
        return logarithm / math.hypot(math.pi, logarithm)

    @property
    def zeta_against_full_mass(self) -> float:
        """Return eta / (2 sqrt(k m)): the damping ratio of the grain on a fixed sphere.

        A code that takes m/2 for the effective mass damps less than it says.
        """
        return self.zeta * (math.sqrt(0.5) if self.effective_mass == "half" else 1.0)

    def dashpot(self, stiffness: float, mass: float) -> float:
        """Return eta = 2 zeta sqrt(k m_eff) [N s/m] of a stiffness [N/m] and a mass [kg]."""
        shared = 0.5 if self.effective_mass == "half" else 1.0
        return 2.0 * self.zeta * math.sqrt(stiffness * mass * shared)

    def law(self, stiffness: float, mass: float) -> ContactLaw:
        """Return the law of spheres of a stiffness [N/m] and a mass [kg]: hooke, no friction."""
        return ContactLaw.model_construct(  # a drop's units may be beyond the bounds of a law
            normal_stiffness=stiffness,
            damping="velocity",
            damping_coefficient=self.dashpot(stiffness, mass),
            clipped=self.tail == "clipped",
        )


SOURCE = Contact(name="source", restitution=1e-20, damping_ratio=None, tail="attractive")
"""The contact of Harper, Dufek and Breard: e = 1e-20, attractive tail kept."""

CLIPPED = Contact(name="clipped", restitution=0.0, damping_ratio=None, tail="clipped")
"""Critical damping, tail clipped: really rebounds, with e = exp(-2) = 0.135."""

PLASTIC = Contact(name="plastic", restitution=None, damping_ratio=5.0, tail="clipped")
"""Overdamped and clipped: no tail, no rebound; the contact to extrapolate."""

CONTACTS = {contact.name: contact for contact in (SOURCE, CLIPPED, PLASTIC)}


def _contact_by_name(value: Any) -> Any:
    if not isinstance(value, str):
        return value
    if value not in CONTACTS:
        raise ValueError(f"must be one of {', '.join(CONTACTS)}")
    return CONTACTS[value]


NamedContact = Annotated[Contact, BeforeValidator(_contact_by_name)]
"""A contact, or the name of one in ``CONTACTS``."""


def contact_values(contact: Contact) -> dict[str, str | int | float]:
    """Return the values that scripts take for a contact: zeta from the restitution, or given.

    Names and units are the same in every engine's scripts; restitution 0 is critical damping.
    """
    by_ratio = contact.damping_ratio is not None
    return {
        "damping": "ratio" if by_ratio else "restitution",
        "restitution": float(contact.restitution or 0.0),
        "damping_ratio": contact.zeta if by_ratio else 1.0,
        "effective_mass": contact.effective_mass,
        "tail": contact.tail,
    }


def contact_allowed() -> dict[str, Allowed]:
    """Return the range of each of the values that scripts take for a contact."""
    return {"damping": Allowed(words=("restitution", "ratio")), **allowed_in(Contact)}


def contact_of(values: Mapping[str, Any], name: str = "custom") -> Contact:
    """Return the contact that a script's values state, the inverse of :func:`contact_values`."""
    by_ratio = values["damping"] == "ratio"
    return Contact(
        name=name,
        restitution=None if by_ratio else values["restitution"],
        damping_ratio=values["damping_ratio"] if by_ratio else None,
        tail=values["tail"],
        effective_mass=values["effective_mass"],
    )


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
        description=f"[-] {dashpot_coefficient()}",
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

    @staticmethod
    def taken(models: Mapping[str, Any]) -> set[str]:
        """Return the coefficients that submodels take, ``{"normal": "hooke", ...}``."""
        return {name for row in _rows(models) for name in row.coefficients}

    @model_validator(mode="before")
    @classmethod
    def _fill(cls, data: Any) -> Any:
        """Give coefficients that are taken their default, and drop it of those that are not."""
        if not isinstance(data, dict):
            return data
        models = {part: data.get(part, cls.model_fields[part].default) for part in SUBMODELS}
        values, taken = dict(data), cls.taken(models)
        optional = {name for row in _rows(models) for name in row.may_take}
        for name in COEFFICIENTS - set(data):
            default = cls.model_fields[name].default
            if default is None and name not in optional:
                default = _default(name, models, values)
            values[name] = default if name in taken else None
        return values

    @model_validator(mode="after")
    def _fits(self) -> Self:
        for part, rows in SUBMODELS.items():
            self._check_coefficients(part, rows)
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
        if self.normal not in self.dashpot.normals:
            *others, last = self.dashpot.normals
            allowed = f"{', '.join(others)} or {last}" if others else last
            raise ValueError(
                f"damping = {self.damping!r}: needs normal = {allowed}, not {self.normal!r}"
            )
        if self.normal in COHESIVE and self.clipped:
            raise ValueError(f"clipped = True: normal = {self.normal!r} attracts (must be False)")
        if self.normal == "mdr":
            _check_mdr(self)
        elif self.bulk_response:
            raise ValueError(
                f"bulk_response = True: normal = {self.normal!r} has none (normal = mdr does)"
            )
        return self

    def _check_coefficients(self, part: str, rows: Mapping[str, Submodel]) -> None:
        """Raise ValueError for a coefficient that a submodel needs, or that only others take."""
        model = getattr(self, part)
        row = rows.get(model, Submodel(""))
        coefficients = {name for submodel in rows.values() for name in submodel.coefficients}
        for name in sorted(coefficients.difference(row.coefficients)):
            if (value := getattr(self, name)) is not None:
                takers = ", ".join(n for n, other in rows.items() if name in other.coefficients)
                raise ValueError(
                    f"{name} = {value!r}: {part} = {model!r} takes none ({part} = {takers} does)"
                )
        for name in row.takes:
            if getattr(self, name) is None:
                raise ValueError(f"{part} = {model!r}: needs {name}")

    def replace(self, **changes: Any) -> Self:
        """Return a copy with ``changes``; coefficients of submodels that are left are dropped."""
        models = {part: changes.get(part, getattr(self, part)) for part in SUBMODELS}
        dropped = COEFFICIENTS - self.taken(models)
        kept = {name: value for name, value in self if name not in dropped and value is not None}
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
    def dashpot(self) -> Dashpot:
        """Return the data of its damping."""
        return DAMPING[self.damping]

    @property
    def linear(self) -> bool:
        """Return whether its normal force is that of a linear spring and a constant dashpot."""
        return self.normal == "hooke" and self.dashpot.growth("hooke") == 0.0

    @property
    def lags(self) -> bool:
        """Return whether its force rests on a state that codes bring on step by step, behind it."""
        return self.normal == "mdr" and (self.yield_stress is not None or self.bulk_response)

    @property
    def tangential_spring(self) -> bool:
        """Return whether the tangential force has a spring."""
        return self.tangential not in ("none", "linear_nohistory")


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
"""Of coefficients that need not be given."""


def _rows(models: Mapping[str, Any]) -> list[Submodel]:
    """Return the data of the submodels that are there, of ``{"normal": "hooke", ...}``."""
    names = {part: str(models[part]) for part in SUBMODELS}
    return [rows[names[part]] for part, rows in SUBMODELS.items() if names[part] in rows]


def _default(name: str, models: Mapping[str, Any], values: Mapping[str, Any]) -> float | None:
    """Return the default of a coefficient beside the others; None where there is none."""
    if name == "tangential_stiffness" and values.get("normal_stiffness") is not None:
        return 2.0 * float(values["normal_stiffness"]) / 7.0  # as in _DEFAULTS, to the bit
    if name == "tangential_damping" and models["tangential"] == "linear_nohistory":
        return 1.0
    return _DEFAULTS.get(name)


# ---- mdr: of Zunker and Kamrin's law this has the elastic branch, yield, and a bulk response from
# the first touch on, with a constant dashpot (velocity) or one of the stiffness (mdr) and with
# friction; and adhesion, alone.


def _check_mdr(law: ContactLaw) -> None:
    """Raise ValueError for what the branches of mdr are not stated with.

    A sphere that swells or is squeezed has no rolling or twisting resistance: their levers are R*
    and the contact radius, which no source defines for it. Adhesion is alone: the only code with
    mdr, LAMMPS, is without it in the limit of a small step (mdr-adhesion-fades), and whatever
    adhesion is stated with, the comparison would find that alone. Besides, a contact that yields
    begins apart here, as pull-off does not; Coulomb's limit under a tension has no definition in
    the source; a bulk that responds alone leaves no springs that hold.
    """
    values = {name: getattr(law, name) for name in ("yield_stress", "surface_energy")}
    branches = [f"{name} = {value!r}" for name, value in values.items() if value is not None]
    branches += ["bulk_response = True"] if law.bulk_response else []
    if law.bulk_response and law.damping == "mdr":
        raise ValueError(
            "damping = 'mdr': must be none or velocity beside bulk_response = True: its stiffness "
            "is that of the elastic contact, of which the bulk's leaves nothing"
        )
    parts = [p for p in SUBMODELS if p != "normal" and getattr(law, p) != "none"]
    settings = {part: f"{part} = {getattr(law, part)!r}" for part in parts}
    for part in ("rolling", "twisting"):
        if law.lags and part in settings:
            raise ValueError(f"{settings[part]}: must be none beside {branches[0]}")
    others = [text for text in branches if not text.startswith("surface_energy")]
    others += settings.values()
    if law.surface_energy is not None and others:
        raise ValueError(
            f"surface_energy = {law.surface_energy!r}: normal = mdr is stated with it alone, not "
            f"beside {others[0]}: LAMMPS's adhesion fades with the step (mdr-adhesion-fades), so "
            "that nothing could be held against it"
        )
    if law.lags and not 0.0 <= (law.poisson_ratio or 0.0) < 0.5:
        raise ValueError(
            f"poisson_ratio = {law.poisson_ratio!r}: must be from 0 to below 0.5 beside "
            f"{branches[0]}: the bulk modulus must be finite"
        )
