"""Tables of the contact cases: laws, the rows of the matrix, systems, its columns, and presets.

A law is a change of a case's default parameters. Level quick leaves out laws in which several parts
act together, and takes the others in turns through the systems.
"""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache
from importlib.resources import files
from typing import Any

Changes = Mapping[str, Any]

PLAIN: Changes = {
    "normal": "hooke", "damping": "none", "tangential": "none", "rolling": "none",
    "twisting": "none", "clipped": False, "interface": "current",
}  # fmt: skip
_STIFFER = {"partner_youngs_modulus": 4e8, "partner_poisson_ratio": 0.1}
_DENSER = {"partner": "sphere", "partner_radius": None, "partner_density": 5000.0, **_STIFFER}
SYSTEMS: dict[str, Changes] = {  # the first sphere has a radius of 1 cm
    "wall": {"partner": "wall", "partner_radius": None},
    "two spheres": {"partner": "sphere", "partner_radius": None},
    "unequal spheres": {"partner": "sphere", "partner_radius": 0.02},
    "frozen sphere": {"partner": "frozen", "partner_radius": None},
}
TWO_MATERIALS: dict[str, Changes] = {
    "two materials, stated": {**_DENSER, "materials_as": "stated"},
    "two materials, mixed": {**_DENSER, "materials_as": "mixed"},
    "wall of another material": {**SYSTEMS["wall"], **_STIFFER},
}
MIXED: dict[str, Changes] = {  # a code mixes restitution and friction of two bodies itself
    "two spheres, mixed": {**SYSTEMS["two spheres"], "materials_as": "mixed"},
}
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
        return system in self.systems or (not self.systems and system not in MIXED)


Laws = Mapping[str, LawRow]


def laws(*groups: str) -> dict[str, LawRow]:
    """Return the laws of groups of laws.toml, by name."""
    rows = {}
    for group in map(_read("laws.toml").__getitem__, groups):
        systems, quick = tuple(group.get("systems", ())), group.get("quick", True)
        for name, parts in group["laws"].items():
            changes = (part(each) if isinstance(each, str) else each for each in parts)
            law = {field: value for row in changes for field, value in row.items()}
            rows[name] = LawRow(law, systems, quick, name in group.get("two_materials", ()))
    return rows


def pick(*names: str, systems: tuple[str, ...] | None = None) -> dict[str, LawRow]:
    """Return laws by name, in this order, perhaps in other ``systems``."""
    every = laws(*(group for group in reversed(_read("laws.toml")) if group != "parts"))
    rows = {name: every[name] for name in names}
    if systems is None:
        return rows
    return {name: LawRow(row.law, systems, row.quick) for name, row in rows.items()}


def systems(*names: str) -> dict[str, Changes]:
    """Return some systems by name."""
    return {name: SYSTEMS[name] for name in names}


def part(name: str) -> Changes:
    """Return the coefficients of a part of a law."""
    coefficients: Changes = _read("laws.toml")["parts"][name]
    return coefficients


def presets(case: str) -> dict[str, dict[str, Any]]:
    """Return the presets of a case, the usual ones first, those of the literature with a source."""
    return {name: dict(values) for name, values in _read("presets.toml").get(case, {}).items()}


@cache
def _read(name: str) -> dict[str, Any]:
    return tomllib.loads((files(__package__) / name).read_text("utf-8"))


FLOOR_FRICTION: Laws = laws("tangential", "old_tangential", "further_tangential") | pick(
    "rolling sds, linear_history", "rolling sds, linear_history, of Ai"
)
