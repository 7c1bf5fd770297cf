"""Explain the class of a failure to the reader of a report."""

from __future__ import annotations

import math

from harness.comparison.verdicts import Check
from harness.shown import number

EXPLAINED = {
    "diverged from the first step": "The two differ from the start: another law, parameter or "
    "initial state, not an accumulated error.",
    "diverged late": "The two agree at first and part later: an event (a contact that opens or "
    "closes) fell differently, or an error grew.",
    "out of tolerance": "The value moved by more than its tolerance; no series tells when.",
    "wrong input": "The engine was given something else than was asked for.",
    "refused": "The engine refused its input and said why.",
    "engine error": "The engine ended with an error of its own.",
    "crashed": "The engine's process died: a signal, an abort, or an exit status.",
    "bad output": "The engine ended without a complete result.",
    "lost atoms": "A particle left its box: most often a step that is too long.",
    "not found": "The engine, or a library it needs, is not here.",
    "nan": "A value that is not a number was met or returned.",
    "out of time": "The run did not finish in the time it was given.",
    "out of memory": "The run asked for more memory than it was given.",
    "not tested": "The check could not be made; its note says why. This is never a pass.",
}
"""By class in lower case; a class that is not here stands without an explanation."""


def triage(check: Check) -> str:
    """Return the class of a failure; empty for what the verdict says already."""
    return "" if check.triage == check.verdict else check.triage.partition(":")[0]


def details(check: Check) -> str:
    """Return what the triage says beyond the class: of what kind, where and when."""
    return check.triage.partition(":")[2].strip()


def explained(check: Check) -> str:
    """Return what the class of a failure means, by its kind where that is known."""
    by_class = EXPLAINED.get(check.triage.partition(":")[0].lower(), "")
    return EXPLAINED.get(details(check).lower(), by_class)


def happened(check: Check) -> str:
    """Return in a line why a check stands as it does: value against expected, or the note."""
    if math.isnan(check.value):
        return check.note
    return (
        f"{number(check.value)} against {number(check.expected)} {check.unit}".rstrip()
        + f", {number(check.difference, 2)} apart, {number(check.tolerance, 2)} allowed"
    )


def numbers(check: Check) -> str:
    """Return value, expected, difference, uncertainty and tolerance in a line."""
    unit = f" {check.unit}" if check.unit else ""
    return (
        f"value {number(check.value)}{unit}, expected {number(check.expected)}{unit}, "
        f"difference {number(check.difference, 3)}, uncertainty {number(check.uncertainty, 3)}, "
        f"tolerance {number(check.tolerance, 3)}"
    )
