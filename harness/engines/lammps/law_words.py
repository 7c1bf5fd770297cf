"""A contact law in the words of LAMMPS: pair style granular, its walls, and the older gran/*."""

from __future__ import annotations

from harness.engines.provenance import release_of
from harness.errors import Unsupported
from harness.model.law import Law

FIRST_RELEASES = {
    "linear_history_classic": "2 Aug 2023",
    "mindlin_classic": "2 Aug 2023",
    "coeff_restitution": "29 Aug 2024",
    "heat": "2 Aug 2023",
    "compute property/atom temperature": "29 Aug 2024",
    "mdr": "22 Jul 2025",
}  # the first stable release that has a submodel, or a word of its script
DAMPINGS = ("velocity", "mass_velocity", "viscoelastic", "tsuji", "coeff_restitution")
MIXES_SUBMODELS = "28 Mar 2023"  # before, mixed types are what memory holds: hooke in a new process


def check_release(law: Law, release: str) -> None:
    """Raise Unsupported for a law of which a release lacks a submodel."""
    if law.interface == "old":
        return
    heat = () if law.heat == "none" else ("heat", "compute property/atom temperature")
    for name in (law.normal, law.damping, law.tangential, *heat):
        first = FIRST_RELEASES.get(name)
        if first and release_of(release) < release_of(first):
            raise Unsupported(f"LAMMPS {release} has no {name}: LAMMPS {first} has it")


def granular_words(law: Law, mass: float | None) -> str:
    """Return a law of one material as pair_coeff and fix wall/gran granular take it.

    ``mass`` is m* [kg] of its contacts, None where they have several. Raise Unsupported for a
    dashpot that LAMMPS lacks, and one by a damping ratio that no coefficient makes.
    """
    name, eta = _dashpot(law, mass)
    words = [_normal_words(law, eta), f"damping {name}", f"tangential {_tangential_words(law)}"]
    if law.rolling == "constant":
        raise Unsupported("pair_style granular has rolling sds alone, no constant torque")
    if law.rolling == "sds":
        words.append(f"rolling sds {_sds_numbers(law, 'rolling')}")
    if law.twisting == "sds":
        words.append(f"twisting sds {_sds_numbers(law, 'twisting')}")
    elif law.twisting == "marshall":
        words.append("twisting marshall")
    if law.heat != "none":
        words.append(f"heat {law.heat} {law.conductance!r}")
    return " ".join([*words, *_limit(law)])


def gran_words(law: Law) -> str:
    """Return a law as pair_style gran/* and the older fix wall/gran take it.

    Raise Unsupported for heat, which they do not conduct.
    """
    if law.heat != "none":
        raise Unsupported("pair_style gran/* conducts no heat")
    if law.partner_friction is not None:
        raise Unsupported("pair_style gran/* has one friction for all bodies")
    style = "hertz/history" if law.normal == "hertz" else "hooke/history"
    if law.normal == "hooke" and not law.has_spring:
        style = "hooke"
    normal, tangential = _stiffnesses(law)
    eta = law.damping_coefficient or 0.0
    numbers = (normal, tangential, eta, eta * (law.tangential_damping or 0.0), law.friction or 0.0)
    return " ".join([style, *map(repr, numbers), "1", *_limit(law)])


def _limit(law: Law) -> list[str]:
    return ["limit_damping"] if law.clipped else []


def _stiffnesses(law: Law) -> tuple[float, float]:
    """Return the normal and the tangential coefficient: of hertz 4/3 E* and 8 G* [Pa]."""
    if law.normal_stiffness is not None:
        return law.normal_stiffness, law.tangential_stiffness or 0.0
    modulus, shear = law.moduli or (0.75 * (law.normal_modulus or 0.0), 0.0)
    return law.normal_modulus or 4.0 / 3.0 * modulus, law.tangential_modulus or 8.0 * shear


def _normal_words(law: Law, eta: float) -> str:
    young, poisson, surface = law.youngs_modulus, law.poisson_ratio, law.surface_energy
    if law.normal == "hooke":
        return f"hooke {law.normal_stiffness!r} {eta!r}"
    if law.normal == "hertz" and law.normal_modulus is not None:
        return f"hertz {law.normal_modulus!r} {eta!r}"
    if law.normal == "hertz":
        return f"hertz/material {young!r} {eta!r} {poisson!r}"
    if law.normal == "mdr":
        stress = 1e300 if law.yield_stress is None else law.yield_stress
        bulk = law.bulk_share or 0.0
        return f"mdr {young!r} {poisson!r} {stress!r} {surface or 0.0!r} {bulk!r} {eta!r}"
    return f"{law.normal} {young!r} {eta!r} {poisson!r} {surface!r}"


def _dashpot(law: Law, mass: float | None) -> tuple[str, float]:
    """Return the word of a dashpot and its coefficient, which stands with the normal force."""
    eta = law.damping_coefficient or 0.0
    if law.normal == "mdr":
        return ("mdr 1" if law.damping == "mdr" else "mdr 2"), eta
    if law.damping == "damping_ratio":
        if mass is None:
            raise Unsupported("damping_ratio of contacts whose effective masses differ")
        return "velocity", law.dashpot(mass, 1.0, 0.0)
    name = "velocity" if law.damping == "none" else law.damping
    if name not in DAMPINGS:
        raise Unsupported(f"LAMMPS has no damping {name}")
    return name, eta if law.restitution is None else law.restitution


def _tangential_words(law: Law) -> str:
    slider = f"{law.tangential_damping!r} {law.friction!r}"
    if law.tangential == "none":
        return "linear_nohistory 0.0 0.0"
    if law.tangential == "linear_nohistory":
        return f"linear_nohistory {slider}"
    if law.tangential.startswith("linear"):
        return f"{law.tangential} {law.tangential_stiffness!r} {slider}"
    by_material = law.tangential_modulus is None and law.tangential != "mindlin_classic"
    return f"{law.tangential} {'NULL' if by_material else repr(_stiffnesses(law)[1])} {slider}"


def _sds_numbers(law: Law, part: str) -> str:
    names = ("stiffness", "damping", "friction")
    return " ".join(repr(getattr(law, f"{part}_{name}") or 0.0) for name in names)
