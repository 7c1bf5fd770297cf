"""The rows on who an engine is, and of one that is not here."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any

from harness.cases.contract import Case
from harness.comparison.engines import DeclaredEngine
from harness.comparison.verdicts import Check, Kind, finding, not_tested
from harness.engines.traits import Traits
from harness.observables.provenance import Provenance

NO_TRAITS = Traits(install_hint="", versions=(), integrator="", tails=(), effective_masses=())
"""Of an engine whose class cannot be imported."""


def declared(
    name: str, traits: Traits, who: Provenance | None = None, *, missing: str = ""
) -> DeclaredEngine:
    """Return what an engine declares, copied for the report, and who it is here."""
    return DeclaredEngine(
        engine=name,
        version=who.engine_version if who else "",
        how=who.how if who else "",
        install_hint=traits.install_hint,
        versions=traits.versions,
        integrator=traits.integrator,
        tails=tuple(traits.tails),
        effective_masses=tuple(traits.effective_masses),
        spring=traits.spring,
        digits=traits.digits,
        lineage=traits.lineage,
        caveats=traits.caveats,
        missing=missing,
    )


def untested(engine: str, cases: Iterable[Case[Any]], reason: str) -> list[Check]:
    """Return a row for each case that could not be run in an engine."""
    return [not_tested(f"{engine}: {case.name}", Kind.CROSS_CODE, reason) for case in cases]


def version_rows(name: str, traits: Traits, who: Provenance) -> list[Check]:
    """Return a finding where an engine's version is not one that it was tried with."""
    if who.engine_version in traits.versions:
        return []
    tried = ", ".join(traits.versions) or "none"
    note = f"version {who.engine_version}: not one that it was tried with ({tried})"
    return [finding(f"{name}: version", math.nan, math.nan, "", note)]
