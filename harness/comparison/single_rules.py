"""Which single rule, if any, reproduces a contact that fails under the rules of its engine.

The author of a code needs to know what it does, not only that a row fails. Where a case can compute
a row under other rules (:class:`~harness.parameters.rules.Rules`), each of their words is tried
alone in place of the engine's own.
"""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import get_args

from harness.comparison.known_defects import Prediction
from harness.comparison.verdicts import Check, Verdict
from harness.parameters.rules import Rules

SECONDS = 60.0
"""Of integrations for all rows that fail; what is left then says so."""

HOLDS, ALONE, NONE, SPENT = (
    "holds under {}",
    "this value alone holds under {}; other quantities of the contact do not",
    "no single rule of the harness reproduces it",
    "not searched for a rule that reproduces it: {:g} s of integrations are spent",
)


def with_single_rules(
    checks: Sequence[Check], raw: Sequence[Check], seconds: float = SECONDS
) -> tuple[Check, ...]:
    """Return the checks; the note of a failure says which single rule reproduces its value.

    ``raw`` are the same rows as their cases left them, which can still compute a prediction. A rule
    reproduces a row where the row would hold under it, within its own tolerance, and every other
    value of the same contact too.
    """
    end = time.monotonic() + seconds
    contacts: dict[tuple[str, ...], list[Check]] = {}
    for row in raw:
        if row.predict is not None and row.judged and row.cell and not row.cell.invariance:
            contacts.setdefault(row.cell.place, []).append(row)
    noted = []
    for check, row in zip(checks, raw, strict=True):
        if check.verdict is Verdict.FAIL and row.cell and row in contacts.get(row.cell.place, ()):
            spent = time.monotonic() > end
            others = contacts[row.cell.place]
            note = SPENT.format(seconds) if spent else _reproduced(row, others)
            check = replace(check, note="; ".join(filter(None, (check.note, note))))
        noted.append(check)
    return tuple(noted)


def _reproduced(row: Check, contact: Sequence[Check]) -> str:
    """Return the sentence on a row; ``contact`` are all rows of its contact."""
    alone = {words: rule for words, rule in _rules() if _holds(row, rule)}
    if not alone:
        return NONE
    full = [words for words, rule in alone.items() if all(_holds(check, rule) for check in contact)]
    return (HOLDS if full else ALONE).format(", or under ".join(full or alone))


def _rules() -> Iterator[tuple[str, Prediction]]:
    """Yield each word of each rule, as ``wall_lever = height``; factors are no choice of a code."""
    for name, field in Rules.model_fields.items():
        for word in get_args(field.annotation):
            yield f"{name} = {word}", Prediction(rules={name: word})


def _holds(row: Check, rule: Prediction) -> bool:
    """Return whether a row would hold under a rule; one under which it has no value does not."""
    try:
        return row.predict is not None and row.predict(rule, None).includes(row.value)
    except (ArithmeticError, ValueError):
        return False
