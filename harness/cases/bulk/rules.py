"""By which rules a code follows the bulk cases' law, and whether two codes follow the same.

The law is Hertz's with a dashpot for the restitution, Mindlin's without one, Coulomb's. Codes take
its tangential spring and the tail of its dashpot in their own ways, which they declare with the
contact models of pairs. Where two codes' ways differ, means that differ are no fault of either.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

from harness.comparison.verdicts import Check, Kind, Verdict, finding
from harness.engines.traits import Traits, stating

if TYPE_CHECKING:
    from harness.engines.contract import Value

SPRINGS = {
    "mindlin": "a displacement, times the stiffness of the overlap as it is",
    "mindlin/force": "a force that grows by increments",
    "mindlin_rescale/force": "a force that grows by increments and shrinks with the overlap",
}
"""Tangential springs, in the order of preference: the first is that of the scripts of LAMMPS."""

PAIR: Mapping[str, Value] = {
    "normal": "hertz",
    "poisson_ratio": 0.2,
    "tangential_damping": 0.0,
    "friction": 0.3,
    "rolling": "none",
    "twisting": "none",
    "interface": "current",
    "motion_1": "free",
    "planes": 0,
}
"""Two grains, by the names of values of contact jobs."""


def law_of(traits: Traits) -> str:
    """Return by which rules an engine follows the law, in words: equal for equal rules.

    Of an engine that states no dashpot beside tangential springs without one, it is its own words
    for why.
    """
    reason = ""
    for damping in ("coeff_restitution", "none"):
        for spring, words in SPRINGS.items():
            for clipped, tail in (("no", "attracts"), ("yes", "never attracts")):
                choice = {"damping": damping, "tangential": spring, "clipped": clipped}
                why = stating(traits.contact_models, {**PAIR, **choice})[1]
                if not why:
                    law = f"the tangential spring is {words}"
                    return f"{law}; {reason}" if reason else f"{law}; the dashpot {tail}"
                if spring == "mindlin_rescale/force" and clipped == "yes":
                    reason = why
    return reason


def differing(check: Check, one: str, first: str, other: str, second: str) -> Check:
    """Return a comparison of two engines; a failure between different laws as a finding."""
    if first == second:
        return check
    note = f"{check.note}; {one}: {first}; {other}: {second}"
    if check.verdict is not Verdict.FAIL:
        return replace(check, note=note)
    assert check.kind is Kind.CROSS_CODE
    return finding(check.name, check.value, 1.0, "", note, uncertainty=check.uncertainty)
