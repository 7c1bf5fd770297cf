"""The reproduction of the source: every equation, number and figure, recomputed.

In the order of the work: ``source.toml`` has what the source says, statement by statement, with its
formulas, the condition or tolerance by which it is judged, and the sentence of what a run finds.
``ledger`` recomputes the statements by section and ``figure_data`` those of its figures, which
``figures`` draws; ``claims`` has the numbers as they are printed, makes rows of the ledger from
both, puts numbers into formulas and sentences, and compares two ledgers. ``page`` writes all of it
into a folder. ``run.reproduce`` does the whole, with tables of findings beyond the source.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from harness.reproduction.run import reproduce as reproduce

__all__ = ["reproduce"]


def __getattr__(name: str) -> Any:
    if name != "reproduce":
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from harness.reproduction.run import reproduce

    return reproduce
