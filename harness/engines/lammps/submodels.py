"""Submodels of granular contacts that not every release of LAMMPS has."""

from __future__ import annotations

from collections.abc import Callable

from harness.engines.contract import Values
from harness.errors import EngineMissingError
from harness.observables.provenance import Provenance
from harness.observables.release import release_of

FIRST_RELEASES = {
    "coeff_restitution": "29 Aug 2024",
    "mdr": "22 Jul 2025",
    "linear_history_classic": "2 Aug 2023",
    "mindlin_classic": "2 Aug 2023",
}
"""The first stable release that has one."""

MIXES_MODELS = "28 Mar 2023"
"""The first release whose pair_style granular gives types that it mixes their submodels, too."""

GRANULAR = {"wall_force": "magnified", "mdr_friction": "hertz"}
"""Rules of pair_style granular and of its walls, of mdr alone."""


def lacking(values: Values, identify: Callable[[], Provenance]) -> str:
    """Return the submodel among values that a release does not have, and which one has it.

    Or why no release takes them together.

    The old contact styles (``interface`` = old) are in every release. Nothing where LAMMPS is not
    here: that is said when it is to run.
    """
    newton_on = values.get("newton") == "on" or values.get("defaults") == "yes"
    if values.get("normal") == "mdr" and newton_on:
        return "its mdr takes newton = off, not on"
    if "partner_youngs_modulus" in values:
        if values["planes"]:
            return "its walls take the coefficients of the contact, and mix none (stated has them)"
        if values["tangential"] == "mindlin_classic":
            return "it mixes materials where G* follows from them (mindlin NULL)"
    told = () if values.get("interface") == "old" else values.values()
    for name, first in FIRST_RELEASES.items():
        if name not in told:
            continue
        try:
            version = identify().engine_version
        except EngineMissingError:
            return ""
        if release_of(version) < release_of(first):
            return f"LAMMPS {version} has no {name}: LAMMPS {first} has it"
    return ""
