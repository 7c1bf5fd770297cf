"""Tables of the contact cases: the trials of each, a law in a system, and presets.

A law is a change of a case's default parameters, and so is a system.
"""

from __future__ import annotations

import tomllib
from collections.abc import Iterable, Mapping, Sequence
from functools import cache
from importlib.resources import files
from typing import Any, NamedTuple

from harness.results.rows import LEVELS, Level

Changes = Mapping[str, Any]

PLAIN: Changes = {
    "normal": "hooke", "damping": "none", "tangential": "none", "rolling": "none",
    "twisting": "none", "clipped": False, "interface": "current",
}  # fmt: skip
USUAL_SYSTEMS = ("wall", "two spheres", "unequal spheres", "frozen sphere")
TWO_MATERIALS = ("two materials, stated", "two materials, mixed", "wall of another material")
MIXED = "two spheres, mixed"  # a code mixes restitution and friction of two bodies itself
SLOW_SYSTEMS = ("unequal spheres", "frozen sphere", "two spheres, turned", *TWO_MATERIALS)
VARIED_SYSTEM = "two spheres"  # of an engine's variations below level full


class Entry(NamedTuple):
    """A law in a system, as changes of the default parameters of a case.

    ``level`` is the shortest that runs it, ``varied`` the shortest that runs an engine's variations
    of it, None for none.
    """

    law: str
    system: str
    changes: Changes
    level: Level
    varied: Level | None


class _Law(NamedTuple):
    """Changes of parameters, systems (all unless given), and a row of laws.toml's options."""

    changes: Changes
    systems: Sequence[str]
    quick: bool
    two_materials: bool

    def goes_with(self, system: str) -> bool:
        if system in TWO_MATERIALS:
            return self.two_materials
        return system in self.systems or (not self.systems and system != MIXED)


def entries(case: str) -> list[Entry]:
    """Return each law of a case in each of its systems."""
    table, named = _read("laws.toml")["cases"][case], _read("laws.toml")["systems"]
    laws = {name: law for name, law in _laws(table["laws"]).items()
            if name not in table.get("without", ())}  # fmt: skip
    if isinstance(table["laws"], dict):
        laws = {name: law._replace(systems=table["laws"][name]) for name, law in laws.items()}
    systems = table.get("systems", USUAL_SYSTEMS)
    systems = systems if isinstance(systems, dict) else {name: {} for name in systems}
    varied = {law: level for level in reversed(LEVELS) for law in _laws(table.get(level, ()))}
    quick_laws = [name for name, law in laws.items() if law.quick]
    rows = []
    for name, law in laws.items():
        chosen = [system for system in systems if law.goes_with(system)]
        turn = quick_laws.index(name) if law.quick else None
        quick = set() if turn is None else _quick_systems(table, name, law, chosen, turn)
        for system in chosen:
            changes = {**PLAIN, **law.changes, **named.get(system, {}), **systems[system]}
            level: Level = "quick" if system in quick else "default"
            variations = varied.get(name)
            if variations and system != VARIED_SYSTEM:
                variations = "full"
            rows.append(Entry(name, system, changes, level, variations))
    return rows


def _quick_systems(
    table: Mapping[str, Any], name: str, law: _Law, systems: Sequence[str], turn: int
) -> set[str]:
    """Return the systems of a law at level quick.

    The laws take turns in the systems that are not slow; those of earlier interfaces go through all
    of them, as their walls and pairs share no code.
    """
    fast = [system for system in systems if system not in SLOW_SYSTEMS]
    if law.changes.get("interface") == "old":
        return set(fast)
    chosen = {system for system in fast if system in table.get("always", ())}
    if turns := [system for system in fast if system not in chosen]:
        chosen.add(turns[turn % len(turns)])
    if name == table.get("two_materials_law"):
        chosen |= {system for system in systems if system.startswith("two materials")}
    return chosen


def part(name: str) -> Changes:
    """Return the coefficients of a part of a law."""
    coefficients: Changes = _read("laws.toml")["parts"][name]
    return coefficients


def presets(case: str) -> dict[str, dict[str, Any]]:
    """Return the presets of a case, the usual ones first, those of the literature with a source."""
    return {name: dict(values) for name, values in _read("presets.toml").get(case, {}).items()}


def _laws(names: Iterable[str]) -> dict[str, _Law]:
    """Return laws by the names of groups and of laws, in this order."""
    chosen: dict[str, _Law] = {}
    for name in names:
        group = _groups().get(name)
        # of two groups with a law of this name, the first
        chosen |= group or {name: next(g[name] for g in _groups().values() if name in g)}
    return chosen


@cache
def _groups() -> dict[str, dict[str, _Law]]:
    groups = {}
    for name, group in _read("laws.toml").items():
        if name not in ("parts", "systems", "cases"):
            systems, quick = group.get("systems", ()), group.get("quick", True)
            both = group.get("two_materials", ())
            groups[name] = {
                law: _Law(_changes(parts), systems, quick, law in both)
                for law, parts in group["laws"].items()
            }
    return groups


def _changes(parts: Iterable[str | Changes]) -> Changes:
    rows = (part(each) if isinstance(each, str) else each for each in parts)
    return {name: value for row in rows for name, value in row.items()}


@cache
def _read(name: str) -> dict[str, Any]:
    return tomllib.loads((files(__package__) / name).read_text("utf-8"))
