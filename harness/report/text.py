"""The words that HTML page, Markdown and terminal share: outcome, headlines, provenance."""

from __future__ import annotations

import math
from collections.abc import Sequence

from harness.comparison.findings import Headline
from harness.comparison.verification import Verification
from harness.observables.provenance import Provenance
from harness.report.templating import number
from harness.report.verdict_summary import headline, summaries

ROUND_OFF = 14
"""Decimals beyond which an uncertainty says nothing."""


def summary(found: Verification) -> list[str]:
    """Return the sentences that open the report: the outcome kind by kind, and the headlines."""
    counts = "; ".join(f"{s.kind} {s.text}" for s in summaries(found.checks))
    return [f"{headline(found.checks)}.", f"{counts}.", *headline_lines(found.headlines)]


def headline_lines(headlines: Sequence[Headline]) -> list[str]:
    """Return a sentence for each headline: expected and measured, with its uncertainty."""
    return [f"{told.name}: expected {expected(told)}; {measured(told)}" for told in headlines]


def expected(told: Headline) -> str:
    """Return the expected value with its unit, to the digits of the measured one."""
    decimals = min(ROUND_OFF, _decimals(told.uncertainty))
    return f"{told.expected:.{decimals}f} {told.unit}".rstrip()


def measured(told: Headline) -> str:
    """Return who measured what: ``code 10.2070 ± 0.0004 deg (how)``."""
    note = f" ({told.note})" if told.note else ""
    return f"{told.who} {value_text(told.value, told.uncertainty, told.unit)}{note}"


def value_text(value: float, uncertainty: float, unit: str = "") -> str:
    """Return a value as a person writes it, to the first digit of its uncertainty.

    >>> value_text(10.206981, 0.00042, "deg")
    '10.2070 ± 0.0004 deg'
    """
    if not math.isfinite(value) or not math.isfinite(uncertainty) or uncertainty <= 0.0:
        return f"{number(value)} {unit}".rstrip()
    decimals = _decimals(uncertainty)
    if decimals > ROUND_OFF:
        return f"{number(value)} {unit}".rstrip()
    return f"{value:.{decimals}f} ± {uncertainty:.{decimals}f} {unit}".rstrip()


def _decimals(uncertainty: float) -> int:
    """Return the decimals down to the first digit of an uncertainty; two digits after a 1."""
    if not math.isfinite(uncertainty) or uncertainty <= 0.0:
        return 6
    exponent = math.floor(math.log10(uncertainty))
    leading = round(uncertainty / 10.0**exponent)
    return max(0, 1 - exponent if leading == 1 else -exponent)


def engine_name(engine: Provenance) -> str:
    """Return an engine with its version, and how it was run."""
    return ", ".join(filter(None, (f"{engine.engine} {engine.engine_version}".strip(), engine.how)))


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
            ("engine", engine_name(engine)),
            ("executable", engine.executable),
            ("packages", " ".join(engine.packages)),
        ]
    return pairs
