"""The ledger of the source: every equation, number and claim, recomputed and judged.

No row is typed in. What the source prints is evaluated by
:mod:`harness.reproduction.as_printed` and held against a route that shares no
code with it: theory, exact propagator, complementarity, iteration, root finding, or
algebra over random samples with a fixed seed.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import partial

from harness.engines.contract import Engine
from harness.reproduction.as_printed import PRINTED, Printed
from harness.reproduction.claims import Ledger, Statement, untestable
from harness.reproduction.ledger import (
    appendix_boundaries,
    appendix_chains,
    appendix_window,
    background_energy,
    background_incline,
    background_shock,
    beyond,
    discussion,
    errata,
    introduction,
    methods_chain,
    methods_pair,
    methods_scales,
    methods_shock,
    results,
    results_impulse,
)
from harness.reproduction.source import SOURCES
from harness.workflows.progress import Progress, silent

Section = Callable[[], list[Statement]]


def statements(
    printed: Printed = PRINTED, engine: Engine | None = None, progress: Progress = silent
) -> list[Statement]:
    """Return every row but the figures', in the order of the publication, the errata at the end.

    Rows of the incline that need an engine cannot be tested without one; a failure of
    the engine becomes their reason.
    """
    sections = _sections(printed, engine)
    rows = [untestable(s) for s in SOURCES.values() if s.untestable and not s.title]
    for done, section in enumerate(sections):
        progress("ledger", done, len(sections) + 1)
        rows += section()
    progress("ledger", len(sections), len(sections) + 1)
    rows += errata.statements(printed, Ledger(tuple(rows)))
    progress("ledger", len(sections) + 1, len(sections) + 1)
    return in_order(rows)


def in_order(rows: Iterable[Statement]) -> list[Statement]:
    """Return rows in the order of the publication."""
    place = {key: number for number, key in enumerate(SOURCES)}
    return sorted(rows, key=lambda row: place[row.source.key])


def _sections(printed: Printed, engine: Engine | None) -> list[Section]:
    """Return the parts of the source, in its order, and what was found wrong beyond the errata."""
    return [
        introduction.statements,
        partial(background_energy.statements, printed),
        partial(background_shock.statements, printed),
        partial(background_incline.statements, printed, engine),
        partial(methods_scales.statements, printed),
        methods_shock.statements,
        partial(methods_pair.statements, printed),
        methods_chain.statements,
        partial(results.statements, printed),
        partial(results_impulse.statements, printed),
        partial(discussion.statements, printed),
        appendix_boundaries.statements,
        appendix_chains.statements,
        partial(appendix_window.statements, printed),
        beyond.statements,
    ]
