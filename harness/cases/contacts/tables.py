"""Tables of the contact cases: laws, the rows of the matrix, systems, its columns, and presets.

A law is a change of a case's default parameters, and so is a system.
"""

from __future__ import annotations

import tomllib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import cache
from importlib.resources import files
from typing import Any

from harness.results.rows import Level

Changes = Mapping[str, Any]

PLAIN: Changes = {
    "normal": "hooke", "damping": "none", "tangential": "none", "rolling": "none",
    "twisting": "none", "clipped": False, "interface": "current",
}  # fmt: skip
USUAL_SYSTEMS = ("wall", "two spheres", "unequal spheres", "frozen sphere")
TWO_MATERIALS = ("two materials, stated", "two materials, mixed", "wall of another material")
MIXED = "two spheres, mixed"  # a code mixes restitution and friction of two bodies itself
SLOW_SYSTEMS = ("unequal spheres", "frozen sphere", "two spheres, turned", *TWO_MATERIALS)


@dataclass(frozen=True)
class LawRow:
    """Changes of the default parameters that make a law.

    ``systems`` names those that it goes through, all unless given; those of two materials only
    with ``two_materials``. ``quick``: also at level quick.
    """

    law: Changes = field(hash=False)
    systems: tuple[str, ...] = ()
    quick: bool = True
    two_materials: bool = False

    def goes_with(self, system: str) -> bool:
        """Return whether the law goes through a system."""
        if system in TWO_MATERIALS:
            return self.two_materials
        return system in self.systems or (not self.systems and system != MIXED)


@dataclass(frozen=True)
class Matrix:
    """Laws and systems of a case.

    Level quick runs each law in the systems ``always``, and ``two_materials_law`` in pairs of two
    materials. ``varied`` has laws that run in an engine's variations, with the shortest level.
    """

    laws: Mapping[str, LawRow]
    systems: Mapping[str, Changes]
    always: tuple[str, ...]
    two_materials_law: str
    varied: Mapping[str, Level]


def matrix(case: str) -> Matrix:
    """Return the laws and systems of a case."""
    row, named = _read("laws.toml")["cases"][case], _read("laws.toml")["systems"]
    rows = laws(row["laws"])
    for name, chosen in row["laws"].items() if isinstance(row["laws"], dict) else ():
        rows[name] = replace(rows[name], systems=tuple(chosen))
    rows = {name: law for name, law in rows.items() if name not in row.get("without", ())}
    systems = row.get("systems", USUAL_SYSTEMS)
    changes = systems if isinstance(systems, dict) else {name: {} for name in systems}
    levels: tuple[Level, ...] = ("full", "default", "quick")
    return Matrix(
        laws=rows,
        systems={name: {**named.get(name, {}), **each} for name, each in changes.items()},
        always=tuple(row.get("always", ())),
        two_materials_law=row.get("two_materials_law", ""),
        varied={law: level for level in levels for law in laws(row.get(level, ()))},
    )


def laws(names: Iterable[str]) -> dict[str, LawRow]:
    """Return laws by the names of groups and of laws, in this order."""
    chosen: dict[str, LawRow] = {}
    for name in names:
        group = _groups().get(name)
        # of two groups with a law of this name, the first
        rows = group or {name: next(g[name] for g in _groups().values() if name in g)}
        chosen |= rows
    return chosen


def part(name: str) -> Changes:
    """Return the coefficients of a part of a law."""
    coefficients: Changes = _read("laws.toml")["parts"][name]
    return coefficients


def presets(case: str) -> dict[str, dict[str, Any]]:
    """Return the presets of a case, the usual ones first, those of the literature with a source."""
    return {name: dict(values) for name, values in _read("presets.toml").get(case, {}).items()}


@cache
def _groups() -> dict[str, dict[str, LawRow]]:
    groups = {}
    for name, group in _read("laws.toml").items():
        if name not in ("parts", "systems", "cases"):
            systems, quick = tuple(group.get("systems", ())), group.get("quick", True)
            both = group.get("two_materials", ())
            groups[name] = {
                law: LawRow(_changes(parts), systems, quick, law in both)
                for law, parts in group["laws"].items()
            }
    return groups


def _changes(parts: Iterable[str | Changes]) -> dict[str, Any]:
    rows = (part(each) if isinstance(each, str) else each for each in parts)
    return {name: value for row in rows for name, value in row.items()}


@cache
def _read(name: str) -> dict[str, Any]:
    return tomllib.loads((files(__package__) / name).read_text("utf-8"))
