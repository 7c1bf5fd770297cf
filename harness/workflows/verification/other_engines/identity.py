"""Who an engine is, and the rows of one that is not here."""

from __future__ import annotations

import math

from harness.comparison.engine_evidence import Declared
from harness.comparison.verdicts import Check, Kind, failed_run, finding, not_tested
from harness.engines.traits import Traits
from harness.errors import EngineError
from harness.observables.provenance import Provenance

UNTESTED = (
    ("qualification", Kind.ANALYTIC, ""),
    ("critical angle, plastic contact", Kind.ANALYTIC, "deg"),
    ("critical angle, source contact", Kind.CROSS_CODE, "deg"),
    ("towers", Kind.CROSS_CODE, ""),
)
"""The rows of an engine that could not be used, one for each part."""


def declared(
    name: str, traits: Traits, who: Provenance | None = None, *, missing: str = ""
) -> Declared:
    """Return what an engine declares, copied for the report, and who it is here."""
    return Declared(
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


def rows_of_missing(name: str, reason: str) -> list[Check]:
    """Return the rows of an engine that is not here: not tested, part by part."""
    return [not_tested(f"{name}: {part}", kind, reason, unit) for part, kind, unit in UNTESTED]


def rows_of_unqualified(name: str, failures: str) -> list[Check]:
    """Return the rows of an engine that is not believed: not tested, with the failed checks."""
    reason = f"it did not qualify: {failures}"
    return [
        not_tested(f"{name}: {part}", kind, reason, unit)
        for part, kind, unit in UNTESTED
        if part != "qualification"
    ]


def rows_of_dead(name: str, error: EngineError) -> list[Check]:
    """Return the rows of an engine that is here but cannot even say who it is."""
    return [failed_run(f"{name}: identification", Kind.ANALYTIC, error)]


def version_row(name: str, traits: Traits, who: Provenance) -> list[Check]:
    """Return a finding where an engine's version is not one that it was tried with."""
    if who.engine_version in traits.versions:
        return []
    tried = ", ".join(traits.versions) or "none"
    note = f"version {who.engine_version}: not one that it was tried with ({tried})"
    return [finding(f"{name}: version", math.nan, math.nan, "", note)]
