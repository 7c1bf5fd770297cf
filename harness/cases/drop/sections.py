"""What a report says of the drops: collisions and what is expected of them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from harness.report.sections import Drawing, Section, Table

if TYPE_CHECKING:
    from harness.cases.drop.checks import DropEvidence

TITLE = "Drops on one fixed sphere"

EXPLAINED = (
    "An engine's results are used after it has qualified by drops on one fixed sphere. Each drop "
    "shows one fault: a dashpot that is missing or takes another effective mass (restitution), a "
    "contact that is found late (onset), a force along the tangent (oblique contact), a wrong "
    "spring (rest), a wrong clock (free fall)."
)


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
    first = shown[0]
    table = Table(
        "Drops",
        "What each drop measures, and what closed form or quadrature give under the rules that the "
        "engine declares.",
        ("engine", "drop", "measured", "expected"),
        tuple(dict.fromkeys(rows)),
        frozenset({2, 3}),
        frozenset({1}),
    )
    return (Section(TITLE, (EXPLAINED,), tables=(table,), drawings=(_drawing(first),)),)


def _drawing(evidence: DropEvidence) -> Drawing:
    from harness.cases.drop.figures import speeds_of_collisions

    return Drawing(
        "drop-collisions",
        "Head-on collisions",
        "Normal speed of a grain over time, before and after it meets a fixed sphere, by contact. "
        "The bars at the right are the expected speeds of the rebound.",
        lambda: speeds_of_collisions(evidence.made, evidence.who),
    )
