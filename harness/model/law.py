"""Contact laws: elastic force, dashpot, friction, rolling, twisting and heat of a contact.

Names and units follow the manual of LAMMPS's pair style granular. Sources of the formulas:
Johnson, Contact Mechanics (1985); Derjaguin, Muller and Toporov, J. Colloid Interface Sci. 53, 314
(1975); Johnson, Kendall and Roberts, Proc. R. Soc. A 324, 301 (1971); Tsuji, Tanaka and Ishida,
Powder Technol. 71, 239 (1992); Brilliantov et al., Phys. Rev. E 53, 5382 (1996); Luding, Granular
Matter 10, 235 (2008); Marshall, J. Comput. Phys. 228, 1541 (2009); Ai, Chen, Rotter and Ooi,
Powder Technol. 206, 269 (2011), whose model A is the constant torque of rolling, sds model C;
Thornton, Cummins and Cleary, Powder Technol. 233, 30 (2013); Zunker and Kamrin, J. Mech. Phys.
Solids 183, 105492 and 105493 (2024).

Symbols: m* effective mass, R* effective radius, E* and G* effective moduli, a contact radius, d
overlap, F elastic force, n normal, w angular velocity.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from contextlib import suppress
from functools import cache
from typing import Annotated, Any, Literal, NamedTuple, Self

from pydantic import (
    BeforeValidator,
    Field,
    SerializerFunctionWrapHandler,
    model_serializer,
    model_validator,
)

from harness.model.base import NotNegative, Parameters, Positive, unit, unit_size
from harness.model.conventions import Mean, mean

Normal = Literal["hooke", "hertz", "dmt", "jkr", "mdr"]
Damping = Literal[
    "none", "velocity", "mass_velocity", "damping_ratio", "viscoelastic", "tsuji",
    "coeff_restitution", "mdr",
]  # fmt: skip
Tangential = Literal[
    "none", "linear_nohistory", "linear_history", "linear_history_classic", "mindlin",
    "mindlin/force", "mindlin_rescale", "mindlin_rescale/force", "mindlin_classic",
]  # fmt: skip
Tail = Literal["attractive", "clipped"]
EffectiveMass = Literal["full", "half"]
NO_SPRING = "linear_nohistory"
Poisson = Annotated[float, Field(gt=-1.0, le=0.5)]
Share = Annotated[float, Field(ge=0.0, le=1.0)]
Friction = Annotated[float, Field(ge=0.0, le=1e9)]  # nothing slides from there on


class Submodel(NamedTuple):
    """A part of a law: its formula, the coefficients it needs, and those it may have.

    A normal dashpot is c m*^p a^q (m* F / d)^(s/2) [kg/s] by its ``powers`` p, q, s, and goes with
    the elastic forces ``normals``.
    """

    formula: str
    needs: tuple[str, ...] = ()
    may_have: tuple[str, ...] = ()
    powers: tuple[int, int, int] = (0, 0, 0)
    normals: tuple[str, ...] = ("hooke", "hertz", "dmt", "jkr")

    @property
    def names(self) -> tuple[str, ...]:
        """Return the coefficients that it takes."""
        return (*self.needs, *self.may_have)


Table = Mapping[str, Submodel]
_MATERIAL = ("youngs_modulus", "poisson_ratio")
_PARTNER = ("partner_youngs_modulus", "partner_poisson_ratio")
_SLIDER = ("tangential_damping", "friction")
_RETURN, _GRIP = ("partner_restitution",), ("partner_friction",)  # of the second body
_LINEAR, _MINDLIN = ("tangential_stiffness", *_SLIDER), ("tangential_modulus", *_GRIP)
_STICKY, _FACTOR, _AIM = (*_MATERIAL, "surface_energy"), ("damping_coefficient",), ("restitution",)
_ANY = ("hooke", "hertz", "dmt", "jkr", "mdr")

# fmt: off
NORMAL: Table = {
    "hooke": Submodel("F = k_n d", ("normal_stiffness",)),
    "hertz": Submodel("F = 4/3 E* a d, a = sqrt(R* d), 1/E* = sum (1 - nu^2) / E; or F = K a d",
                      _MATERIAL, ("normal_modulus", *_PARTNER)),
    "dmt": Submodel("F = 4/3 E* a d - 4 pi gamma R*, a = sqrt(R* d)", _STICKY, _PARTNER),
    "jkr": Submodel("F = 4 E* a^3 / (3 R*) - 4 sqrt(pi gamma E* a^3), "
                    "d = a^2 / R* - 2 sqrt(pi gamma a / E*)", _STICKY, _PARTNER),
    "mdr": Submodel("each side on a rigid flat: F = E' A B / 4 (t - sin t cos t), "
                    "cos t = 1 - 2 d / A, A = 2 B = 4 R, E' = E / (1 - nu^2); besides yield, "
                    "growth, bulk response and adhesion",
                    _MATERIAL, ("yield_stress", "surface_energy", "bulk_share")),
}
DAMPING: Table = {
    "none": Submodel("eta = 0", normals=_ANY),
    "velocity": Submodel("eta = c", _FACTOR, normals=_ANY),
    "mass_velocity": Submodel("eta = c m*", _FACTOR, powers=(1, 0, 0)),
    "damping_ratio": Submodel("eta = 2 c sqrt(m* k_n)", _FACTOR, (), (0, 0, 1), ("hooke",)),
    "viscoelastic": Submodel("eta = c m* a", _FACTOR, powers=(1, 1, 0)),
    "tsuji": Submodel("eta = alpha(e) sqrt(2 m* F / d)", _AIM, _RETURN, (0, 0, 1), ("hertz",)),
    "coeff_restitution": Submodel(
        "eta = 2 zeta(e) sqrt(m* k_n) of hooke, sqrt(5) zeta(e) sqrt(m* F / d) of hertz, "
        "zeta = -ln e / sqrt(pi^2 + ln^2 e)", _AIM, _RETURN, (0, 0, 1),
        ("hooke", "hertz")),
    "mdr": Submodel("eta = c sqrt(m* k), k = 2 E' a at a wall and E' a between spheres", _FACTOR,
                    normals=("mdr",)),
}
TANGENTIAL: Table = {
    "linear_nohistory": Submodel("dashpot eta_t = x_t eta alone", _SLIDER, _GRIP),
    "linear_history": Submodel("spring k_t q of the displacement q", _LINEAR, _GRIP),
    "linear_history_classic": Submodel(
        "spring k_t q, projected after it has grown", _LINEAR, _GRIP),
    "mindlin": Submodel("spring 8 G* a q, 1/G* = sum 2 (2 - nu) (1 + nu) / E", _SLIDER, _MINDLIN),
    "mindlin/force": Submodel("force that grows by 8 G* a dq", _SLIDER, _MINDLIN),
    "mindlin_rescale": Submodel("mindlin; q shrinks with a as it opens", _SLIDER, _MINDLIN),
    "mindlin_rescale/force": Submodel("mindlin/force, which shrinks with a", _SLIDER, _MINDLIN),
    "mindlin_classic": Submodel("mindlin, projected after it has grown", _SLIDER, _MINDLIN),
}
ROLLING: Table = {
    "sds": Submodel("spring and dashpot of the velocity R* (w_i - w_j) x n, at most mu_r R* |F_n|",
                    ("rolling_stiffness", "rolling_damping", "rolling_friction")),
    "constant": Submodel("torque mu_r R* |F_n| against w_i - w_j across n", ("rolling_friction",)),
}
TWISTING: Table = {
    "sds": Submodel("spring and dashpot of the angle about n, at most mu_w |F_n|",
                    ("twisting_stiffness", "twisting_damping", "twisting_friction")),
    "marshall": Submodel("spring k_t a^2 / 2, dashpot eta_t a^2 / 2, at most 2/3 a mu |F_n|"),
}
HEAT: Table = {
    "radius": Submodel("2 k a (T_j - T_i), Carslaw and Jaeger (1959), 8.2", ("conductance",)),
    "area": Submodel("h pi a^2 (T_j - T_i)", ("conductance",)),
}
SUBMODELS: Mapping[str, Table] = {
    "normal": NORMAL, "damping": DAMPING, "tangential": TANGENTIAL, "rolling": ROLLING,
    "twisting": TWISTING, "heat": HEAT,
}
# fmt: on


class Law(Parameters):
    """The law of a contact of two bodies of one material, or of two.

    A coefficient that no submodel takes is None. Raise CombinationError for one that is given all
    the same, and for one that is needed and has no default.
    """

    # fmt: off
    normal: Normal = Field("hooke", description="[-] elastic normal force")
    normal_stiffness: Positive | None = Field(None, description="[N/m] k_n of hooke")
    normal_modulus: Positive | None = Field(
        None, description="[Pa] K of hertz, in place of a material: 4/3 E*")
    youngs_modulus: Positive | None = Field(None, description="[Pa] E of hertz, dmt, jkr and mdr")
    poisson_ratio: Poisson | None = Field(None, description="[-] nu of hertz, dmt, jkr and mdr")
    partner_youngs_modulus: Positive | None = Field(
        None, description="[Pa] E of the second body, that of the first unless given")
    partner_poisson_ratio: Poisson | None = Field(
        None, description="[-] nu of the second body, that of the first unless given")
    surface_energy: NotNegative | None = Field(
        None, description="[J/m2] gamma of each surface of dmt and jkr, of sphere and flat of mdr")
    yield_stress: Positive | None = Field(
        None, description="[Pa] Y of mdr, which stays elastic unless given")
    bulk_share: Share | None = Field(
        None, description="[-] psi_b of mdr: the bulk responds below this share of free surface")
    damping: Damping = Field("none", description="[-] normal dashpot eta")
    damping_coefficient: NotNegative | None = Field(
        None, description="[-] c: kg/s of velocity, 1/s of mass_velocity, 1/(m s) of viscoelastic, "
        "a pure number of damping_ratio and mdr")
    restitution: Annotated[float, Field(ge=1e-6, le=1.0)] | None = Field(
        None, description="[-] e that tsuji and coeff_restitution are made for")
    partner_restitution: Annotated[float, Field(ge=1e-6, le=1.0)] | None = Field(
        None, description="[-] e of the second body; a code mixes it with that of the first")
    clipped: bool = Field(False, description="[-] no attraction at the end of a contact")
    tangential: Tangential = Field("none", description="[-] tangential force")
    tangential_stiffness: Positive | None = Field(None, description="[N/m] k_t of linear springs")
    tangential_modulus: Positive | None = Field(
        None, description="[Pa] of Mindlin's springs, in place of 8 G*")
    tangential_damping: NotNegative | None = Field(
        None, description="[-] x_t: tangential over normal dashpot")
    friction: Friction | None = Field(None, description="[-] Coulomb's mu")
    partner_friction: Friction | None = Field(
        None, description="[-] mu of the second body; a code mixes it with that of the first")
    rolling: Literal["none", "sds", "constant"] = Field(
        "none", description="[-] rolling resistance")
    rolling_stiffness: Positive | None = Field(None, description="[N/m] of the rolling spring")
    rolling_damping: NotNegative | None = Field(None, description="[kg/s] of the rolling dashpot")
    rolling_friction: Friction | None = Field(None, description="[-] mu_r")
    twisting: Literal["none", "sds", "marshall"] = Field(
        "none", description="[-] twisting resistance")
    twisting_stiffness: Positive | None = Field(None, description="[N m] per radian, of sds")
    twisting_damping: NotNegative | None = Field(None, description="[N m s] per radian, of sds")
    twisting_friction: Friction | None = Field(None, description="[m] mu_w of sds")
    heat: Literal["none", "radius", "area"] = Field("none", description="[-] conduction of heat")
    conductance: Positive | None = Field(
        None, description="[-] k of radius in W/m/K, h of area in W/m2/K")
    interface: Literal["current", "old"] = Field(
        "current", description="[-] old: written in an engine's earlier contact styles")
    # fmt: on

    @classmethod
    def linear(cls, stiffness: float, damping_ratio: float, clipped: bool) -> Law:
        """Return a linear spring k [N/m] and dashpot 2 zeta sqrt(k m*) without friction."""
        dashpot = {"damping": "damping_ratio", "damping_coefficient": damping_ratio}
        return cls(normal_stiffness=stiffness, clipped=clipped, **dashpot)

    @model_validator(mode="before")
    @classmethod
    def _set_defaults(cls, data: Any) -> Any:
        if not isinstance(data, dict):
            return data
        fields = cls.model_fields
        values = {n: value for n, value in data.items() if value is not None or n not in fields}
        models = {part: values.get(part, fields[part].default) for part in SUBMODELS}
        needed = {name for row in _rows(models) for name in row.needs}
        if "normal_modulus" in values:
            needed -= {*_MATERIAL}
        k, is_dashpot = values.get("normal_stiffness", 1e6), models["tangential"] == NO_SPRING
        with suppress(TypeError, ValueError):  # of a stiffness that is refused by its name
            k = 2.0 * float(k) / 7.0
        defaults = {
            "normal_stiffness": 1e6, "youngs_modulus": 70e9, "poisson_ratio": 0.3,
            "surface_energy": 0.1, "restitution": 0.9, "friction": 0.3,
            "tangential_damping": 1.0 if is_dashpot else 0.0,
            "tangential_stiffness": k,
        }  # fmt: skip
        return {**{n: value for n, value in defaults.items() if n in needed}, **values}

    @model_serializer(mode="wrap")
    def _without_absent_partner(self, dump: SerializerFunctionWrapHandler) -> dict[str, Any]:
        """Keep the digests of scenes without coefficients of a second body."""
        fields: dict[str, Any] = dump(self)
        absent = {name for name in (*_RETURN, *_GRIP) if fields[name] is None}
        return {name: value for name, value in fields.items() if name not in absent}

    @model_validator(mode="after")
    def _check_coefficients(self) -> Self:
        for part, rows in SUBMODELS.items():
            model = getattr(self, part)
            for name, other in _foreign(part, model).items():
                if (value := getattr(self, name)) is not None:
                    raise ValueError(
                        f"{name} = {value!r}: belongs to {part} = {other!r}, not to {model!r}"
                    )
            for name in rows.get(model, Submodel("")).needs:
                replaced = name in _MATERIAL and self.normal_modulus is not None
                if getattr(self, name) is None and not replaced:
                    raise ValueError(f"{name}: must be given with {part} = {model!r}")
        return self

    @model_validator(mode="after")
    def _check_partners(self) -> Self:
        allowed, mindlin = DAMPING[self.damping].normals, "mindlin" in self.tangential
        has_modulus = self.moduli is not None or self.tangential_modulus is not None
        compresses = self.yield_stress or self.bulk_share
        for message, is_wrong in {
            "normal_modulus: must not be given beside youngs_modulus":
                self.normal_modulus is not None and self.youngs_modulus is not None,
            f"damping = {self.damping!r}: needs normal = {', '.join(allowed)}":
                self.normal not in allowed,
            f"tangential = {NO_SPRING!r}: needs a damping, it is a dashpot":
                self.tangential == NO_SPRING and self.damping == "none",
            f"tangential = {self.tangential!r}: needs a material (normal = hertz, dmt, jkr or "
            "mdr with youngs_modulus) or tangential_modulus beside normal = hertz":
                mindlin and (self.normal == "hooke" or not has_modulus),
            "twisting = 'marshall': needs a tangential spring (linear_history, mindlin, ...)":
                self.twisting == "marshall" and not self.has_spring,
            f"partner_friction = {self.partner_friction!r}: normal = 'mdr' has one material":
                self.normal == "mdr" and self.partner_friction is not None,
            f"clipped = True: must be False, normal = {self.normal!r} attracts":
                self.normal in ("dmt", "jkr") and self.clipped,
            "poisson_ratio = 0.5: must be less, yield and bulk response compress":
                (self.poisson_ratio or 0.0) >= 0.5 and compresses,
        }.items():  # fmt: skip
            if is_wrong:
                raise ValueError(message)
        return self

    def replace(self, **changes: Any) -> Self:
        """Return a copy with changed fields, without coefficients of submodels that went."""
        models = {part: changes.get(part, getattr(self, part)) for part in SUBMODELS}
        names = {name for row in _rows(models) for name in row.names}
        material = {*_MATERIAL, *_PARTNER}
        dropped = material if changes.get("normal_modulus") else set()
        dropped |= {"normal_modulus"} if any(changes.get(name) for name in material) else set()
        kept = {n: v for n, v in self if n not in COEFFICIENTS or n in names - dropped}
        return type(self)(**{**kept, **changes})

    @property
    def has_spring(self) -> bool:
        """Return whether the tangential force has a spring."""
        return self.tangential not in ("none", NO_SPRING)

    @property
    def materials(self) -> tuple[tuple[float, float], tuple[float, float]] | None:
        """Return E [Pa] and nu of both bodies, None without a material."""
        young, poisson = self.youngs_modulus, self.poisson_ratio
        if young is None or poisson is None:
            return None
        other, its = self.partner_youngs_modulus, self.partner_poisson_ratio
        second = (young if other is None else other, poisson if its is None else its)
        return (young, poisson), second

    @property
    def two_materials(self) -> bool:
        """Return whether the second body has moduli or coefficients of its own."""
        return any(getattr(self, name) is not None for name in (*_PARTNER, *_RETURN, *_GRIP))

    @property
    def two_moduli(self) -> bool:
        """Return whether the second body has moduli of its own."""
        return any(getattr(self, name) is not None for name in _PARTNER)

    @property
    def moduli(self) -> tuple[float, float] | None:
        """Return E* and G* [Pa] of both bodies (Johnson 1985, 4.3 and 7.43), None without any."""
        if (materials := self.materials) is None:
            return None
        normal = sum((1.0 - nu**2) / young for young, nu in materials)
        shear = sum(2.0 * (2.0 - nu) * (1.0 + nu) / young for young, nu in materials)
        return 1.0 / normal, 1.0 / shear

    @property
    def effective_modulus(self) -> float:
        """Return E* [Pa]: of a material, or 3/4 K."""
        moduli = self.moduli
        return moduli[0] if moduli else 0.75 * (self.normal_modulus or 0.0)

    @property
    def one_material(self) -> Law:
        """Return the law of the one material with the E* and G* of both, e and mu mixed.

        G*/E* = (1 - nu) / (2 (2 - nu)) of two equal bodies gives nu.
        """
        law = self.mixed("geometric", "geometric")
        if law.moduli is None or not law.two_moduli:
            return law
        ratio = law.moduli[1] / law.moduli[0]
        nu = (1.0 - 4.0 * ratio) / (1.0 - 2.0 * ratio)
        material = {"youngs_modulus": 2.0 * (1.0 - nu**2) * law.moduli[0], "poisson_ratio": nu}
        return law.replace(**material, **dict.fromkeys(_PARTNER))

    def mixed(self, restitution: Mean, friction: Mean) -> Law:
        """Return the law with restitution and friction of the pair, by the means of a code."""
        if self.partner_restitution is None and self.partner_friction is None:
            return self
        return self.replace(
            restitution=mean(restitution, self.restitution, self.partner_restitution),
            friction=mean(friction, self.friction, self.partner_friction),
            **dict.fromkeys((*_RETURN, *_GRIP)),
        )

    @property
    def of_each(self) -> tuple[Law, Law]:
        """Return the laws of the first and of the second body, each with itself."""
        of_partner = dict.fromkeys((*_PARTNER, *_RETURN, *_GRIP))
        values = {n: v for n in of_partner if (v := getattr(self, n)) is not None}
        theirs = {name.removeprefix("partner_"): value for name, value in values.items()}
        return self.replace(**of_partner), self.replace(**of_partner, **theirs)

    def stiffness(self, radius: float, overlap: float) -> float:
        """Return the slope [N/m] of the elastic force without adhesion, of R* [m] and d [m]."""
        if self.normal_stiffness is not None:
            return self.normal_stiffness
        return 2.0 * self.effective_modulus * math.sqrt(radius * overlap)

    def dashpot(self, mass: float, radius: float, overlap: float) -> float:
        """Return the normal dashpot eta [kg/s] of m* [kg], R* [m] and an overlap [m].

        tsuji is taken for coeff_restitution of hertz, which has the same restitution.
        """
        k, (p, q, s) = self.stiffness(radius, overlap), DAMPING[self.damping].powers
        e = mean("geometric", self.restitution, self.partner_restitution)
        factor = (self.damping_coefficient or 0.0) if e is None else damping_ratio(e)
        if self.damping == "mdr":
            return factor * math.sqrt(mass * k)
        if s:
            factor *= 2.0 if self.normal == "hooke" else math.sqrt(5.0)
        secant = k if self.normal == "hooke" else k / 1.5  # F / d
        contact_radius = math.sqrt(radius * overlap)
        return factor * mass**p * contact_radius**q * math.sqrt(mass * secant) ** s

    def in_units(self, length: float, mass: float, time: float) -> Law:
        """Return the law in other units [m, kg, s]; conductances stay, heat has its own."""
        sizes = {n: unit_size(unit(Law, n), length, mass, time) for n in COEFFICIENTS}
        if self.damping != "mdr":  # where the coefficient is a pure number
            p, q, s = DAMPING[self.damping].powers
            sizes["damping_coefficient"] = length**-q * mass ** (1 - p - s) * time ** (s - 1)
        return self.replace(**{n: v / sizes[n] for n, v in self if n in sizes and v is not None})


COEFFICIENTS = frozenset(
    name for table in SUBMODELS.values() for row in table.values() for name in row.names
)


def damping_ratio(restitution: float) -> float:
    """Return zeta = -ln e / sqrt(pi^2 + ln^2 e) of a restitution e [-], 1 for e = 0."""
    if restitution == 0.0:
        return 1.0
    logarithm = math.log(restitution)
    return -logarithm / math.hypot(math.pi, logarithm)


@cache
def _foreign(part: str, model: str) -> dict[str, str]:
    """Return the coefficients of a part that a submodel does not take, with the first that does."""
    rows, names = SUBMODELS[part], dict[str, str]()
    for other, name in ((o, n) for o, row in rows.items() for n in row.names):
        names.setdefault(name, other)
    taken = rows[model].names if model in rows else ()
    return {name: other for name, other in names.items() if name not in taken}


def _rows(models: Mapping[str, Any]) -> list[Submodel]:
    named = ((rows, str(models[part])) for part, rows in SUBMODELS.items())  # as yet unchecked
    return [rows[name] for rows, name in named if name in rows]


# ---- contacts without friction, in the words of the parameters of cases


class Contact(Parameters):
    """Dissipation of a linear spring-dashpot contact.

    A damping ratio wins over a restitution. Restitution 0 is critical damping. Near its end a
    contact attracts: the *tail*, which a code keeps or clips to zero.
    """

    # fmt: off
    name: str = Field("custom", description="[-] what reports call this contact")
    restitution: Annotated[float, Field(ge=0.0, le=1.0)] | None = Field(
        None, description="[-] nominal coefficient of restitution")
    damping_ratio: Annotated[float, Field(ge=0.0, le=100.0)] | None = Field(
        None, description="[-] zeta, 1 is critical damping")
    tail: Tail = Field("attractive", description="[-] rule for the attractive tail")
    effective_mass: EffectiveMass = Field(
        "full", description="[-] against a fixed sphere: m (full) or m/2 (half)")
    # fmt: on

    @model_validator(mode="after")
    def _has_damping(self) -> Self:
        if self.restitution is None and self.damping_ratio is None:
            raise ValueError("a contact needs a restitution (0 to 1) or a damping ratio (0 to 100)")
        return self

    def replace(self, **changes: Any) -> Self:
        """Return a copy with ``changes``; a restitution alone replaces the damping ratio."""
        if changes.get("restitution") is not None:
            changes.setdefault("damping_ratio", None)
        return super().replace(**changes)

    @property
    def clipped(self) -> bool:
        """Return whether a parting contact never attracts."""
        return self.tail == "clipped"

    @property
    def zeta(self) -> float:
        """Return the damping ratio: |ln e| / sqrt(pi^2 + ln^2 e), 1 for e = 0."""
        ratio = self.damping_ratio
        return abs(damping_ratio(self.restitution or 0.0)) if ratio is None else ratio

    @property
    def zeta_against_full_mass(self) -> float:
        """Return eta / (2 sqrt(k m)): the damping ratio of a grain on a fixed sphere."""
        return float(self.zeta * (1.0 if self.effective_mass == "full" else 0.5) ** 0.5)

    def dashpot(self, stiffness: float, mass: float) -> float:
        """Return eta = 2 zeta sqrt(k m*) [N s/m] of a stiffness [N/m] and a mass [kg]."""
        share = 1.0 if self.effective_mass == "full" else 0.5
        return float(2.0 * self.zeta * (stiffness * mass * share) ** 0.5)

    def law(self, stiffness: float) -> Law:
        """Return the law of a stiffness [N/m]: a fixed partner is frozen if full, held if half."""
        return Law.linear(stiffness, self.zeta, self.clipped)

    @property
    def script_values(self) -> dict[str, str | int | float]:
        """Return the values of scripts, whose names are the same for every engine."""
        by_ratio = self.damping_ratio is not None
        return {
            "damping": "ratio" if by_ratio else "restitution",
            "restitution": float(self.restitution or 0.0),
            "damping_ratio": self.zeta if by_ratio else 1.0,
            "effective_mass": self.effective_mass,
            "tail": self.tail,
        }


SOURCE = Contact(name="source", restitution=1e-20)  # Harper, Dufek and Breard; the tail is kept
CLIPPED = Contact(name="clipped", restitution=0.0, tail="clipped")  # rebounds with exp(-2) = 0.135
PLASTIC = Contact(name="plastic", damping_ratio=5.0, tail="clipped")  # no tail, hardly a rebound
CONTACTS = {contact.name: contact for contact in (SOURCE, CLIPPED, PLASTIC)}


def _contact_by_name(value: Any) -> Any:
    if isinstance(value, str) and value not in CONTACTS:
        raise ValueError(f"must be one of {', '.join(CONTACTS)}")
    return CONTACTS[value] if isinstance(value, str) else value


NamedContact = Annotated[Contact, BeforeValidator(_contact_by_name)]  # or a name of ``CONTACTS``
