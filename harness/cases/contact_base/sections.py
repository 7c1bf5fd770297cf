"""What a report says of a contact case: its formula, and the limits of every trial."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

from harness.cases.contact_base.study import Climbed, Evidence
from harness.report.sections import Section, Table

if TYPE_CHECKING:
    from harness.cases.contact_base.contact_case import ContactCase

HEAD = ("submodel", "system", "quantity", "limit", "uncertainty", "expected", "by", "order")


def sections_of(case: ContactCase[Any], evidence: Evidence) -> Sequence[Section]:
    """Return one section with the limits of a case in an engine."""
    rows = tuple(row for one in evidence.climbed for row in _rows(one))
    caption = f"Limits of a small step in {evidence.who}, beside what the law asks for."
    table = Table(f"Limits of {case.name}", caption, HEAD, rows, frozenset({3, 4, 5, 7}))
    return (Section(f"Contact: {case.name}", (case.summary, case.formula), tables=(table,)),)


def _rows(one: Climbed) -> Iterator[tuple[str, ...]]:
    for name, expected in one.references.items():
        reached = one.limits.get(name)
        if reached is None:
            continue
        yield (
            one.trial.submodel,
            one.trial.system,
            name,
            f"{reached.value:.9g}",
            f"{reached.uncertainty:.1e}",
            f"{expected.value:.9g}",
            expected.kind,
            f"{reached.order:.2f}",
        )
