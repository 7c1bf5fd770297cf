"""The submodels of a contact law: one row of data each, which all else reads.

A row says which coefficients of :class:`~harness.parameters.law.ContactLaw` a submodel takes, what
a page prints for it, and, of a dashpot, how it grows with the overlap and which springs it goes
with. From this follow the checks of a law, units under a change of scale, the powers of the step
in an error, the scales of a contact, and whether a closed form holds. The force itself is in
:mod:`harness.solvers.pair`, which is compiled, and in the codes.

Names and units follow the manual of LAMMPS's pair style granular, formulas the literature:
Johnson, Contact Mechanics (1985); Luding, Granular Matter 10, 235 (2008); Marshall, J. Comput.
Phys. 228, 1541 (2009); Thornton, Cummins and Cleary, Powder Technol. 233, 30 (2013); Zunker and
Kamrin, J. Mech. Phys. Solids 183, 105492 and 105493 (2024).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

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


@dataclass(frozen=True)
class Submodel:
    """A part of a contact law: the coefficients that it takes and its ``formula`` on a page.

    It has none without what it ``takes``; what it ``may_take`` is None unless it is given.
    """

    formula: str
    takes: tuple[str, ...] = ()
    may_take: tuple[str, ...] = ()

    @property
    def coefficients(self) -> tuple[str, ...]:
        """Return all that it takes or may take."""
        return (*self.takes, *self.may_take)


@dataclass(frozen=True)
class Dashpot(Submodel):
    """A normal dashpot eta_n [kg/s]: a coefficient times ``factors`` times the root of ``root``.

    Both name quantities of :data:`QUANTITIES`. It goes with the elastic forces ``normals``.
    ``gives_restitution``: the restitution of an impact on an elastic sphere is the one taken.
    """

    factors: tuple[str, ...] = ()
    root: tuple[str, ...] = ()
    normals: tuple[str, ...] = ("hooke", "hertz", "dmt", "jkr")
    gives_restitution: bool = False

    @property
    def dimensions(self) -> tuple[int, int, int]:
        """Return those of its coefficient: of kg/s, less those of its quantities."""
        shares = [(name, 1.0) for name in self.factors] + [(name, 0.5) for name in self.root]
        length, mass, time = (
            round(power - sum(share * QUANTITIES[name][axis] for name, share in shares))
            for axis, power in enumerate((0, 1, -1))
        )
        return length, mass, time

    @property
    def unit(self) -> str:
        """Return the unit of its coefficient, as in ``kg/s``; a pure number has none."""
        powers = [*zip(("m", "kg", "s"), self.dimensions, strict=True)]
        above = " ".join(name if n == 1 else f"{name}{n}" for name, n in powers if n > 0)
        below = " ".join(name if n == -1 else f"{name}{-n}" for name, n in powers if n < 0)
        if not below:
            return above
        return f"{above or '1'}/{f'({below})' if ' ' in below else below}"

    def growth(self, normal: str) -> float:
        """Return q of eta_n ~ overlap^q as a contact begins, with an elastic force."""
        powers = {"mass": 0.0, "radius": 0.5, "stiffness": 0.0 if normal == "hooke" else 0.5}
        return sum(powers[x] for x in self.factors) + 0.5 * sum(powers[x] for x in self.root)

    def eta(self, coefficient: float, **quantities: float) -> float:
        """Return eta_n [kg/s] for the values of :data:`QUANTITIES` in SI units."""
        product = math.prod([quantities[name] for name in self.factors])
        return coefficient * (product * math.sqrt(math.prod([quantities[x] for x in self.root])))


QUANTITIES: Mapping[str, tuple[int, int, int]] = {  # powers of length, mass and time
    "mass": (0, 1, 0),
    "radius": (1, 0, 0),
    "stiffness": (0, 1, -2),
}
"""What a dashpot may grow with: m*, contact radius a, stiffness k of the contact (F / overlap of a
dashpot that aims at a restitution)."""

# ---- elastic normal forces

_MATERIAL = ("youngs_modulus", "poisson_ratio")
PARTNER = ("partner_youngs_modulus", "partner_poisson_ratio")
"""The material of the second body, where it is another one."""

EQUAL_E = "E* = E / (2 (1 - nu^2))"
TWO_E = "1/E* = (1 - nu_1^2) / E_1 + (1 - nu_2^2) / E_2"
EQUAL_G = "G* = E / (4 (2 - nu) (1 + nu))"
TWO_G = "1/G* = (2 - nu_1) / G_1 + (2 - nu_2) / G_2, G = E / (2 (1 + nu))"
"""Moduli of two bodies of one material, as formulas have them, and of two materials."""

NORMAL: Mapping[str, Submodel] = {
    "hooke": Submodel("F = k_n delta, delta the overlap", ("normal_stiffness",)),
    "hertz": Submodel(f"F = 4/3 E* a delta, a = sqrt(R* delta), {EQUAL_E}", _MATERIAL, PARTNER),
    "dmt": Submodel(
        f"F = 4/3 E* a delta - 4 pi gamma R*, a = sqrt(R* delta), {EQUAL_E}",
        (*_MATERIAL, "surface_energy"),
        PARTNER,
    ),
    "jkr": Submodel(
        "F = 4 E* a^3 / (3 R*) - 4 sqrt(pi gamma E* a^3), with "
        f"delta = a^2 / R* - 2 sqrt(pi gamma a / E*), {EQUAL_E}",
        (*_MATERIAL, "surface_energy"),
        PARTNER,
    ),
    "mdr": Submodel(
        "F = 2 R^2 E / (1 - nu^2) (theta - sin theta cos theta) on each side of a rigid flat, "
        "cos theta = 1 - d / (2 R), d the depth of the flat: half the overlap, all of it at a "
        "wall; of two sizes the mean of both sides, the flat where the surfaces cross at the "
        "largest overlap",
        _MATERIAL,
        ("yield_stress", "surface_energy"),
    ),
}

# ---- what mdr has beside its elastic branch

_ON_FLAT = "on each side of a rigid flat at the depth d"
YIELD = (
    f"{_ON_FLAT}: as above up to Hertz's mean pressure p = Y (1 + 1.75 exp(-4.4 d / R)); from "
    "there F = p pi a^2, a^2 = 2 R d - d^2 - d_Y (R_0 - d_Y), with a radius R that grows so that "
    "the volume stays, less its elastic strain; back along an ellipse of the half axes "
    "2 p a (1 - nu^2) / E and a"
)
ADHESION = (
    f"{_ON_FLAT}: as above while it is pressed in; pulled, "
    "F = 2 R^2 E' (theta - sin theta cos theta) - 2 E' a l, a = R sin theta, "
    "d = 2 R (1 - cos theta) - l, l = sqrt(2 pi a gamma / E'), E' = E / (1 - nu^2)"
)
BULK = (
    f"{_ON_FLAT}: F = K A^2 d / (4/3 pi R^3 - pi/3 d^2 (3 R - d)), A = pi R d, "
    "K = E / (3 (1 - 2 nu)), in place of the force above"
)

# ---- normal dashpots

_COEFFICIENT = ("damping_coefficient",)
_AIM = ("restitution",)

DAMPING: Mapping[str, Dashpot] = {
    "none": Dashpot(
        "none: the normal force is the elastic one",
        normals=("hooke", "hertz", "dmt", "jkr", "mdr"),
    ),
    "velocity": Dashpot(
        "eta_n = eta_0", _COEFFICIENT, normals=("hooke", "hertz", "dmt", "jkr", "mdr")
    ),
    "mass_velocity": Dashpot("eta_n = eta_0 m*", _COEFFICIENT, factors=("mass",)),
    "viscoelastic": Dashpot(
        "eta_n = eta_0 m* a, a the contact radius", _COEFFICIENT, factors=("mass", "radius")
    ),
    "tsuji": Dashpot(
        "eta_n = alpha(e) sqrt(2 m* F / delta), alpha the polynomial that is fitted to Tsuji "
        "et al. (1992)",
        _AIM,
        root=("mass", "stiffness"),
        normals=("hertz",),
    ),
    "coeff_restitution": Dashpot(
        "eta_n = c zeta sqrt(m* F / delta), zeta = -ln e / sqrt(pi^2 + ln^2 e), c = 2 for hooke, "
        "sqrt(5) for hertz",
        _AIM,
        root=("mass", "stiffness"),
        normals=("hooke", "hertz"),
        gives_restitution=True,
    ),
    "mdr": Dashpot(
        "eta_n = eta_0 sqrt(m* k), k = 2 E_eff a, a the contact radius, E_eff = E / (1 - nu^2) "
        "at a wall and half of it between spheres: the slope of the elastic force",
        _COEFFICIENT,
        root=("mass", "stiffness"),
        normals=("mdr",),
    ),
}

# ---- tangential forces, resistance to rolling and twisting

_SLIDER = ("tangential_damping", "friction")
_MINDLIN = f"8 G* a, {EQUAL_G}"
_ADDED = f"the spring force grows by k_t times each displacement, k_t = {_MINDLIN}"
_TOTAL = f"spring k_t xi of the whole displacement xi, k_t = {_MINDLIN}"
_SHRINKS = "; it shrinks with a while the contact opens (Thornton et al. 2013)"
_LINEAR = "spring k_t xi, xi the displacement along the surface"
RIGID = ", at a wall, which is rigid, of twice that G*"
"""Of a Mindlin spring beside mdr."""

TANGENTIAL: Mapping[str, Submodel] = {
    "linear_nohistory": Submodel("eta_t v_t alone, without a spring", _SLIDER),
    "linear_history": Submodel(_LINEAR, ("tangential_stiffness", *_SLIDER)),
    "linear_history_classic": Submodel(
        f"{_LINEAR}, as in the earlier styles", ("tangential_stiffness", *_SLIDER)
    ),
    "mindlin": Submodel(_TOTAL, _SLIDER),
    "mindlin/force": Submodel(_ADDED, _SLIDER),
    "mindlin_rescale": Submodel(_TOTAL + _SHRINKS, _SLIDER),
    "mindlin_rescale/force": Submodel(_ADDED + _SHRINKS, _SLIDER),
    "mindlin_classic": Submodel(f"{_TOTAL}, as in the earlier styles", _SLIDER),
}
ROLLING: Mapping[str, Submodel] = {
    "sds": Submodel(
        "spring and dashpot on the rolling displacement, whose velocity is R* (w_i - w_j) x n; "
        "the torque is at most mu_r R* |F_n|",
        ("rolling_stiffness", "rolling_damping", "rolling_friction"),
    )
}
TWISTING: Mapping[str, Submodel] = {
    "sds": Submodel(
        "spring and dashpot on the angle about the normal; the torque is at most mu_w |F_n|",
        ("twisting_stiffness", "twisting_damping", "twisting_friction"),
    ),
    "marshall": Submodel(
        "stiffness k_t a^2 / 2, dashpot eta_t a^2 / 2; the torque is at most "
        "2/3 a mu |F_n| (Marshall 2009)"
    ),
}

SUBMODELS: Mapping[str, Mapping[str, Submodel]] = {
    "normal": NORMAL,
    "damping": DAMPING,
    "tangential": TANGENTIAL,
    "rolling": ROLLING,
    "twisting": TWISTING,
}
"""By the part of the law; a part whose value is not here, ``none``, is not there."""

COEFFICIENTS = frozenset(
    name for rows in SUBMODELS.values() for row in rows.values() for name in row.coefficients
)
"""The names of all coefficients that a submodel takes or may take."""


def dashpot_coefficient() -> str:
    """Return what the damping coefficient is in each dashpot that takes one, with units."""
    rows = [
        f"{row.formula.partition(',')[0].removeprefix('eta_n = ')} "
        f"({name}, {row.unit or 'a pure number'})"
        for name, row in DAMPING.items()
        if row.takes == _COEFFICIENT
    ]
    where = "m* the effective mass, a the contact radius, k the stiffness of the contact"
    return f"eta_0: eta_n = {', '.join(rows[:-1])}, or {rows[-1]}; {where}"
