"""The ledger of the source: every equation, number and claim, recomputed and judged.

No row is typed in. What the source prints is evaluated by
:mod:`harness.reproduction.claims` and held against a route that shares no
code with it: theory, exact propagator, complementarity, iteration, root finding, or
algebra over random samples with a fixed seed. The sentences stand in ``source.toml``.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import partial

from harness.engines.contract import Engine
from harness.reproduction.claims import PRINTED, SOURCES, Printed, Statement
from harness.reproduction.ledger import appendix, background, methods, results
from harness.workflows.progress import Progress, silent

Section = Callable[[Printed], Iterable[Statement]]


def statements(
    printed: Printed = PRINTED, engine: Engine | None = None, progress: Progress = silent
) -> list[Statement]:
    """Return every row but the figures', in the order of the publication.

    Rows of the incline that need an engine cannot be tested without one; a failure of
    the engine becomes their reason.
    """
    sections: tuple[Section, ...] = (
        background.introduction_statements,
        background.background_energy_statements,
        partial(background.background_incline_statements, engine=engine),
        methods.methods_scales_statements,
        methods.methods_pair_statements,
        methods.methods_chain_statements,
        results.results_statements,
        results.discussion_statements,
        appendix.appendix_chains_statements,
        appendix.appendix_window_statements,
        appendix.beyond_statements,
    )
    rows: list[Statement] = []
    for done, section in enumerate(sections):
        progress("ledger", done, len(sections))
        rows += section(printed)
    progress("ledger", len(sections), len(sections))
    return in_order(rows)


def in_order(rows: Iterable[Statement]) -> list[Statement]:
    """Return rows in the order of the publication."""
    place = {key: number for number, key in enumerate(SOURCES)}
    return sorted(rows, key=lambda row: place[row.source.key])
