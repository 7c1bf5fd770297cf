"""Make the section on engines beside one another: what each declares, and whether it was used."""

from __future__ import annotations

from collections.abc import Sequence

from harness.comparison.engines import DeclaredEngine
from harness.report.sections import Section, Table

TITLE = "Engines beside one another"

EXPLAINED = (
    "Two classes of contact law must not be compared as one: a code that clips the attractive "
    "tail rebounds where one that keeps it does not, and half the effective mass damps less. So "
    "each engine stands beside theory, and beside the reference DEM under the engine's own rules "
    "(tail, effective mass, spring, scheme, step). Differences between classes are findings. An "
    "engine's results are used after it has qualified on one fixed sphere. Agreement with an "
    "engine that grew out of another is a regression test, not independent evidence."
)

HEAD = (
    "engine",
    "version",
    "tails",
    "m_eff",
    "spring",
    "scheme",
    "digits",
    "grew out of",
    "status",
)


def engines_section(engines: Sequence[DeclaredEngine]) -> Section:
    """Return the table of what engines declare, and what their users have to know."""
    table = Table(
        "What each engine declares",
        "What each engine declares. Tail and effective mass are those that it can be told; the "
        "scheme is the reference DEM's name for it.",
        HEAD,
        tuple(_row(declared) for declared in engines),
        frozenset({6}),
        frozenset({8}),
    )
    caveats = tuple(f"{d.engine}: {' '.join(d.caveats)}" for d in engines if d.caveats)
    return Section(TITLE, (EXPLAINED,), caveats, (table,))


def _row(declared: DeclaredEngine) -> tuple[str, ...]:
    reason = declared.missing or declared.unqualified
    return (
        declared.engine,
        ", ".join(filter(None, (declared.version, declared.how))) or "not here",
        ", ".join(declared.tails),
        ", ".join("m" if mass == "full" else "m/2" for mass in declared.effective_masses),
        declared.spring,
        declared.integrator or "its own",
        str(declared.digits),
        declared.lineage or "independent",
        f"{declared.summary}: {reason}" if reason else declared.summary,
    )
