"""What a report says of the drops: collisions and what is expected of them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from harness.cases.case_text import Words
from harness.report.sections import Drawing, Section

if TYPE_CHECKING:
    from harness.cases.drop.checks import DropEvidence


WORDS = Words(__file__)


def sections_of(evidence: Sequence[DropEvidence]) -> Sequence[Section]:
    """Return a section with the drops of each engine, the figure of the first; none without."""
    shown = [one for one in evidence if one.made]
    if not shown:
        return ()
    rows = [
        (one.who, test.name, f"{test.measure(run):.8g}", f"{test.expected:.8g}")
        for one in shown
        for test, run in one.made
    ]
    table = WORDS.table("Drops", tuple(dict.fromkeys(rows)), (2, 3), (1,))
    return (WORDS.section("drops", tables=(table,), drawings=(_drawing(shown[0]),)),)


def _drawing(evidence: DropEvidence) -> Drawing:
    from harness.cases.drop.figures import speeds_of_collisions

    return WORDS.drawing(
        "drop-collisions", lambda: speeds_of_collisions(evidence.made, evidence.who)
    )
