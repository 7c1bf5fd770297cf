"""Submodels of granular contacts that not every release of LAMMPS has."""

from __future__ import annotations

from harness.engines.contract import Values
from harness.observables.release import release_of

FIRST_RELEASES = {
    "coeff_restitution": "29 Aug 2024",
    "linear_history_classic": "2 Aug 2023",
    "mindlin_classic": "2 Aug 2023",
}
"""The first stable release that has one."""


def first_lacking(values: Values, version: str) -> str:
    """Return the submodel among values that a release does not have, and which one has it.

    The old contact styles (``interface`` = old) are in every release.
    """
    told = () if values.get("interface") == "old" else values.values()
    for name, first in FIRST_RELEASES.items():
        if name in told and release_of(version) < release_of(first):
            return f"LAMMPS {version} has no {name}: LAMMPS {first} has it"
    return ""


def may_lack(values: Values) -> bool:
    """Return whether values name a submodel that some release does not have."""
    return bool(first_lacking(values, ""))
