"""One sentence on what agrees and what does not, put together from what was found."""

from __future__ import annotations

from collections.abc import Sequence

Fact = tuple[bool, str]
"""Whether a part of a statement holds in this run, and what was found, with its numbers."""


def agreement(facts: Sequence[Fact], remark: str = "") -> str:
    """Return what agrees and what does not, in the order of ``facts``, and a remark after it."""
    right = "; ".join(text for holds, text in facts if holds)
    wrong = "; ".join(text for holds, text in facts if not holds)
    said = [f"Agrees: {right}." if right else "", f"Does not agree: {wrong}." if wrong else ""]
    return " ".join(part for part in (*said, remark) if part)


def all_hold(facts: Sequence[Fact]) -> bool:
    """Return whether every fact holds."""
    return all(holds for holds, _ in facts)
