"""Write the sentences that HTML page, Markdown and terminal share."""

from __future__ import annotations

from collections.abc import Sequence

from harness.comparison.findings import Headline
from harness.comparison.verification import Verification
from harness.report.verdict_summary import headline, summaries
from harness.shown import ROUND_OFF, decimals, value_text


def summary(found: Verification) -> list[str]:
    """Return the sentences that open the report: the outcome kind by kind, and the headlines."""
    counts = "; ".join(f"{s.kind} {s.text}" for s in summaries(found.checks))
    return [
        f"{headline(found.checks, found.untested_cases)}.",
        f"{counts}.",
        *headline_lines(found.headlines),
    ]


def headline_lines(headlines: Sequence[Headline]) -> list[str]:
    """Return a sentence for each headline: expected and measured, with its uncertainty."""
    return [f"{told.name}: expected {expected(told)}; {measured(told)}" for told in headlines]


def expected(told: Headline) -> str:
    """Return the expected value with its unit, to the digits of the measured one."""
    places = min(ROUND_OFF, decimals(told.uncertainty))
    return f"{told.expected:.{places}f} {told.unit}".rstrip()


def measured(told: Headline) -> str:
    """Return who measured what: ``code 10.2070 ± 0.0004 deg (how)``."""
    note = f" ({told.note})" if told.note else ""
    return f"{told.who} {value_text(told.value, told.uncertainty, told.unit)}{note}"


def provenance(found: Verification) -> list[tuple[str, str]]:
    """Return what made this report, as pairs of name and text."""
    engine = found.provenance
    pairs = [
        ("started", found.started),
        ("took", f"{found.seconds:.1f} s"),
        ("level", found.level),
        ("cases", ", ".join(found.cases)),
        ("dem-harness", found.harness_version),
        ("platform", found.platform),
    ]
    if engine is not None:
        pairs += [
            ("engine", engine.told),
            ("executable", engine.executable),
            ("packages", " ".join(engine.packages)),
        ]
    return pairs
