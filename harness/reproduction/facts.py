"""Statements of several facts: what agrees and what does not, in one sentence."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from harness.reproduction.claims import Statement, claim
from harness.reproduction.source import Source

Fact = tuple[bool, str]
"""Whether a part of a statement holds in this run, and what was found, with its numbers."""


def claim_of_facts(
    source: Source,
    facts: Sequence[Fact],
    remark: str = "",
    *,
    holds: bool | None = None,
    corrected_holds: bool = False,
    correction: str | None = None,
) -> Statement:
    """Return the row of a statement that holds if every fact does, unless told otherwise."""
    return claim(
        source,
        holds=all_hold(facts) if holds is None else holds,
        computed=agreement(facts, remark),
        corrected_holds=corrected_holds,
        correction=correction,
    )


def agreement(facts: Sequence[Fact], remark: str = "") -> str:
    """Return what agrees and what does not, in the order of ``facts``, and a remark after it."""
    right = "; ".join(text for holds, text in facts if holds)
    wrong = "; ".join(text for holds, text in facts if not holds)
    said = [f"Agrees: {right}." if right else "", f"Does not agree: {wrong}." if wrong else ""]
    return " ".join(part for part in (*said, remark) if part)


def all_hold(facts: Iterable[Fact]) -> bool:
    """Return whether every fact holds."""
    return all(holds for holds, _ in facts)
