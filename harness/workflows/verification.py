"""Verify engines: from level, cases and engines to a run.

Every engine is treated alike: it is opened, qualifies, and runs the checks of each case; the
solvers of this package are one more bench. Then engines are compared with one another, and all rows
with the accepted run. Whatever fails is a row, and the rest goes on.

Several processes share the cases: each takes one after another, as long as there are any, lists
their checks, and then runs them.
"""

from __future__ import annotations

import platform
import sys
import time
from collections import defaultdict
from collections.abc import Callable, Generator, Iterable, Sequence, Set
from concurrent.futures import Executor, ThreadPoolExecutor
from contextlib import ExitStack, closing
from datetime import UTC, datetime
from functools import partial
from itertools import chain
from pathlib import Path
from threading import Thread

from harness import __version__
from harness.cases.bench import OWN
from harness.cases.registry import ALL, QUALIFYING, case_names, selected_cases, words_in
from harness.engines.registry import DEFAULT, engine_names
from harness.errors import RequestError
from harness.files import check_folder
from harness.results.rows import LEVELS, Level, table
from harness.store.cache import opened
from harness.store.committed import accepted_rows
from harness.store.committed import known_defects as load_defects
from harness.store.runs import Meta, Run, write_run
from harness.workflows import Progress, silent
from harness.workflows.executors import Copy, Queue, opened_on
from harness.workflows.runs import OpenEngine
from harness.workflows.session import (
    SIDE_BY_SIDE,
    Outline,
    Part,
    Session,
    compiled_beside,
    kernels_are_new,
    opened_engines,
)
from harness.workflows.settings import selected_engines

CASES_OF_A_COPY = 4  # at least: one opens engines of its own
PLATFORM = f"{platform.system()} {platform.machine()}, Python {platform.python_version()}"


def verify(  # noqa: PLR0913 - the options of a user
    level: Level = "default",
    *,
    cases: str | Iterable[str] | None = None,
    engines: str | Iterable[str] = DEFAULT,
    only: str = "",
    strict: bool = False,
    known_defects: str | Path | None = None,
    output: str | Path | None = None,
    png: bool = False,
    open_engine: OpenEngine = opened,
    executor: Executor | None = None,
    processes: int = 1,
    check_duration: Callable[[float], None] = lambda _: None,
    progress: Progress = silent,
) -> Run:
    """Compare engines with theory, with one another and with the accepted run; return the rows.

    ``cases`` are names, groups or ``all``; ``engines`` are names or ``all``, every engine that is
    here. ``only`` is a pattern of ``case/setup/quantity``, in all cases unless some are named.
    ``known_defects`` is a file of defects that join the committed ones; a ``strict`` run fails also
    where a row was not tested. ``output`` is a new folder for the report, with figures as PNG too
    for ``png``. With an ``executor`` its workers run the engines, in place of ``open_engine``.
    Up to so many ``processes`` share the cases, on Linux and where kernels are compiled already:
    copies of this one, by fork. ``check_duration`` is called with the expected time on one core
    [s], and may raise.

    An engine that is missing, dies or does not qualify, a case that raises, and of ``all`` a
    broken engine, or a broken or hidden case, of another package, are rows. Raise RequestError,
    before a case runs, for an unknown level, case, engine or pattern; BrokenCaseError for a broken
    case that is named.
    """
    if level not in LEVELS:
        raise RequestError(f"level = {level!r} is not known: must be one of {', '.join(LEVELS)}")
    if output is not None:
        check_folder(Path(output))
    cases = ALL if only and cases is None else cases
    started, clock = datetime.now(UTC).isoformat(timespec="seconds"), time.monotonic()
    opening = open_engine if executor is None else partial(opened_on, executor)
    total = _summed(progress)
    with ExitStack() as stack:
        ahead = ThreadPoolExecutor(SIDE_BY_SIDE)
        stack.callback(ahead.shutdown, cancel_futures=True)
        engines_here = ahead.submit(opened_engines, selected_engines(engines), opening, stack)
        chosen, broken = selected_cases(cases)  # importing cases takes as long
        defects = load_defects(None if known_defects is None else Path(known_defects))
        session = Session(level, only or "*", chosen, defects, partial(total, 0), ahead,
                          broken=broken, has_report=output is not None)  # fmt: skip
        session.add(engines_here.result())
        if executor is not None or kernels_are_new():  # which each process would compile
            processes = 1
        everything = ALL in words_in(engines)
        versions = {n: v for n, v in session.versions.items() if v or not everything}
        accepted = accepted_rows(versions)
        copies = _planned(session, processes, total, stack)
        outlines = [session.outline(), *(copy.receive() for copy in copies)]
        tested = {name for outline in outlines for name in outline.tested}
        session.check_pattern(tested)
        check_duration(sum(outline.seconds for outline in outlines))
        has_figures = any(case.has_figures for case in chosen)
        loading = Thread(target=_load_report, args=(has_figures,))
        if output is not None:  # it takes long: engines run meanwhile
            loading.start()
        _run(session, copies, tested)
        meta = Meta(
            level=level,
            cases=tuple(case.name for case in chosen),
            engines=versions,
            left_out=tuple(name for name in engine_names() if name not in versions),
            named=tuple(word for word in words_in(cases or ()) if word in case_names()),
            unqualified=tuple(session.unqualified),
            only=session.only,
            strict=strict,
            started=started,
            seconds=time.monotonic() - clock,
            platform=PLATFORM,
            harness_version=__version__,
        )
        run = Run(table(session.all_rows()), meta, scripts=session.scripts(), logs=session.logs())
        run = run.against(accepted)
        if output is not None:
            from harness.report.page import report_files

            progress("figures and report", 0, 1)
            loading.join()  # the look of figures is that of all threads
            by_name = {defect.name: dict(defect) for defect in session.defects}
            pages = report_files(run, session.sections(), defects=by_name, png=png)
            write_run(run, Path(output), pages)
            progress("figures and report", 1, 1)
    return run


def _planned(
    session: Session, processes: int, total: Callable[[int, str, int, int], None], stack: ExitStack
) -> list[Copy]:
    """Share the cases out, list their checks, and return the copies of this process."""
    first = [case for case in session.cases if case.name in QUALIFYING]
    rest = [case for case in session.cases if case not in first]
    queue = stack.enter_context(Queue(rest))

    def work(progress: Progress) -> Generator[Outline | Part, Sequence[str], None]:
        with closing(session.copied(progress)) as copied:
            copied.plan(queue)
            copied.leave_out((yield copied.outline()))
            copied.run()
            yield copied.part()

    # libraries of other systems do not survive a fork
    can_be_copied = sys.platform == "linux" and all(e.can_be_copied for e in session.engines)
    most = max(1, min(processes, len(rest) // CASES_OF_A_COPY)) if can_be_copied else 1
    for engine in session.engines:
        engine.share_cores(most)
    copies = [stack.enter_context(Copy(work, partial(total, place))) for place in range(1, most)]
    session.prepare_qualification()
    session.plan(chain(first, queue))
    return copies


def _run(session: Session, copies: Sequence[Copy], tested: Set[str]) -> None:
    """Qualify engines in this process, and run the checks of all processes."""
    with compiled_beside(if_new=OWN in tested) as wait:
        session.run_ahead(wait)
        session.qualify(tested)
        for copy in copies:
            copy.send(session.unqualified)
        parts = [session.ahead.submit(copy.receive) for copy in copies]
        session.run(wait)
    for copy, part in zip(copies, parts, strict=True):
        session.take_over(part.result())
        copy.close()


def _summed(progress: Progress) -> Callable[[int, str, int, int], None]:
    """Return a function for the progress of each process, by its place, that shows the sum."""
    parts: defaultdict[str, dict[int, tuple[int, int]]] = defaultdict(dict)

    def note(place: int, stage: str, done: int, total: int) -> None:
        parts[stage][place] = done, total
        progress(stage, *map(sum, zip(*parts[stage].values(), strict=True)))

    return note


def _load_report(has_figures: bool) -> None:
    from harness.report import page

    page.load(figures=has_figures)
