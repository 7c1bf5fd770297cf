"""A verification on its way: what is run in which bench, and the rows that it leaves."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, ExitStack
from dataclasses import dataclass, field, replace
from difflib import get_close_matches
from fnmatch import fnmatchcase
from typing import Any

from harness import __version__
from harness.cases.base import Case, Check
from harness.cases.bench import OWN, Bench, job_key
from harness.cases.calls import CaseError, case_error
from harness.cases.checks import failure_of, run_checks, selected
from harness.cases.defects import explained
from harness.cases.registry import QUALIFYING, get_case
from harness.engines.base import Engine, Job
from harness.engines.cost import job_seconds
from harness.engines.jobs import parallel_each
from harness.errors import (
    EngineError,
    EngineMissingError,
    HarnessError,
    RequestError,
    Unsupported,
)
from harness.report.content import Section
from harness.results.defects import KnownDefect
from harness.results.rows import (
    Failure,
    Level,
    Row,
    Verdict,
    failed,
    finding,
    matches,
    not_tested,
)
from harness.workflows.progress import Progress

Key = tuple[str, str]  # engine and case
Plan = dict[Key, list[Check]]
OpenEngine = Callable[[str], AbstractContextManager[Engine]]
SIDE_BY_SIDE = 4  # cases at a time: solvers compute while others wait for an engine
QUALIFICATION, CHECKS, COMPARISONS = "qualification", "", "comparisons"  # stages, in order
NO_CHECKS = "the case has no checks of this engine"
MADE_BY = {
    "checks": (Check, "a list of harness.cases.base.Check"),
    "own_checks": (Check, "a list of harness.cases.base.Check"),
    "comparisons": (tuple, "a list of pairs (Engine, Check)"),
    "sections": (Section, "a list of harness.report.content.Section"),
}
"""Methods of a case, and what they return."""


@dataclass
class Session:
    """A verification on its way: checks to run by stage, engine and case, and rows so far."""

    level: Level
    only: str
    cases: Sequence[Case[Any]]
    defects: Sequence[KnownDefect]
    progress: Progress
    versions: dict[str, str] = field(default_factory=dict)
    benches: dict[str, Bench] = field(default_factory=dict)
    plans: dict[str, Plan] = field(
        default_factory=lambda: {QUALIFICATION: {}, CHECKS: {}, COMPARISONS: {}}
    )
    rows: dict[Key, list[Row]] = field(default_factory=dict)
    paths: set[str] = field(default_factory=set)

    @property
    def engines(self) -> list[Engine]:
        """Return the engines that are here and qualify."""
        return [bench.engine for name, bench in self.benches.items() if name != OWN]

    def open(self, names: Sequence[str], open_engine: OpenEngine, stack: ExitStack) -> None:
        """Open engines until ``stack`` is left; of one that is missing no case is tested."""
        self.versions[OWN], self.benches[OWN] = __version__, Bench(None, others=self.benches)
        for name in names:
            try:
                engine = stack.enter_context(open_engine(name))
                version = engine.identify().engine_version
            except EngineMissingError as error:
                self.versions[name] = ""
                self._add_to_all(name, str(error))
            except EngineError as error:
                self.versions[name] = ""
                self.rows[name, ""] = [_engine_failed(_blank("engine", name), error)]
            else:
                if engine.name in self.benches:
                    raise RequestError(f"--engines: two engines have the name {engine.name!r}")
                self.versions[engine.name] = version
                self.rows[engine.name, ""] = _version_rows(engine, version)
                self.benches[engine.name] = Bench(engine, others=self.benches)

    def plan(self) -> None:
        """List the checks; raise RequestError where the pattern selects none of them."""
        for case in self.cases:
            self._plan(OWN, case, "own_checks")
            for engine in self.engines:
                self._plan(engine.name, case, "checks_up_to", engine, self.level)
        self._plan_comparisons()
        found = any(self.plans[CHECKS].values()) or any(self.plans[COMPARISONS].values())
        if self.engines and self.only != "*" and not found:
            raise nothing_matches(self.only, self.paths)
        tested = {name for (name, _), checks in self.plans[CHECKS].items() if checks}
        for engine in self.engines:
            for case in map(get_case, QUALIFYING) if engine.name in tested else ():
                requested = self.plans[CHECKS].pop((engine.name, case.name), [])
                checks = requested or qualification_checks(case, engine)
                self.plans[QUALIFICATION][engine.name, case.name] = checks

    def seconds(self) -> float:
        """Return the expected time of all jobs on one core [s]."""
        total = 0.0
        for engine, _, checks in self._planned():
            if engine != OWN:
                jobs = {job_key(job): job for check in checks for job in check.jobs}.values()
                traits = self.benches[engine].engine.traits
                total += sum(job_seconds(job, traits) for job in jobs)
        return total

    def run(self) -> None:
        """Run qualifications, then cases side by side, then comparisons."""
        self._run(QUALIFICATION)
        for engine in {name for name, _ in self.plans[QUALIFICATION]}:
            self._judge_qualification(engine)
        self._run(CHECKS)
        self._run(COMPARISONS)

    def sections(self) -> list[Section]:
        """Return the sections of the report; none for a pattern, which runs a part of a case."""
        sections: list[Section] = []
        for case in self.cases if self.only == "*" else ():
            try:
                sections += made_by(case, "sections", self.benches)
            except (CaseError, EngineError, Unsupported) as error:
                text = f"The sections of this case could not be made: {error}."
                sections.append(Section(case.name, text))
        return sections

    def scripts(self) -> dict[str, str]:
        """Return the plain script of each setup's first job, by engine, case and setup."""
        texts: dict[str, str] = {}
        for name, case, checks in self._planned():
            for check in checks:
                place = "/".join((name, case, check.setup.replace("/", "-")))
                if check.jobs and place not in texts and name in self.benches:
                    texts[place] = _script(self.benches[name].engine, check.jobs[0])
        return {place: text for place, text in texts.items() if text}

    def logs(self) -> dict[str, str]:
        """Return the log of one finished run of each script, by engine and script."""
        logs = [(e.name, script, text) for e in self.engines for script, text in e.logs().items()]
        return {f"{name}/{script}.log": text for name, script, text in logs}

    def ordered_rows(self) -> list[Row]:
        """Return the rows by case and engine; a second row of one key is a harness error."""
        order = ["", *(case.name for case in self.cases), *QUALIFYING]
        seen: Counter[tuple[str, ...]] = Counter()
        rows = []
        for key in sorted(self.rows, key=lambda key: order.index(key[1])):
            for row in self.rows[key]:
                seen[row.key] += 1
                rows.append(row if seen[row.key] == 1 else _second(row, seen[row.key]))
        return rows

    def _planned(self) -> Iterator[tuple[str, str, list[Check]]]:
        for plan in self.plans.values():
            for (engine, case), checks in plan.items():
                yield engine, case, checks

    def _plan(self, engine: str, case: Case[Any], call: str, *arguments: Any) -> None:
        blank = _blank(case.name, engine, self.versions[engine])
        try:
            checks = made_by(case, call, *arguments)
        except Unsupported as reason:
            self._add(not_tested(blank, str(reason)))
        except (CaseError, EngineError) as error:
            self._add(failed(blank, Failure.HARNESS, str(error)))
        else:
            self.plans[CHECKS][engine, case.name] = self._selected(case, checks)
            if not checks and engine != OWN and self.only == "*":
                self._add(not_tested(blank, NO_CHECKS))

    def _plan_comparisons(self) -> None:
        for case in self.cases:
            checks: dict[str, list[Check]] = {}
            try:
                for engine, check in made_by(case, "comparisons", self.engines):
                    checks.setdefault(engine.name, []).append(check)
            except (CaseError, EngineError) as error:
                blank = _blank(case.name, OWN, self.versions[OWN])
                self._add(failed(blank, Failure.HARNESS, str(error)))
            for name, found in checks.items():
                self.plans[COMPARISONS][name, case.name] = self._selected(case, found)

    def _judge_qualification(self, engine: str) -> None:
        """Keep rows that were requested or failed; after a failure test nothing else."""
        requested, wrong = {case.name for case in self.cases}, []
        for key in [key for key in self.plans[QUALIFICATION] if key[0] == engine]:
            rows = self.rows.get(key, [])
            failures = [row for row in rows if row.verdict is Verdict.FAIL]
            shown = [r for r in rows if key[1] in requested and matches(_path(r), self.only)]
            self.rows[key] = list(dict.fromkeys([*shown, *failures]))
            wrong += [row.name for row in failures]
        if wrong:
            more = f" and {len(wrong) - 1} more" if wrong[1:] else ""
            del self.benches[engine]
            self._add_to_all(engine, f"not qualified: {wrong[0]}{more}")
            self.plans[COMPARISONS].clear()
            self._plan_comparisons()

    def _run(self, stage: str) -> None:
        """Run the checks of a stage; of cases that have rows already, comparisons alone."""
        known = set(self.rows) if stage == CHECKS else set()
        plan = self.plans[stage].items()
        items = [(*key, checks) for key, checks in plan if checks and key not in known]
        totals, done = Counter(engine for engine, *_ in items), Counter[str]()
        for place, rows in parallel_each(lambda item: self._rows(*item), items, SIDE_BY_SIDE):
            engine, case, _ = items[place]
            self.rows.setdefault((engine, case), []).extend(rows)
            done[engine] += 1
            self.progress(f"{engine} {stage}".strip(), done[engine], totals[engine])

    def _rows(self, engine: str, case: str, checks: Sequence[Check]) -> list[Row]:
        version = self.versions[engine]
        blank = _blank(case, engine, version)
        explain = None if engine == OWN else explained(self.defects, version)
        try:
            return run_checks(case, checks, self.benches[engine], version=version, explain=explain)
        except EngineMissingError as error:
            return [not_tested(blank, str(error))]
        except EngineError as error:
            return [_engine_failed(blank, error)]
        except Exception as error:  # a case of another package may raise anything
            return [failed(blank, Failure.HARNESS, f"{type(error).__name__}: {error}")]

    def _selected(self, case: Case[Any], checks: Sequence[Check]) -> list[Check]:
        self.paths |= {f"{case.name}/{check.setup}/{check.quantity}" for check in checks}
        return selected(case.name, checks, self.level, self.only)

    def _add(self, row: Row) -> None:
        """Add the row of a case as a whole, unless a pattern names other cases."""
        if fnmatchcase(row.case, self.only.partition("/")[0]):
            self.rows.setdefault((row.engine, row.case), []).append(row)

    def _add_to_all(self, engine: str, reason: str) -> None:
        for case in self.cases:
            if (engine, case.name) not in self.rows:
                self._add(not_tested(_blank(case.name, engine, self.versions[engine]), reason))


def made_by(case: Case[Any], call: str, *arguments: Any) -> list[Any]:
    """Return the list that a method of a case makes; raise CaseError for anything else."""
    name = call.removesuffix("_up_to")
    kind, must = MADE_BY[name]
    try:
        made = getattr(case, call)(*arguments)
        are_many = isinstance(made, Iterable) and not isinstance(made, str | Mapping)
        items = list(made) if are_many else [made]
    except (Unsupported, EngineError, CaseError):
        raise
    except Exception as error:  # a case of another package may raise anything
        found = f"raised {' '.join(f'{type(error).__name__}: {error}'.split())}"
    else:
        wrong = [item for item in items if not _is(item, kind)]
        if are_many and not wrong:
            return items
        found = f"returned {_described(wrong[0] if are_many else made)}"
        found += " among its items" if are_many else ""
    raise case_error(case, name, found, must)


def qualification_checks(case: Case[Any], engine: Engine) -> list[Check]:
    """Return the quick checks of a case that an engine must pass before any other."""
    return selected(case.name, made_by(case, "checks_up_to", engine, "quick"), "quick")


def qualification(engine: Engine) -> str:
    """Return the failed checks of an engine's qualification, empty where it qualifies."""
    bench, wrong = Bench(engine), []
    for name in QUALIFYING:
        rows = run_checks(name, qualification_checks(get_case(name), engine), bench)
        wrong += [f"{row.name}: {row.note}" for row in rows if row.verdict is Verdict.FAIL]
    return "; ".join(wrong)


def nothing_matches(only: str, paths: Iterable[str]) -> RequestError:
    """Return the error of a pattern that matches no ``case/setup/quantity``, with near ones."""
    plain = only.strip("*?").casefold()
    parts = {part.casefold(): part for path in paths for part in (path, *path.split("/"))}
    found = [name for name in parts if plain and plain in name]
    found = found or get_close_matches(plain, parts, n=5, cutoff=0.4)
    near = ", ".join(repr(parts[name]) for name in sorted(found, key=len)[:5])
    text = f"--only {only!r}: matches no case/setup/quantity of this level"
    return RequestError(text + (f"; near it: {near}" if near else ""))


def _is(item: Any, kind: type[Any]) -> bool:
    if kind is not tuple:
        return isinstance(item, kind)
    match item:
        case (Engine(), Check()):
            return True
    return False


def _described(value: object) -> str:
    return "None" if value is None else f"a {type(value).__name__}"


def _blank(case: str, engine: str, version: str = "") -> Row:
    return Row(case=case, setup="", quantity="", engine=engine, version=version)


def _path(row: Row) -> str:
    return f"{row.case}/{row.setup}/{row.quantity}"


def _second(row: Row, number: int) -> Row:
    row = replace(row, check=f"{row.check} ({number})".strip())
    return failed(row, Failure.HARNESS, f"{number} checks of one key")


def _engine_failed(blank: Row, error: EngineError) -> Row:
    return failed(blank, failure_of(error), f"{error.kind}: {error}", error.log)


def _version_rows(engine: Engine, version: str) -> list[Row]:
    """Return a finding where an engine's version is not one that it was tried with."""
    if version in engine.traits.versions:
        return []
    tried = ", ".join(engine.traits.versions) or "none"
    note = f"version {version}: not one that it was tried with ({tried})"
    return [finding(replace(_blank("engine", engine.name, version), setup="version", note=note))]


def _script(engine: Engine, job: Job) -> str:
    try:
        return engine.script_text(job)
    except (HarnessError, KeyError):  # of a job that was refused
        return ""
