"""Bodies, laws and walls in the words of LAMMPS: pair style granular and the older gran/*."""

from __future__ import annotations

import math
import re
from collections.abc import Collection, Iterable, Iterator

from harness.engines.output import release_of
from harness.errors import Unsupported
from harness.model.base import ZERO, unit_vector
from harness.model.law import Law
from harness.model.scene import Scene, Wall, effective_mass

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
Pair = tuple[int, int]


def check_release(names: Iterable[str], release: str | None) -> None:
    """Raise Unsupported for a name that a release lacks, the newest unless given."""
    for name in names:
        first = FIRST_RELEASES.get(name)
        if first and release and release_of(release) < release_of(first):
            raise Unsupported(f"LAMMPS {release} has no {name}: LAMMPS {first} has it")


def check_kokkos(script: str, styles: Collection[str]) -> None:
    """Raise Unsupported where a contact style of a script has no variant kk among ``styles``.

    With ``-sf kk`` LAMMPS runs the plain style in its place.
    """
    for style in re.findall(r"^(?:pair_style|fix \S+ \S+ (?=wall/gran)) *(\S+)", script, re.M):
        if f"{style}/kk" not in styles:
            raise Unsupported(f"{style} has no variant kk in this LAMMPS: it runs without -sf kk")
    check_kokkos_walls(script)


def check_kokkos_walls(script: str) -> None:
    """Raise Unsupported for a wall of a script that fix wall/gran/kk leaves without a force.

    Pull request 5182 of LAMMPS (2026) has it refuse the word ``granular``, which it took silently.
    """
    if re.search(r"^fix \S+ \S+ wall/gran granular ", script, re.M):
        raise Unsupported("fix wall/gran/kk has no style granular: its walls exert no force")


def names_of(law: Law) -> list[str]:
    """Return the submodels of a law, and the words of its script, that a release may lack."""
    if law.interface == "old":
        return []
    heat = [] if law.heat == "none" else ["heat", "compute property/atom temperature"]
    return [law.normal, law.damping, law.tangential, *heat]


# ---- bodies


class Atoms:
    """Bodies with a number from 1 on, and a type: by ``Body.type``, or one for each body.

    ``contacts`` are the pairs that may touch, by place from 0 on, ``excluded`` those that
    ``Scene.pairs`` leaves out. With ``mixed``, LAMMPS mixes coefficients of different types.
    Methods raise Unsupported for laws that types cannot have.
    """

    def __init__(self, scene: Scene, *, own_types: bool = False, mixed: bool = False) -> None:
        self.scene, self.mixed = scene, mixed
        prescribed = bool(scene.segments)
        self.bodies = [body.replace(motion="held") if prescribed else body for body in scene.bodies]
        self.free = [body.motion == "free" for body in self.bodies]
        self.touching = [prescribed or free for free in self.free]
        places = range(len(self.bodies))
        every = [(i, j) for i in places for j in places if i < j]
        pairs = {(min(pair), max(pair)) for pair in (every if scene.pairs is None else scene.pairs)}
        self.excluded = [pair for pair in every if pair not in pairs]
        self.contacts = [
            (i, j) for i, j in every if (i, j) in pairs and (self.touching[i] or self.touching[j])
        ]
        # damping ratios of several effective masses are coefficients of each pair
        ratios = any(law.damping == "damping_ratio" for law in scene.all_laws)
        masses = {self._effective_mass(*pair) for pair in self.contacts}
        self.by_type = own_types or mixed or (ratios and len(masses) > 1)
        self.types = self._types()
        numbers = {kind: body.type for kind, body in zip(self.types, self.bodies, strict=True)}
        self.pair_laws = {
            (k, m): scene.law_of(numbers[k], numbers[m]) for k in numbers for m in numbers if k <= m
        }
        # the laws that the pair style is for: those of contacts, or all without any
        laws = [self.pair_laws[self.type_pair(pair)] for pair in self.contacts]
        self.style_laws = [*dict.fromkeys(laws or self.pair_laws.values())]
        self.is_old = any(law.interface == "old" for law in self.style_laws)

    def _types(self) -> list[int]:
        types = [body.type for body in self.bodies]
        two_materials = len(types) == 2 and self.scene.law_of(*types).two_materials
        if self.by_type or self.excluded or two_materials:
            return list(range(1, len(types) + 1))
        return [1 + sorted(set(types)).index(number) for number in types]

    def type_pair(self, pair: Pair) -> Pair:
        """Return the types of a pair of bodies, the smaller one first."""
        k, m = (self.types[place] for place in pair)
        return (min(k, m), max(k, m))

    @property
    def laws(self) -> list[Law]:
        """Return the laws of all contacts that there may be."""
        scene, of_pairs = self.scene, self.style_laws if self.contacts else []
        at_walls = [scene.law_of(b.type, w.type) for b in self.bodies for w in scene.walls]
        return [*dict.fromkeys([*of_pairs, *at_walls])]

    @property
    def mixes(self) -> bool:
        """Return whether LAMMPS mixes coefficients."""
        return any(map(self._is_mixed, self.pair_laws)) and not self.is_old

    def _is_mixed(self, types: Pair) -> bool:
        return types[0] != types[1] and (self.mixed or self.pair_laws[types].two_materials)

    def are_discs(self) -> bool:
        """Return whether bodies turn as discs in a plane; raise Unsupported for other inertias."""
        turning = any({law.tangential, law.rolling, law.twisting} != {"none"} for law in self.laws)
        shares = [body.moment_of_inertia / (body.mass * body.radius**2) for body in self.bodies]
        if not turning or all(math.isclose(share, 0.4, rel_tol=1e-12) for share in shares):
            return False
        across = [self.scene.gravity[2]]
        for body in self.bodies:
            across += [body.position[2], body.velocity[2], *body.angular_velocity[:2]]
        if any(across) or not all(math.isclose(share, 0.5, rel_tol=1e-12) for share in shares):
            raise Unsupported("its bodies turn as spheres, or all as discs in the plane z = 0")
        return True

    # ---- pairs of bodies

    def pair_lines(self) -> list[str]:
        """Return the pair style and the coefficients of all types."""
        law, *more = self.style_laws
        if self.is_old:
            if more:
                raise Unsupported("pair_style gran/* has one law for all bodies")
            return [f"pair_style gran/{gran_words(law)}", "pair_coeff * *"]
        together = not self.by_type or law.normal == "mdr"
        if together and not more and not law.two_materials:
            return ["pair_style granular", f"pair_coeff * * {self._words(law, self.contacts)}"]
        return ["pair_style granular", *self._coefficients()]

    def _words(self, law: Law, contacts: Iterable[Pair]) -> str:
        masses = {self._effective_mass(*pair) for pair in contacts} or {1.0}
        return granular_words(law, masses.pop() if len(masses) == 1 else None)

    def _effective_mass(self, i: int, j: int) -> float:
        first, second = self.bodies[i], self.bodies[j]
        if first.motion == "frozen":
            first, second = second, first
        return effective_mass(first, second)

    def _coefficients(self) -> Iterator[str]:
        materials = self._materials()
        for types, law in self.pair_laws.items():
            if self._is_mixed(types):
                continue
            contacts = [pair for pair in self.contacts if self.type_pair(pair) == types]
            pure = materials.get(types[0], law) if types[0] == types[1] else law
            if contacts and (pure != law or law.two_materials):
                raise Unsupported(
                    f"bodies of type {types[0]} touch, which has one of two materials"
                )
            words = self._words(pure, contacts or self.contacts[:1])
            yield f"pair_coeff {types[0]} {types[1]} {words}"

    def _materials(self) -> dict[int, Law]:
        """Return the law of one material of each type that is mixed with another."""
        materials: dict[int, Law] = {}
        for types, law in self.pair_laws.items():
            if types[0] == types[1] or not law.two_materials:
                continue
            for number, pure in zip(types, _laws_of_each(law), strict=True):
                if materials.setdefault(number, pure) != pure:
                    raise Unsupported(f"type {number} has two materials")
        return materials

    # ---- walls

    def wall_lines(self) -> Iterator[str]:
        """Yield the lines of each wall: one fix for each law that bodies have with it."""
        for number, wall in enumerate(self.scene.walls, 1):
            laws = [
                self.scene.law_of(body.type, wall.type) if touches else None
                for body, touches in zip(self.bodies, self.touching, strict=True)
            ]
            kinds = [law for law in dict.fromkeys(laws) if law is not None]
            for part, law in enumerate(kinds, 1):
                if law.two_materials:
                    raise Unsupported("its walls take coefficients of the contact, and mix none")
                name = f"wall{number}" if len(kinds) == 1 else f"wall{number}_{part}"
                which = [other == law for other in laws]
                yield from group_line(name, which)
                masses = {b.mass for b, touches in zip(self.bodies, which, strict=True) if touches}
                mass = masses.pop() if len(masses) == 1 else None
                words = (
                    gran_words(law)
                    if law.interface == "old"
                    else f"granular {granular_words(law, mass)}"
                )
                yield from wall_lines(name, "all" if all(which) else name, wall, words, law)


def _laws_of_each(law: Law) -> list[Law]:
    """Return the laws of which LAMMPS mixes one of two materials.

    mindlin_classic knows no material: its coefficient is that of the pair.
    """
    classic = law.tangential == "mindlin_classic" and law.moduli and not law.tangential_modulus
    shear = {"tangential_modulus": 8.0 * law.moduli[1]} if classic and law.moduli else {}
    return [pure.model_copy(update=shear) for pure in law.of_each]


def group_line(name: str, which: Iterable[bool]) -> list[str]:
    """Return the line that defines a group of some bodies; none for all, or for nobody."""
    which = list(which)
    ids = [str(number) for number, member in enumerate(which, 1) if member]
    return [f"group {name} id {' '.join(ids)}"] if ids and len(ids) < len(which) else []


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
    central = wall.hollow and wall.point[:2] == (0.0, 0.0) and wall.axis == 2
    if wall.shape == "cylinder" and central and not _oscillates(wall):
        return _cylinder_style(wall)
    return None


def _plane_style(wall: Wall) -> str | None:
    axis = wall.axis
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
    axis = wall.axis
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


def numbers_of(values: Iterable[float]) -> str:
    """Return numbers as words, at full precision."""
    return " ".join(map(repr, values))
