"""A session: the part of a verification that one process does.

It opens the engines, lists the checks of its cases, runs them, and has their rows.
"""

from __future__ import annotations

import sys
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence, Set
from concurrent.futures import Executor, ThreadPoolExecutor
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass, field, replace
from fnmatch import fnmatchcase
from itertools import chain, product
from pathlib import Path
from subprocess import DEVNULL, Popen
from typing import Any, NamedTuple

from harness import __version__
from harness.cases.base import Case, Check, returned
from harness.cases.bench import OWN, Bench, Outcomes, job_key
from harness.cases.checks import FULL_DIGITS, error_row, run_checks, selected
from harness.cases.registry import QUALIFYING, get_case
from harness.engines.base import SCENE, Engine, Job, job_seconds
from harness.engines.process import one_thread, parallel_each, parallel_map
from harness.errors import EngineError, EngineMissingError, HarnessError, RequestError
from harness.report.content import Section
from harness.results.defects import KnownDefect
from harness.results.rows import Failure, Level, Row, Verdict, failed, finding, not_tested
from harness.store.cache import CachedEngine
from harness.store.runs import ABOUT_ENGINES
from harness.workflows import Progress
from harness.workflows.runs import OpenEngine

Key = tuple[str, str]  # engine and case
COMPILE = (
    "from harness.solvers.reference import compile_friction; compile_friction()",
    "from harness.cases.tower.runs import compile_chains; compile_chains()",
)  # what another process compiles meanwhile: the first is needed sooner
SIDE_BY_SIDE = 4  # cases at a time: solvers compute while others wait for an engine
NO_CHECKS = "the case has no checks of this engine"


class Outline(NamedTuple):
    """What a process is going to do: the engines with checks, and the expected time [s]."""

    tested: Set[str]
    seconds: float


class Part(NamedTuple):
    """What a copy has found in its cases.

    Rows; by engine the outcomes of jobs, the notes of cases, and the numbers of runs that were made
    and that were read; scripts and logs by name.
    """

    rows: dict[Key, list[Row]]
    benches: dict[str, tuple[Outcomes, dict[str, Any]]]
    runs: dict[str, tuple[int, int]]
    scripts: dict[str, str]
    logs: dict[str, str]


@dataclass
class Session:
    """A verification on its way: benches by engine, checks by engine and case, rows so far.

    ``broken`` are the cases that cannot be used, broken or hidden, with the reason. ``ahead`` makes
    what is needed later: runs of qualifications while checks are listed, references while engines
    run. ``taken`` are the cases that this process verifies, ``parts`` the findings of its copies.
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
    has_report: bool = False
    taken: list[Case[Any]] = field(default_factory=list)
    parts: list[Part] = field(default_factory=list)

    @property
    def engines(self) -> list[Engine]:
        """Return the engines that are installed and qualify."""
        return [bench.engine for name, bench in self.benches.items() if name != OWN]

    def add(self, engines: Mapping[str, Engine | EngineError]) -> None:
        """Take engines by the names that were given; of one that is missing no case is tested."""
        self.versions[OWN], self.benches[OWN] = __version__, Bench(None, others=self.benches)
        for name, engine in engines.items():
            if isinstance(engine, EngineError):
                self.versions[name] = ""
                if isinstance(engine, EngineMissingError):
                    self._skip(name, str(engine))
                else:
                    self.rows[name, ""] = [error_row(self._blank(name, ABOUT_ENGINES), engine)]
                continue
            if engine.name in self.benches:
                raise RequestError(f"--engines: two engines have the name {engine.name!r}")
            self.versions[engine.name] = engine.identify().engine_version or "unknown"
            self.benches[engine.name] = Bench(engine, others=self.benches)
            self.rows[engine.name, ""] = self._findings(engine)

    def copied(self, progress: Progress) -> Session:
        """Return the session of a process that is a copy of this one."""
        for engine in self.engines:
            engine.forget_processes()
        self.progress, self.ahead = progress, ThreadPoolExecutor(SIDE_BY_SIDE)
        return self

    def close(self) -> None:
        """Close the engines, in a copy of the process that has opened them."""
        self.ahead.shutdown(cancel_futures=True)
        for engine in self.engines:
            engine.close()

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

    def prepare_qualification(self) -> None:
        """Let engines run their qualification, while checks are listed."""
        for engine in self.engines:
            self.ahead.submit(self._prepare_qualification, self.benches[engine.name])

    def plan(self, queue: Iterable[Case[Any]]) -> None:
        """List the checks of the cases of a queue, and begin to run the reference."""
        for name, reason in self.broken.items():
            self._add(not_tested(self._blank(OWN, name), reason))
        for case in queue:
            self.taken.append(case)
            self._plan(OWN, case, "own_checks")
            for engine in self.engines:
                self._plan(engine.name, case, "checks", engine, self.level)
        self._plan_comparisons()
        for engine, case in product(self.engines, self.taken) if self.only == "*" else ():
            key = engine.name, case.name
            if not (self.checks.get(key) or self.comparisons.get(key) or key in self.rows):
                self._add(not_tested(self._blank(*key), f"{NO_CHECKS} at level {self.level}"))
        for (name, _), checks in self.checks.items():
            for job in (job for check in checks for job in check.jobs):
                if job.template is SCENE and job.scene is not None:
                    self.ahead.submit(self.benches[name].reference, job.scene)

    def outline(self) -> Outline:
        """Return which engines have checks in the plan, and their expected time."""
        compared = [bench for bench in self.benches if any(self.comparisons.values())]
        tested = {name for (name, _), checks in self.checks.items() if checks}
        return Outline(tested.union(compared), self.seconds())

    def check_pattern(self, tested: Set[str]) -> None:
        """Raise RequestError where the pattern selects no check of any process, nor a case."""
        planned = tested or any((OWN, name) in self.rows for name in self.broken)
        if self.engines and self.only != "*" and not planned:
            raise RequestError(
                f"--only {self.only!r}: matches no case/setup/quantity of this level"
            )

    def _prepare_qualification(self, bench: Bench) -> None:
        checks = (qualifying(get_case(name), bench.engine) for name in QUALIFYING)
        self._prepare(bench, chain(*checks))

    def seconds(self) -> float:
        """Return the expected time of all jobs on one core [s]."""
        total = 0.0
        for (name, _), checks in chain(self.checks.items(), self.comparisons.items()):
            if name != OWN:
                jobs = {job_key(job): job for check in checks for job in check.jobs}.values()
                traits = self.benches[name].engine.traits
                total += sum(job_seconds(job, traits) for job in jobs)
        return total

    def qualify(self, tested: Set[str]) -> None:
        """Run the qualification of engines that have checks; leave out who does not qualify."""
        engines = [engine for engine in self.engines if engine.name in tested]
        failures = parallel_map(self._qualify, engines, SIDE_BY_SIDE)
        wrong = {e.name: w for e, w in zip(engines, failures, strict=True) if w}
        self.leave_out([*wrong])
        for name, names in wrong.items():
            more = f" and {len(names) - 1} more" if names[1:] else ""
            self._skip(name, f"not qualified: {names[0]}{more}")

    def run_ahead(self, wait: Callable[[], Any]) -> None:
        """Let engines ``wait``, and then run their jobs while they qualify."""
        for (name, _), checks in self.checks.items():
            if name != OWN:
                self.ahead.submit(self._prepare, self.benches[name], checks, wait)

    @staticmethod
    def _prepare(
        bench: Bench, checks: Iterable[Check], wait: Callable[[], Any] = lambda: None
    ) -> None:
        wait()
        jobs = (job for check in checks for job in check.jobs)
        bench.prepare([job for job in jobs if not bench.refusal(job)])

    def leave_out(self, unqualified: Sequence[str]) -> None:
        """Leave out engines that do not qualify, and end what they run."""
        self.unqualified += unqualified
        for name in unqualified:
            self.benches.pop(name).engine.close()
        if unqualified:
            self._plan_comparisons()

    def run(self, wait: Callable[[], Any] = lambda: None) -> None:
        """Run the cases of engines and of this package, then comparisons.

        Checks ``wait`` for solvers, while engines run.
        """
        done = {(engine.name, case) for engine in self.engines for case in QUALIFYING}
        rest = (k for k in self.checks if k not in done and k[0] in self.benches)
        self._run("", {key: self.checks[key] for key in rest}, wait)
        self._run("comparisons", self.comparisons)
        for bench, case in product(self.benches.values(), self.taken if self.has_report else ()):
            try:
                bench.notes[case.name] = case.notes(bench)
            except Exception as error:  # a case of another package may raise anything
                row = error_row(self._blank(bench.name, case.name), error)
                self.rows.setdefault((bench.name, case.name), []).append(row)

    def part(self) -> Part:
        """Return what this process has found in its cases, for the one that it is a copy of."""
        names = [case.name for case in self.taken]
        rows = {(e, case): rows for (e, case), rows in self.rows.items() if case in names}
        benches = {
            name: (bench.all_outcomes(), bench.notes) for name, bench in self.benches.items()
        }
        kept = [engine for engine in self.engines if isinstance(engine, CachedEngine)]
        runs = {engine.name: (engine.ran, engine.read) for engine in kept}
        return Part(rows, benches, runs, self.scripts(), self.logs())

    def take_over(self, part: Part) -> None:
        """Take the findings of a copy as those of this process."""
        self.parts.append(part)
        self.rows |= part.rows
        for name, (outcomes, notes) in part.benches.items():
            self.benches[name].take_over(outcomes)
            self.benches[name].notes |= notes
        for name, (ran, read) in part.runs.items():
            engine: Any = self.benches[name].engine
            engine.ran, engine.read = engine.ran + ran, engine.read + read
        for (name, case), rows in part.rows.items():
            if name in self.benches:
                self.benches[name].rows[case] += rows

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
        texts = {place: text for part in self.parts for place, text in part.scripts.items()}
        for (name, case), checks in chain(self.checks.items(), self.comparisons.items()):
            for check in checks if name in self.benches else ():
                place = "/".join((name, case, check.setup.replace("/", "-")))
                if check.jobs and place not in texts:
                    with suppress(HarnessError, KeyError):  # of a job that was refused
                        texts[place] = self.benches[name].engine.script_text(check.jobs[0])
        return {place: text for place, text in texts.items() if text}

    def logs(self) -> dict[str, str]:
        """Return the log of one finished run of each script, by engine and script."""
        texts = {place: text for part in self.parts for place, text in part.logs.items()}
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
        for case in self.taken:
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
        for engine, count in totals.items():
            self.progress(f"{engine} {stage}".strip(), 0, count)
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


def opened_engines(
    names: Sequence[str], open_engine: OpenEngine, stack: ExitStack
) -> dict[str, Engine | EngineError]:
    """Return engines, opened in a stack side by side and identified, or why one is not here."""

    def result(name: str) -> Engine | EngineError:
        try:
            engine = stack.enter_context(open_engine(name))
            engine.identify()
        except EngineError as error:
            return error
        return engine

    return dict(zip(names, parallel_map(result, names, SIDE_BY_SIDE), strict=True))


# ---- kernels


def kernels_are_new() -> bool:
    """Return whether kernels were never compiled, which each process would do."""
    from harness import compiled, solvers  # slow to import: numba

    return compiled.waits_for_compilation(Path(solvers.__path__[0]))


@contextmanager
def compiled_beside(*, if_new: bool) -> Iterator[Callable[[], Any]]:
    """Compile friction and chains where they are new, in another process; yield a wait for it.

    Numba compiles one kernel at a time in a process, and the rest of the reference takes as long.
    """
    if not if_new or not kernels_are_new():
        yield lambda: None
        return
    command = [sys.executable, "-P", "-c", "; ".join(COMPILE)]
    with Popen(command, stdout=DEVNULL, stderr=DEVNULL, env=one_thread()) as process:
        try:
            yield process.wait
        finally:
            process.kill()
