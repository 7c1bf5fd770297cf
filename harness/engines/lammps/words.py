"""Laws of contact and walls in the words of LAMMPS: pair style granular and the older gran/*."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator

from harness.engines.output import release_of
from harness.errors import Unsupported
from harness.model.base import ZERO, Vector, unit_vector
from harness.model.law import Law
from harness.model.scene import Wall

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
AXES = "xyz"


def check_release(law: Law, release: str) -> None:
    """Raise Unsupported for a law of which a release lacks a submodel."""
    if law.interface == "old":
        return
    heat = () if law.heat == "none" else ("heat", "compute property/atom temperature")
    for name in (law.normal, law.damping, law.tangential, *heat):
        first = FIRST_RELEASES.get(name)
        if first and release_of(release) < release_of(first):
            raise Unsupported(f"LAMMPS {release} has no {name}: LAMMPS {first} has it")


# ---- laws


def granular_words(law: Law, mass: float | None) -> str:
    """Return a law of one material as pair_coeff and fix wall/gran granular take it.

    ``mass`` is m* [kg] of its contacts, None where they have several. Raise Unsupported for a
    dashpot that LAMMPS lacks, and one by a damping ratio that no coefficient makes.
    """
    if law.rolling == "constant":
        raise Unsupported("pair_style granular has rolling sds alone, no constant torque")
    name, eta = _dashpot(law, mass)
    words = [_normal_words(law, eta), f"damping {name}", f"tangential {_tangential_words(law)}"]
    words += [f"{part} {_sds_words(law, part)}" for part in ("rolling", "twisting")
              if getattr(law, part) == "sds"]  # fmt: skip
    if law.twisting == "marshall":
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
    return " ".join([style, numbers_of(numbers), "1", *_limit(law)])


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
    """Return the word of a dashpot and its coefficient, which is a word of the normal force."""
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


def _sds_words(law: Law, part: str) -> str:
    names = ("stiffness", "damping", "friction")
    return f"sds {numbers_of(getattr(law, f'{part}_{name}') or 0.0 for name in names)}"


# ---- walls: fix wall/gran where a style has them, else regions


def wall_lines(name: str, group: str, wall: Wall, words: str, law: Law) -> Iterator[str]:
    """Yield the lines of a wall that touches a group of bodies by a law, in ``words``.

    Raise Unsupported for a wall that neither a style nor a region can be.
    """
    if wall.bodies is not None:
        raise Unsupported("walls act on all bodies here")
    warm = f" temperature {wall.temperature!r}" if law.heat != "none" else ""
    style = None if law.normal == "mdr" else _style(wall)
    if style is not None:
        yield f"fix {name} {group} wall/gran {words} {style}{warm}"
        return
    yield from _region(name, wall)
    yield f"fix {name} {group} wall/gran/region {words} region {name}{warm}"


def _oscillates(wall: Wall) -> bool:
    return wall.frequency > 0.0 and any(wall.amplitude)


def _style(wall: Wall) -> str | None:
    """Return a wall in the words of fix wall/gran, None where it needs a region."""
    if wall.shape == "plane":
        return _plane_style(wall)
    central = wall.hollow and wall.point[:2] == (0.0, 0.0) and _axis(wall.direction) == 2
    if wall.shape == "cylinder" and central and not _oscillates(wall):
        return _cylinder_style(wall)
    return None


def _plane_style(wall: Wall) -> str | None:
    axis = _axis(wall.direction)
    sliding = tuple(a + b for a, b in zip(wall.velocity, wall.surface_velocity, strict=True))
    if axis is None or wall.velocity[axis] or wall.surface_velocity[axis]:
        return None
    height = repr(wall.point[axis])
    places = f"{height} NULL" if wall.direction[axis] > 0.0 else f"NULL {height}"
    words = f"{AXES[axis]}plane {places}"
    slid = [k for k in range(3) if sliding[k]]
    if _oscillates(wall):
        swung = [k for k in range(3) if wall.amplitude[k]]
        if len(swung) > 1 or slid:
            raise Unsupported("walls oscillate along one axis, and do not slide at the same time")
        period = 2.0 * math.pi / wall.frequency
        return f"{words} wiggle {AXES[swung[0]]} {wall.amplitude[swung[0]]!r} {period!r}"
    if len(slid) > 1:
        return None
    return f"{words} shear {AXES[slid[0]]} {sliding[slid[0]]!r}" if slid else words


def _cylinder_style(wall: Wall) -> str | None:
    along = wall.velocity[2] + wall.surface_velocity[2]
    across = (*wall.velocity[:2], *wall.surface_velocity[:2], *wall.spin[:2])
    if any(across) or (along and wall.spin[2]):
        return None
    words, radius = f"zcylinder {wall.radius!r}", wall.radius or 0.0
    if wall.spin[2]:
        return f"{words} shear x {-wall.spin[2] * radius!r}"
    return f"{words} shear z {along!r}" if along else words


def _region(name: str, wall: Wall) -> Iterator[str]:
    """Yield a region and, where it moves, the variables of its motion."""
    if _oscillates(wall):
        raise Unsupported("walls of mdr, curved and tilted ones do not oscillate")
    if wall.surface_velocity != ZERO:
        raise Unsupported("walls of mdr, curved and tilted ones do not slide in place")
    moves = []
    if any(wall.velocity):
        for axis, speed in zip(AXES, wall.velocity, strict=True):
            yield f"variable {name}_{axis} equal {speed!r}*step*dt"
        moves.append("move " + " ".join(f"v_{name}_{axis}" for axis in AXES))
    if any(wall.spin):
        yield f"variable {name}_turn equal {_turning(wall)!r}*step*dt"
        # of length 1: LAMMPS multiplies the velocity of the surface by the length of the axis
        about = wall.direction if wall.shape == "cylinder" else unit_vector(wall.spin)
        moves.append(f"rotate v_{name}_turn {numbers_of(wall.point)} {numbers_of(about)}")
    side = "" if wall.shape == "plane" else f" side {'in' if wall.hollow else 'out'}"
    yield " ".join([f"region {name} {_shape(wall)}{side} units box", *moves])


def _shape(wall: Wall) -> str:
    if wall.shape == "plane":
        return f"plane {numbers_of(wall.point)} {numbers_of(wall.direction)}"
    if wall.shape == "sphere":
        return f"sphere {numbers_of(wall.point)} {wall.radius!r}"
    axis = _axis(wall.direction)
    if axis is None:
        raise Unsupported("cylinders lie along x, y or z")
    across = numbers_of(x for k, x in enumerate(wall.point) if k != axis)
    return f"cylinder {AXES[axis]} {across} {wall.radius!r} INF INF"


def _turning(wall: Wall) -> float:
    """Return the angular velocity of a region [rad/s], about its axis where it has one."""
    rate = math.hypot(*wall.spin)
    if wall.shape == "sphere":
        return rate
    along = sum(a * b for a, b in zip(wall.spin, wall.direction, strict=True))
    if not math.isclose(abs(along), rate, rel_tol=1e-12):
        raise Unsupported("cylinders turn about their axis alone")
    return along


def _axis(direction: Vector) -> int | None:
    """Return the axis that a direction lies along, None for any other."""
    axes = [axis for axis in range(3) if direction[axis]]
    return axes[0] if len(axes) == 1 else None


def numbers_of(values: Iterable[float]) -> str:
    """Return numbers as words, at full precision."""
    return " ".join(map(repr, values))
