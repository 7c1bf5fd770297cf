"""Contact laws: the normal contact of the frictionless cases, and the one law with friction.

The normal contact of a DEM code: linear spring, dashpot, and what becomes of the tail.

The force along the normal is ``k * overlap - eta * separation speed`` with
``eta = 2 * zeta * sqrt(k * m_eff)``. Near the end of a contact it becomes
attractive: the *tail*. A code either keeps the tail or clips it to zero.

The Hertz contact that stands for a linear one, for engines that have no other.

The force along the normal is ``K (delta^(3/2) + A sqrt(delta) d(delta)/dt)`` for an overlap
``delta``: Hertz's spring with the viscous dashpot of Brilliantov, Spahn, Hertzsch and Poeschel,
Phys. Rev. E 53, 5382 (1996), who write 3/2 A where this writes A.

Two conditions make K and A from a stiffness k and a damping ratio zeta. Both are
set at ``overlap``, the largest of an undamped head-on impact at a reference speed v on a fixed
sphere, sqrt(m/k) v with the linear spring.

- The undamped impact reaches the same overlap: 2/5 K overlap^(5/2) = 1/2 k overlap^2, hence
  K = 5/4 k / sqrt(overlap).
- The dashpot's coefficient is the same there: K A sqrt(overlap) = 2 zeta sqrt(k m_eff), hence
  A = 8/5 zeta sqrt(m_eff / k).

The reference speed is sqrt(g d) on the incline. A drop adds the square of its own speed,
so that there is one without gravity too.

The coefficients that each submodel of a contact law takes, and what they are by default.

What of mdr is stated together: its branches, dashpots, and friction beside them.

The law of a contact with friction: normal, damping, tangential, rolling and twisting submodel.

Names and units follow the manual of LAMMPS's pair style granular, formulas the literature:
Johnson, Contact Mechanics (1985); Luding, Granular Matter 10, 235 (2008); Marshall, J. Comput.
Phys. 228, 1541 (2009); Thornton, Cummins and Cleary, Powder Technol. 233, 30 (2013); Zunker and
Kamrin, J. Mech. Phys. Solids 183, 105492 and 105493 (2024). Of their ``mdr`` this is the elastic
branch, yield, and a bulk response from the first touch on, with a constant dashpot (``velocity``)
or one of the stiffness (``mdr``), and with friction; and adhesion, alone.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any, Literal, Self

from pydantic import BeforeValidator, Field, model_validator

from harness.errors import RequestError
from harness.parameters.allowed import Allowed, allowed_in
from harness.parameters.base import Parameters

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


SOURCE = Contact(name="source", restitution=1e-20, damping_ratio=None, tail="attractive")
"""The contact of Harper, Dufek and Breard: e = 1e-20, attractive tail kept."""

CLIPPED = Contact(name="clipped", restitution=0.0, damping_ratio=None, tail="clipped")
"""Critical damping, tail clipped: really rebounds, with e = exp(-2) = 0.135."""

PLASTIC = Contact(name="plastic", restitution=None, damping_ratio=5.0, tail="clipped")
"""Overdamped and clipped: no tail, no rebound; the contact to extrapolate."""

CONTACTS = {contact.name: contact for contact in (SOURCE, CLIPPED, PLASTIC)}


def _by_name(value: Any) -> Any:
    if not isinstance(value, str):
        return value
    if value not in CONTACTS:
        raise ValueError(f"must be one of {', '.join(CONTACTS)}")
    return CONTACTS[value]


NamedContact = Annotated[Contact, BeforeValidator(_by_name)]
"""A contact, or the name of one in ``CONTACTS``."""

Spring = Literal["linear", "Hertz"]
"""The elastic law of a contact's normal force."""


def contact_values(contact: Contact) -> dict[str, str | int | float]:
    """Return what a script is told of a contact: zeta from the restitution (0: critical), or given.

    The same names and units in every engine's scripts.
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
    """Return what scripts allow for the values of a contact."""
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


STIFFEST = 15.0 / 8.0
"""[k] slope of the spring at the reference overlap: 3/2 K sqrt(overlap)."""


@dataclass(frozen=True)
class Hertz:
    """A Hertz contact: ``coefficient`` K [N/m^(3/2)] and ``relaxation`` A [s].

    ``overlap`` [m] is the one at which it stands for the linear contact, ``damping`` [-] is
    A v / overlap, 8/5 zeta.
    """

    coefficient: float
    relaxation: float
    overlap: float
    damping: float

    def rest(self, force: float) -> float:
        """Return the overlap [m] at which the spring bears a force [N]: (F/K)^(2/3)."""
        return float((force / self.coefficient) ** (2.0 / 3.0))

    def most_rebound(self) -> float:
        """Return a bound on the restitution at the reference speed: at most 1.

        The dashpot alone stops the grain at an overlap of (6/5a)^(2/3), and it leaves at
        1/a of it where the clipped force vanishes (a the damping).
        """
        if self.damping <= 1.0:
            return 1.0
        return float((1.2 / self.damping) ** (2.0 / 3.0) / self.damping)

    def slope(self, overlap: float) -> float:
        """Return the stiffness [N/m] of small motions about an overlap: 3/2 K sqrt(overlap)."""
        return 1.5 * self.coefficient * math.sqrt(overlap)

    def damping_ratio(self, overlap: float, mass: float) -> float:
        """Return the damping ratio [-] of small motions of a mass about an overlap."""
        dashpot = self.coefficient * self.relaxation * math.sqrt(overlap)
        return dashpot / (2.0 * math.sqrt(self.slope(overlap) * mass))


def hertz(contact: Contact, stiffness: float, mass: float, speed: float) -> Hertz:
    """Return the Hertz contact for a linear one, at an impact speed [m/s].

    Raise RequestError for a speed of 0: then there is no scale.
    """
    if speed == 0.0:
        raise RequestError(
            "speed = 0.0 m/s: a Hertz contact needs a speed or gravity greater than 0, which "
            "set its scale"
        )
    overlap = speed * math.sqrt(mass / stiffness)
    # A = 8/5 zeta sqrt(m_eff/k), and the effective mass is in the ratio with the whole mass
    damping = 1.6 * contact.zeta_against_full_mass
    relaxation = damping * math.sqrt(mass / stiffness)
    return Hertz(1.25 * stiffness / math.sqrt(overlap), relaxation, overlap, damping)


def fewest_steps_per_contact(contact: Contact) -> float:
    """Return the bound below which v+ = v + h a, x+ = x + h v+ may be unstable in the well.

    Motion normal to the row feels 3/2 of one contact: with the spring at its stiffest
    p = 3 zeta omega h and q = 45/16 (omega h)^2 must keep p + q/2 < 2 (Jury's criterion).
    """
    zeta = contact.zeta_against_full_mass
    half = 0.75 * STIFFEST
    longest = (math.sqrt(9.0 * zeta * zeta + 8.0 * half) - 3.0 * zeta) / (2.0 * half)
    return math.pi / longest


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
        **dict.fromkeys(
            ("velocity", "mass_velocity", "viscoelastic", "mdr"), ("damping_coefficient",)
        ),
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

PARTNER = ("partner_youngs_modulus", "partner_poisson_ratio")
"""The material of the second body, where it is another one."""

MAY_TAKE = {
    "mdr": ("yield_stress", "surface_energy"),
    **dict.fromkeys(("hertz", "dmt", "jkr"), PARTNER),
}
"""Coefficients that a normal force takes where they are given, and has no default for."""

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


def default_of(name: str, models: dict[str, Any], given: dict[str, Any]) -> float | None:
    """Return the default of a coefficient beside the others; None where there is none."""
    if name == "tangential_stiffness" and given.get("normal_stiffness") is not None:
        return 2.0 * float(given["normal_stiffness"]) / 7.0  # as in _DEFAULTS, to the bit
    if name == "tangential_damping" and models["tangential"] == "linear_nohistory":
        return 1.0
    return _DEFAULTS.get(name)


DAMPINGS = ("none", "velocity", "mdr")


def check(law: ContactLaw) -> None:
    """Raise ValueError for what mdr is not stated with, and for what is stated with mdr alone."""
    if law.normal != "mdr":
        if law.bulk_response:
            raise ValueError(
                f"bulk_response = True: normal = {law.normal!r} has none (normal = mdr does)"
            )
        if law.damping == "mdr":
            raise ValueError("damping = 'mdr': needs normal = mdr")
        return
    if law.damping not in DAMPINGS:
        raise ValueError(f"damping = {law.damping!r}: normal = mdr takes none, velocity or mdr")
    if law.bulk_response and law.damping == "mdr":
        raise ValueError(
            "damping = 'mdr': must be none or velocity beside bulk_response = True: its stiffness "
            "is that of the elastic contact, of which the bulk's leaves nothing"
        )
    _resists(law)
    _adheres(law)
    poisson = law.poisson_ratio or 0.0
    if law.lags and not 0.0 <= poisson < 0.5:
        branch = _named(law)[0]
        raise ValueError(
            f"poisson_ratio = {poisson!r}: must be from 0 to below 0.5 beside {branch}: "
            "the bulk modulus must be finite"
        )


def _named(law: ContactLaw) -> list[str]:
    """Return the branches beside the elastic one that a law of mdr has, with their values."""
    given = {
        "yield_stress": law.yield_stress is not None,
        "surface_energy": law.surface_energy is not None,
        "bulk_response": law.bulk_response,
    }
    return [f"{name} = {getattr(law, name)!r}" for name, is_given in given.items() if is_given]


def _resists(law: ContactLaw) -> None:
    """Raise ValueError for rolling or twisting resistance of a sphere that swells or is squeezed.

    Their levers are R* and the contact radius, which no source defines for it.
    """
    for part in ("rolling", "twisting"):
        if law.lags and getattr(law, part) != "none":
            raise ValueError(
                f"{part} = {getattr(law, part)!r}: must be none beside {_named(law)[0]}"
            )


def _adheres(law: ContactLaw) -> None:
    """Raise ValueError for adhesion beside something else.

    The only code with mdr, LAMMPS, is without adhesion in the limit of a small step
    (mdr-adhesion-fades): whatever adhesion is stated with, the comparison would find that alone.
    Besides, a contact that yields begins apart here, as pull-off does not; Coulomb's limit under a
    tension has no definition in the source; a bulk that responds alone leaves no springs that hold.
    """
    if law.surface_energy is None:
        return
    branches = _named(law)
    beside = [
        f"{part} = {getattr(law, part)!r}"
        for part in ("damping", "tangential", "rolling", "twisting")
        if getattr(law, part) != "none"
    ]
    others = [one for one in branches if not one.startswith("surface_energy")] + beside
    if others:
        raise ValueError(
            f"surface_energy = {law.surface_energy!r}: normal = mdr is stated with it alone, not "
            f"beside {others[0]}: LAMMPS's adhesion fades with the step (mdr-adhesion-fades), so "
            "that nothing could be held against it"
        )


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
        check(self)
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
