"""Verify engines: from level, cases and engines to a run.

Every engine is treated alike: it is opened, qualifies, and runs the checks of each case; the
solvers of this package are one more bench. Then engines are compared with one another, and all rows
with the accepted run. Whatever fails is a row, and the rest goes on.
"""

from __future__ import annotations

import platform
import sys
import time
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import Executor, ThreadPoolExecutor
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass, field, replace
from datetime import UTC, datetime
from fnmatch import fnmatchcase
from functools import partial
from itertools import chain, product
from pathlib import Path
from subprocess import DEVNULL, Popen
from threading import Thread
from typing import Any

from harness import __version__
from harness.cases.base import Case, CaseError, Check, case_error
from harness.cases.bench import OWN, Bench, job_key
from harness.cases.checks import FULL_DIGITS, error_row, run_checks, selected
from harness.cases.registry import ALL, QUALIFYING, case_names, get_case, selected_cases, words_in
from harness.engines.base import SCENE, Engine, Job, job_seconds
from harness.engines.process import one_thread, parallel_each, parallel_map
from harness.engines.registry import DEFAULT, engine_names
from harness.errors import (
    EngineError,
    EngineMissingError,
    HarnessError,
    RequestError,
    Unsupported,
)
from harness.files import check_folder
from harness.report.content import Section
from harness.results.defects import KnownDefect
from harness.results.rows import (
    LEVELS,
    Failure,
    Level,
    Row,
    Verdict,
    failed,
    finding,
    not_tested,
    table,
)
from harness.store.cache import opened
from harness.store.committed import accepted_rows
from harness.store.committed import known_defects as load_defects
from harness.store.runs import ABOUT_ENGINES, Meta, Run, write_run
from harness.workflows import Progress, silent
from harness.workflows.executors import opened_on
from harness.workflows.runs import OpenEngine
from harness.workflows.settings import selected_engines

Key = tuple[str, str]  # engine and case
COMPILE_CHAINS = "from harness.cases.tower.runs import compile_chains; compile_chains()"
SIDE_BY_SIDE = 4  # cases at a time: solvers compute while others wait for an engine
PLATFORM = f"{platform.system()} {platform.machine()}, Python {platform.python_version()}"
NO_CHECKS = "the case has no checks of this engine"
RETURNED = {
    "checks": (Check, "a list of harness.cases.base.Check"),
    "own_checks": (Check, "a list of harness.cases.base.Check"),
    "comparisons": (tuple, "a list of pairs (Engine, Check)"),
    "sections": (Section, "a list of harness.report.content.Section"),
}  # by the methods of a case


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
    check_duration: Callable[[float], None] = lambda _: None,
    progress: Progress = silent,
) -> Run:
    """Compare engines with theory, with one another and with the accepted run; return the rows.

    ``cases`` are names, groups or ``all``; ``engines`` are names or ``all``, every engine that is
    here. ``only`` is a pattern of ``case/setup/quantity``, in all cases unless some are named.
    ``known_defects`` is a file of defects that join the committed ones; a ``strict`` run fails also
    where a row was not tested. ``output`` is a new folder for the report, with figures as PNG too
    for ``png``. With an ``executor`` its workers run the engines, in place of ``open_engine``.
    ``check_duration`` is called with the expected time on one core [s], and may raise.

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
    chosen, broken = selected_cases(cases)
    started, clock = datetime.now(UTC).isoformat(timespec="seconds"), time.monotonic()
    with ExitStack() as stack:
        defects = load_defects(None if known_defects is None else Path(known_defects))
        ahead = ThreadPoolExecutor(SIDE_BY_SIDE)
        stack.callback(ahead.shutdown, cancel_futures=True)
        session = Session(level, only or "*", chosen, defects, progress, ahead, broken=broken)
        opening = open_engine if executor is None else partial(opened_on, executor)
        session.open(selected_engines(engines), opening, stack)
        everything = ALL in words_in(engines)
        versions = {n: v for n, v in session.versions.items() if v or not everything}
        accepted = accepted_rows(versions)
        session.plan()
        check_duration(session.seconds())
        has_figures = any(case.has_figures for case in chosen)
        loading = Thread(target=_load_report, args=(has_figures,))
        if output is not None:  # it takes long: engines run meanwhile
            loading.start()
        session.run()
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


@contextmanager
def _compiled_chains(*, if_new: bool) -> Iterator[Callable[[], Any]]:
    """Compile the kernels of chains where they are new, in another process; yield a wait for it.

    Numba compiles one kernel at a time in a process.
    """
    from harness import compiled, solvers  # slow to import: numba

    if not if_new or not compiled.waits_for_compilation(Path(solvers.__path__[0])):
        yield lambda: None
        return
    command = [sys.executable, "-P", "-c", COMPILE_CHAINS]
    with Popen(command, stdout=DEVNULL, stderr=DEVNULL, env=one_thread()) as process:
        try:
            yield process.wait
        finally:
            process.kill()


def _load_report(has_figures: bool) -> None:
    from harness.report import page

    page.load(figures=has_figures)


@dataclass
class Session:
    """A verification on its way: benches by engine, checks by engine and case, rows so far.

    ``broken`` are the cases that cannot be used, broken or hidden, with the reason. ``ahead`` makes
    what is needed later: runs of qualifications while checks are listed, references while engines
    run.
    """

    level: Level
    only: str
    cases: Sequence[Case[Any]]
    defects: Sequence[KnownDefect]
    progress: Progress
    ahead: Executor
    broken: Mapping[str, str] = field(default_factory=dict)
    versions: dict[str, str] = field(default_factory=dict)
    benches: dict[str, Bench] = field(default_factory=dict)
    checks: dict[Key, list[Check]] = field(default_factory=dict)
    comparisons: dict[Key, list[Check]] = field(default_factory=dict)
    rows: dict[Key, list[Row]] = field(default_factory=dict)
    unqualified: list[str] = field(default_factory=list)

    @property
    def engines(self) -> list[Engine]:
        """Return the engines that are installed and qualify."""
        return [bench.engine for name, bench in self.benches.items() if name != OWN]

    def open(self, names: Sequence[str], open_engine: OpenEngine, stack: ExitStack) -> None:
        """Open engines in a stack; of one that is missing no case is tested."""
        self.versions[OWN], self.benches[OWN] = __version__, Bench(None, others=self.benches)
        for name in names:
            try:
                engine = stack.enter_context(open_engine(name))
                version = engine.identify().engine_version or "unknown"
            except EngineMissingError as error:
                self.versions[name] = ""
                self._skip(name, str(error))
            except EngineError as error:
                self.versions[name] = ""
                self.rows[name, ""] = [error_row(self._blank(name, ABOUT_ENGINES), error)]
            else:
                if engine.name in self.benches:
                    raise RequestError(f"--engines: two engines have the name {engine.name!r}")
                self.versions[engine.name] = version
                self.benches[engine.name] = Bench(engine, others=self.benches)
                self.rows[engine.name, ""] = self._findings(engine)

    def _findings(self, engine: Engine) -> list[Row]:
        """Return what the verdicts about an engine rest on: its version, and few digits."""
        blank, rows = self._blank(engine.name, ABOUT_ENGINES), list[Row]()
        version, digits = self.versions[engine.name], engine.traits.digits
        if version not in (tried := engine.traits.versions):
            text = f"not one that it was tried with ({', '.join(tried) or 'none'})"
            rows.append(replace(blank, setup="version", note=f"version {version}: {text}"))
        if digits < FULL_DIGITS:
            text = "by its own account: a fault that they hide is within the tolerances"
            rows.append(replace(blank, setup="output", quantity="digits", unit="1", value=digits,
                                note=text))  # fmt: skip
        return [finding(row) for row in rows]

    def plan(self) -> None:
        """List the checks, while engines run their qualification.

        Raise RequestError where the pattern selects none of them.
        """
        for engine in self.engines:
            self.ahead.submit(self._prepare_qualification, self.benches[engine.name])
        for name, reason in self.broken.items():
            self._add(not_tested(self._blank(OWN, name), reason))
        for case in self.cases:
            self._plan(OWN, case, "own_checks")
            for engine in self.engines:
                self._plan(engine.name, case, "checks", engine, self.level)
        self._plan_comparisons()
        for engine, case in product(self.engines, self.cases) if self.only == "*" else ():
            key = engine.name, case.name
            if not (self.checks.get(key) or self.comparisons.get(key) or key in self.rows):
                self._add(not_tested(self._blank(*key), f"{NO_CHECKS} at level {self.level}"))
        planned = any([*self.checks.values(), *self.comparisons.values()])
        planned = planned or any((OWN, name) in self.rows for name in self.broken)
        if self.engines and self.only != "*" and not planned:
            raise RequestError(
                f"--only {self.only!r}: matches no case/setup/quantity of this level"
            )

    @staticmethod
    def _prepare_qualification(bench: Bench) -> None:
        checks = (qualifying(get_case(name), bench.engine) for name in QUALIFYING)
        jobs = (job for check in chain(*checks) for job in check.jobs)
        bench.prepare([job for job in jobs if not bench.refusal(job)])

    def seconds(self) -> float:
        """Return the expected time of all jobs on one core [s]."""
        total = 0.0
        for (name, _), checks in chain(self.checks.items(), self.comparisons.items()):
            if name != OWN:
                jobs = {job_key(job): job for check in checks for job in check.jobs}.values()
                traits = self.benches[name].engine.traits
                total += sum(job_seconds(job, traits) for job in jobs)
        return total

    def run(self) -> None:
        """Run qualifications, then cases of engines and of this package, then comparisons."""
        tested = {name for (name, _), checks in self.checks.items() if checks}
        compared = any(self.comparisons.values())
        engines = [engine for engine in self.engines if compared or engine.name in tested]
        for (name, _), checks in self.checks.items():
            for job in (job for check in checks for job in check.jobs):
                if job.template is SCENE and job.scene is not None:
                    self.ahead.submit(self.benches[name].reference, job.scene)
        with _compiled_chains(if_new=OWN in tested) as wait:
            failures = parallel_map(self._qualify, engines, SIDE_BY_SIDE)
            for engine, wrong in zip(engines, failures, strict=True):
                if wrong:
                    more = f" and {len(wrong) - 1} more" if wrong[1:] else ""
                    del self.benches[engine.name]
                    self.unqualified.append(engine.name)
                    self._skip(engine.name, f"not qualified: {wrong[0]}{more}")
            if any(failures):
                self._plan_comparisons()
            done = {(engine.name, case) for engine in engines for case in QUALIFYING}
            rest = (k for k in self.checks if k not in done and k[0] in self.benches)
            self._run("", {key: self.checks[key] for key in rest}, wait)
        self._run("comparisons", self.comparisons)

    def all_rows(self) -> list[Row]:
        """Return the rows by case and engine; a second row of one key is a harness error."""
        cases = ["", *(case.name for case in self.cases), *self.broken, *QUALIFYING]
        engines = [*self.benches, *self.versions]  # those that are missing last
        counts: Counter[tuple[str, ...]] = Counter()
        rows = []
        for key in sorted(self.rows, key=lambda k: (cases.index(k[1]), engines.index(k[0]))):
            for row in self.rows[key]:
                counts[row.key] += 1
                if (number := counts[row.key]) > 1:
                    row = replace(row, check=f"{row.check} ({number})".strip())
                    row = failed(row, Failure.HARNESS, f"{number} rows of one key")
                rows.append(row)
        return rows

    def sections(self) -> list[Section]:
        """Return the sections of the report; none for a pattern, which runs a part of a case."""
        sections: list[Section] = []
        for case in self.cases if self.only == "*" else ():
            try:
                sections += returned(case, "sections", self.benches)
            except HarnessError as error:
                text = f"The sections of this case could not be made: {error}."
                sections.append(Section(case.name, text))
        return sections

    def scripts(self) -> dict[str, str]:
        """Return the plain script of each setup's first job, by engine, case and setup."""
        texts: dict[str, str] = {}
        for (name, case), checks in chain(self.checks.items(), self.comparisons.items()):
            for check in checks if name in self.benches else ():
                place = "/".join((name, case, check.setup.replace("/", "-")))
                if check.jobs and place not in texts:
                    with suppress(HarnessError, KeyError):  # of a job that was refused
                        texts[place] = self.benches[name].engine.script_text(check.jobs[0])
        return {place: text for place, text in texts.items() if text}

    def logs(self) -> dict[str, str]:
        """Return the log of one finished run of each script, by engine and script."""
        texts: dict[str, str] = {}
        for engine in self.engines:
            with suppress(EngineError):  # of an engine of another package
                texts |= {f"{engine.name}/{name}.log": text for name, text in engine.logs().items()}
        return texts

    def _plan(self, engine: str, case: Case[Any], call: str, *arguments: Any) -> None:
        blank = self._blank(engine, case.name)
        try:
            checks = returned(case, call, *arguments)
        except HarnessError as error:
            self._add(error_row(blank, error))
        else:
            self.checks[engine, case.name] = selected(case.name, checks, self.level, self.only)

    def _plan_comparisons(self) -> None:
        self.comparisons.clear()
        for case in self.cases:
            try:
                for engine, check in returned(case, "comparisons", self.engines):
                    checks = self.comparisons.setdefault((engine.name, case.name), [])
                    checks += selected(case.name, [check], self.level, self.only)
            except Exception as error:  # a case of another package may return anything
                self._add(error_row(self._blank(OWN, case.name), error))

    def _qualify(self, engine: Engine) -> list[str]:
        """Run the cases that an engine must pass; keep rows that were requested or failed."""
        wrong: list[str] = []
        for case in map(get_case, QUALIFYING):
            key = engine.name, case.name
            requested = {_route(check): check for check in self.checks.get(key, ())}
            try:
                needed = {_route(check): check for check in qualifying(case, engine)}
                self.checks[key] = [*(requested or needed).values()]
                rows = self._rows(*key, [*(requested | needed).values()])
            except HarnessError as error:
                rows = [error_row(self._blank(*key), error)]
            failures = [row for row in rows if row.verdict is Verdict.FAIL]
            kept = [row for row in rows if row in failures or _route(row) in requested]
            self.rows[key] = kept if self.checks.get(key) else rows
            wrong += [row.name for row in failures]
        return wrong

    def _run(
        self, stage: str, plan: Mapping[Key, list[Check]], wait: Callable[[], Any] = lambda: None
    ) -> None:
        """Run the checks of a plan, scenes in batches, as soon as what they need is there.

        The checks ``wait`` for solvers, in which engines may run already.
        """
        items = [(*key, checks) for key, checks in plan.items() if checks]
        items.sort(key=lambda item: (item[0] != OWN, -len(item[2])))  # no long one is the last
        totals, done = Counter(engine for engine, *_ in items), Counter[str]()
        jobs: dict[str, list[Job]] = {engine: [] for engine in totals}
        for engine, _, checks in items:
            jobs[engine] += [job for check in checks for job in check.jobs]
        scenes = [self.benches[engine].claim_scenes(jobs[engine]) for engine in totals]

        def work(item: tuple[str, str, list[Check]] | None) -> list[Row]:
            if item is not None:
                wait()
                return self._rows(*item)
            for run in scenes:  # the checks of a case wait for its own scenes alone
                with suppress(HarnessError):  # of all runs, which each row reports
                    run()
            return []

        for place, rows in parallel_each(work, [None, *items], SIDE_BY_SIDE + 1):
            if place == 0:
                continue
            engine, case, _ = items[place - 1]
            self.rows.setdefault((engine, case), []).extend(rows)
            done[engine] += 1
            self.progress(f"{engine} {stage}".strip(), done[engine], totals[engine])

    def _rows(self, engine: str, case: str, checks: Sequence[Check]) -> list[Row]:
        version, blank = self.versions[engine], self._blank(engine, case)
        defects = None if engine == OWN else self.defects
        try:
            return run_checks(case, checks, self.benches[engine], version=version, defects=defects)
        except Exception as error:  # a case of another package may raise anything
            return [error_row(blank, error)]

    def _blank(self, engine: str, case: str) -> Row:
        version = self.versions.get(engine, "")
        return Row(case=case, setup="", quantity="", engine=engine, version=version)

    def _add(self, row: Row) -> None:
        """Add the row of a case as a whole, unless a pattern names other cases."""
        if fnmatchcase(row.case, self.only.partition("/")[0]):
            self.rows.setdefault((row.engine, row.case), []).append(row)

    def _skip(self, engine: str, reason: str) -> None:
        for case in self.cases:
            if (engine, case.name) not in self.rows:
                self._add(not_tested(self._blank(engine, case.name), reason))
        if not any(name == engine for name, _ in self.rows):  # under a pattern of other names
            self.rows[engine, ""] = [not_tested(self._blank(engine, ABOUT_ENGINES), reason)]


def _route(item: Check | Row) -> tuple[str, str, str]:
    return item.setup, item.quantity, item.check


def returned(case: Case[Any], call: str, *arguments: Any) -> list[Any]:
    """Return the list that a method of a case makes; raise CaseError for anything else."""
    kind, must = RETURNED[call]
    method: Callable[..., Any] = case.checks_up_to if call == "checks" else getattr(case, call)
    try:
        items = list(method(*arguments))
    except (Unsupported, EngineError, CaseError):
        raise
    except Exception as error:  # a case of another package may raise anything
        text = " ".join(f"{type(error).__name__}: {error}".split())
        raise case_error(case, call, f"raised {text}", must) from None
    for item in items:
        if not isinstance(item, kind):
            name = type(item).__name__
            raise case_error(case, call, f"returned a {name} among its items", must)
    return items


def qualifying(case: Case[Any], engine: Engine) -> list[Check]:
    """Return the quick checks of a case that an engine must pass before any other."""
    return selected(case.name, returned(case, "checks", engine, "quick"), "quick")


def qualification(engine: Engine) -> str:
    """Return the failed checks of an engine's qualification, empty where it qualifies."""
    bench, wrong = Bench(engine), []
    for name in QUALIFYING:
        try:
            rows = run_checks(name, qualifying(get_case(name), engine), bench)
        except HarnessError as error:
            return str(error)
        wrong += [f"{row.name}: {row.note}" for row in rows if row.verdict is Verdict.FAIL]
    return "; ".join(wrong)
