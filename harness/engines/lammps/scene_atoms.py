"""The bodies of a scene as atoms of LAMMPS: types, groups, and the laws of their contacts."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator

from harness.engines.lammps.words import gran_words, granular_words, wall_lines
from harness.errors import Unsupported
from harness.model.law import Law
from harness.model.scene import Scene, effective_mass

Pair = tuple[int, int]


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
                name = f"wall{number}" if len(kinds) == 1 else f"wall{number}_{part}"
                which = [other == law for other in laws]
                yield from group_line(name, which)
                masses = {b.mass for b, touches in zip(self.bodies, which, strict=True) if touches}
                mass = masses.pop() if len(masses) == 1 else None
                words = (
                    gran_words(law)
                    if law.interface == "old"
                    else f"granular {granular_words(law.one_material, mass)}"
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
