"""Run a verification: from level, cases and engines to verdicts, records and sections.

All that was given is checked before anything runs. The main engine goes through the cases, then the
harness's own solvers; other engines are identified, qualify, and go through the same cases under
their own rules. Records are held against the baseline; sections of the report are made case by
case.
"""

from __future__ import annotations

import platform
import time
from collections.abc import Callable, Iterable, Sequence
from contextlib import AbstractContextManager, ExitStack, suppress
from dataclasses import dataclass, field, replace
from datetime import UTC, datetime
from difflib import get_close_matches
from fnmatch import fnmatchcase
from functools import partial
from itertools import chain
from pathlib import Path
from typing import Any, Literal

from harness import __version__
from harness.cases.contract import LEVELS, Case, LevelName
from harness.cases.qualification import announce, qualify
from harness.cases.registry import all_cases, cases_named, get_case, names_in
from harness.cases.verification import Study, failed_part
from harness.comparison.known_defects import KnownDefect, defect_of
from harness.comparison.regression import (
    Baseline,
    BaselineRecord,
    Expected,
    Regression,
    against_baseline,
    explained_by_cells,
)
from harness.comparison.series import Comparison
from harness.comparison.verdicts import Check, Kind, judge_plan
from harness.comparison.verification import DeclaredEngine, Findings, Verification
from harness.engines.contract import Engine
from harness.engines.process import parallel_map
from harness.engines.registry import (
    DEFAULT,
    engine_class,
    engine_names,
)
from harness.engines.traits import Traits
from harness.errors import EngineError, EngineMissingError, RequestError
from harness.observables.provenance import Provenance
from harness.report.sections import Section
from harness.store.baseline import committed, read_baseline, script_of, with_further
from harness.store.cache import EngineChoice, opened
from harness.store.entries import tell_stderr
from harness.workflows.engine_status import (
    NO_TRAITS,
    EngineSelection,
    declared,
    selected_engines,
    untested,
    version_rows,
)
from harness.workflows.progress import Progress, silent


def checked_level(name: str) -> LevelName:
    """Return a level by its name; raise RequestError for a name that is not one."""
    for level in LEVELS:
        if level == name:
            return level
    raise RequestError(f"level = {name!r} is not known: must be one of {', '.join(LEVELS)}")


def chosen_cases(wanted: str | Iterable[str] | None) -> list[Case[Any]]:
    """Return the cases of names, groups or ``all``; the main ones for None."""
    text = wanted if isinstance(wanted, str) else ",".join(wanted or ())
    return list(cases_named(text).values())


@dataclass(frozen=True)
class Selection:
    """What is verified: cases by names, groups or ``all``, and of them what a pattern matches.

    ``only`` is a shell-style pattern of a case, submodel, system or check. ``defects`` is a file of
    known defects, added to the committed ones.
    """

    cases: str | None = None
    only: str = ""
    defects: Path | None = None

    def chosen(self, level: LevelName) -> list[Case[Any]]:
        """Return the cases in which the pattern can match something: of all, unless some are named.

        A case that is named and cannot say which rows it leaves stays where no other matches. Raise
        RequestError, with near names, for a pattern that matches nothing.
        """
        if not self.only:
            return chosen_cases(self.cases)
        study, searched = Study(level, only=self.only), chosen_cases(self.cases or "all")
        names = {case.name: case.verification.selectable(level) for case in searched}
        matching = [case for case in searched if study.selects(*names[case.name])]
        matching = matching or [
            case for case in searched if self.cases and not case.verification.lists_rows
        ]
        if not matching:
            raise nothing_matches(self.only, set(chain.from_iterable(names.values())))
        return matching

    def names(self, level: LevelName) -> tuple[str, ...]:
        """Return the names of :meth:`chosen`, which import no case unless a pattern asks for it."""
        if self.only:
            return tuple(case.name for case in self.chosen(level))
        return names_in(self.cases or "")


def nothing_matches(only: str, names: Iterable[str]) -> RequestError:
    """Return the error of a pattern that matches none of the names, with those that are near."""
    plain = only.strip("*?").casefold()
    by_lowercase = {name.casefold(): name for name in names}
    parts = [name for name in by_lowercase if plain and plain in name] or get_close_matches(
        plain, by_lowercase, n=5, cutoff=0.4
    )
    near = ", ".join(repr(by_lowercase[name]) for name in sorted(parts, key=len)[:5])
    return RequestError(
        f"--only {only!r}: matches no case, submodel, system or check of this level"
        + (f"; near it: {near}" if near else "")
    )


def chosen_baseline(source: Path | Baseline | None) -> Baseline:
    """Return the baseline of a folder, or the committed one; empty where there is none."""
    if isinstance(source, Baseline):
        return source
    where = source or committed()
    if where is None:
        return Baseline({}, "none")
    return read_baseline(where)


def here() -> str:
    """Return the platform that a record is measured on."""
    return f"{platform.system()} {platform.machine()}"


@dataclass(frozen=True)
class MeasuredRecords:
    """What a verification measured at a level in its main engine and the own solvers.

    ``engine`` is the name that the main engine's records have. ``broken`` says why a part ended
    early, by the name of its case.
    """

    level: str
    engine: str
    cases: Sequence[Case[Any]]
    findings: Sequence[Findings]
    broken: dict[str, str] = field(default_factory=dict)

    @property
    def records(self) -> list[BaselineRecord]:
        """Return every record, each once."""
        once = {record.name: record for finding in self.findings for record in finding.records}
        return [record.at(self.level, here()) for record in once.values()]

    @property
    def errors(self) -> dict[str, EngineError]:
        """Return the errors of records whose run died, by name."""
        return {name: error for finding in self.findings for name, error in finding.errors.items()}

    def reason(self, record: BaselineRecord) -> str:
        """Return why a record could not be made, or nothing where it should have been."""
        for finding in self.findings:
            for pattern, reason in finding.untested.items():
                if fnmatchcase(record.name, pattern):
                    return reason
        return self.broken.get(record.case, "")


def baseline_rows(
    measured: MeasuredRecords, baseline: Baseline, other_records: Iterable[BaselineRecord]
) -> Regression:
    """Return the rows of a verification against the baseline.

    ``other_records`` are those of other engines, which run less: of them what the baseline has.
    """
    names = {record.name for record in measured.records}
    solvers = {solver for case in measured.cases for solver in case.solvers}
    engines = {record.engine for record in measured.records}
    expected = Expected(
        engines={measured.engine, *solvers, *engines},
        cases={case.name for case in measured.cases},
        errors=measured.errors,
        reason=measured.reason,
    )
    also_recorded = [
        record.at(measured.level, here())
        for record in other_records
        if record.name in baseline.records and record.name not in names
    ]
    return against_baseline(
        [*measured.records, *also_recorded],
        baseline,
        measured.level,
        expected,
        {case.name: case.verification.regression for case in measured.cases},
    )


@dataclass
class OtherEngines:
    """Runs engines other than the main one, one after the other, and holds what they left.

    ``main`` is an engine that is open already: it takes the place of the one of its name, and is
    not closed. ``steps`` are those that a case took in the engines so far, by its name: what the
    next is expected to take. ``checks`` are all rows in order, those of the ``findings`` (by engine
    and case) among them; ``errors`` are those of engines that were named and are missing or died;
    ``kinds`` the classes of engines that ran, by the name that they give themselves.
    """

    selection: EngineSelection
    cases: Sequence[Case[Any]]
    study: Study
    main: Engine | None
    steps: dict[str, float] = field(default_factory=dict)
    declared: list[DeclaredEngine] = field(default_factory=list)
    findings: dict[str, dict[str, Findings]] = field(default_factory=dict)
    checks: list[Check] = field(default_factory=list)
    errors: list[str] = field(default_factory=list)
    kinds: dict[str, type[Engine]] = field(default_factory=dict)

    @property
    def records(self) -> list[BaselineRecord]:
        """Return the records of all engines."""
        of_cases = chain.from_iterable(by.values() for by in self.findings.values())
        return [record for findings in of_cases for record in findings.records]

    def run(self) -> OtherEngines:
        """Run the engines, and hold all together."""
        if not self.selection.engines:
            return self
        for name in self.selection.engines:
            self._run_engine(name)
        for case in self.cases:
            self._across(case)
        return self

    def _run_engine(self, name: str) -> None:
        traits = NO_TRAITS
        with ExitStack() as stack:
            try:
                traits = engine_class(name).traits
                engine, provenance = self._opened(name, stack)
                self._check_name(name, engine)
            except (EngineMissingError, RequestError) as error:
                reason = traits.missing(str(error))
                rows = untested(name, [*self._qualifying, *self._judging], reason)
                self._without(name, traits, reason, rows)
            except Exception as error:
                rows = [failed_part(f"{name}: identification", error, kind=Kind.ANALYTIC)]
                self._without(name, traits, rows[0].note, rows)
            else:
                self.kinds[engine.name] = engine_class(name)
                self._keep(name, self._engine(engine, provenance))

    def _opened(self, name: str, stack: ExitStack) -> tuple[Engine, Provenance]:
        if self.main is not None and self.main.name == name:
            return self.main, self.main.identify()
        assert self.study.open_engine is not None
        engine = stack.enter_context(self.study.open_engine(name))
        return engine, engine.identify()

    def _check_name(self, name: str, engine: Engine) -> None:
        """Raise RequestError where another engine has its name, by which all that it left is kept.

        As a subclass that inherits it: rows and runs of the one would stand for those of the other.
        """
        kind, main = self.kinds.get(engine.name), self.main
        if kind is None and main is not None and main.name in engine_names():
            kind = engine_class(main.name) if main.name == engine.name else None
        if kind not in (None, engine_class(name)):
            raise RequestError(
                f"{name} calls itself {engine.name!r}, as another engine does: give it its own name"
            )

    def _without(self, name: str, traits: Traits, reason: str, rows: list[Check]) -> None:
        self.declared.append(declared(name, traits, missing=reason))
        self.checks += rows
        if name in self.selection.named:
            self.errors.append(f"{name}: {reason}")

    def _keep(self, name: str, rows: list[Check]) -> None:
        self.checks += rows
        if name in self.selection.named:
            died = [f"{name}: {row.note}" for row in rows if row.engine_died]
            self.errors += dict.fromkeys(died)

    def _engine(self, engine: Engine, provenance: Provenance) -> list[Check]:
        name, stages = engine.name, 1 + len(self._judging)
        self.study.progress(f"engine {name}", 0, stages)
        declaration = declared(name, engine.traits, provenance)
        checks = version_rows(name, engine.traits, provenance)
        read = getattr(engine, "read", 0)
        failures, rows = self._qualification(engine)
        # of one whose runs are kept nobody knows how many are left to be made
        kept = getattr(engine, "read", 0) > read
        seconds_per_step = 0.0 if kept else engine.pace.seconds_per_step
        checks += rows or untested(name, self._qualifying, failures)
        self.declared.append(replace(declaration, unqualified=failures))
        self.study.progress(f"engine {name}", 1, stages)
        if failures:
            self.study.progress(f"engine {name}", stages, stages)
            return [*checks, *untested(name, self._judging, f"it did not qualify: {failures}")]
        for done, case in enumerate(self._judging, 2):
            steps = self.steps.get(case.name, 0.0) / engine.workers
            announce(engine, f"the {case.name}", steps * seconds_per_step, tell_stderr)
            before = engine.pace.steps
            checks += self._case(case, engine)
            taken = engine.pace.steps - before
            self.steps[case.name] = max(taken, self.steps.get(case.name, 0.0))
            self.study.progress(f"engine {name}", done, stages)
        return checks

    def _qualification(self, engine: Engine) -> tuple[str, list[Check]]:
        try:
            qualification = qualify(engine, self._qualifying, self.study, tell_stderr)
        except Exception as error:
            row = failed_part(f"{engine.name}: qualification", error, kind=Kind.ANALYTIC)
            return row.note, [row]
        self.findings.setdefault(engine.name, {}).update(qualification.findings)
        return qualification.reason, list(qualification.checks)

    def _case(self, case: Case[Any], engine: Engine) -> list[Check]:
        """Return the rows of a case in an engine; one that raises is one failed row."""
        if not engine.states(case.template):
            return untested(engine.name, [case], f"it has no template {case.template.name!r}")
        try:
            findings = case.verification.run(engine, replace(self.study, role="other"))
            findings.checks[:] = [
                row for row in findings.checks if self.study.keeps(row, case.name)
            ]
        except Exception as error:
            return [failed_part(f"{engine.name}: {case.name}", error)]
        self.findings.setdefault(engine.name, {})[case.name] = findings
        if not (findings.checks or self.study.only or engine is self.main):
            return untested(engine.name, [case], NO_ROW)  # those of the main one are there
        return findings.checks

    def _across(self, case: Case[Any]) -> None:
        by_engine = {name: by[case.name] for name, by in self.findings.items() if case.name in by}
        try:
            self.checks += case.verification.compare(by_engine)
        except Exception as error:
            self.checks.append(failed_part(f"{case.name}: engines against another", error))

    @property
    def _qualifying(self) -> list[Case[Any]]:
        return [case for case in all_cases().values() if case.qualifies]

    @property
    def _judging(self) -> list[Case[Any]]:
        return [case for case in self.cases if not case.qualifies]


NO_ROW = "it left no row"
"""Why a case is not tested of which nothing else is said."""

SIDE_BY_SIDE = 4
"""Parts that run at a time: own solvers compute while others wait for the engine's workers."""

Part = tuple[Case[Any], str, Callable[[], Findings]]
"""A case, the engine that runs it (empty for own solvers), and what runs it."""


@dataclass
class MainRun:
    """What the cases left, as they go.

    ``checks`` are all rows in order, those of the findings among them; ``broken`` says why a case
    ended early, ``raised`` are those that did by an exception, which is a failed row.
    """

    cases: Sequence[Case[Any]]
    study: Study
    engine: Engine | None = None
    provenance: Provenance | None = None
    main: dict[str, Findings] = field(default_factory=dict)
    solvers: dict[str, Findings] = field(default_factory=dict)
    checks: list[Check] = field(default_factory=list)
    broken: dict[str, str] = field(default_factory=dict)
    raised: set[str] = field(default_factory=set)

    @property
    def engine_name(self) -> str:
        """Return the name of the main engine, whose baseline it is, also where it is missing."""
        if self.provenance is not None:
            return self.provenance.engine
        return self.engine.name if self.engine is not None else DEFAULT

    @property
    def findings(self) -> list[Findings]:
        """Return what the main engine left, then own solvers."""
        return [*self.main.values(), *self.solvers.values()]

    @property
    def divergences(self) -> list[Comparison]:
        """Return the series that left the band about their reference."""
        return [series for finding in self.findings for series in finding.divergences]

    def open(self, engine: EngineChoice, fresh: bool, stack: ExitStack) -> None:
        """Identify the main engine; one that is not here is a failed row, and the rest goes on."""
        try:
            self.engine = stack.enter_context(opened(engine, fresh=fresh))
            self.provenance = self.engine.identify()
        except Exception as error:
            row = failed_part(f"engine {self.engine_name}", error)
            self.checks.append(row)
            self.broken |= {case.name: row.note for case in self.cases}

    def cases_side_by_side(self) -> None:
        """Run the cases in the main engine, then in own solvers."""
        parts: list[Part] = []
        if self.engine is not None and self.provenance is not None:
            for case in self.cases:
                if self.engine.states(case.template):
                    verify_main = partial(case.verification.run, self.engine, self.study)
                    parts.append((case, self.engine.name, verify_main))
                else:
                    why = f"it has no template {case.template.name!r}"
                    self.checks += untested(self.engine.name, [case], why)
                    self.broken[case.name] = f"{self.engine.name}: {why}"
        parts += [
            (case, "", partial(case.verification.run_solvers, self.study)) for case in self.cases
        ]
        outcomes = parallel_map(self._found_or_failed, parts, SIDE_BY_SIDE)
        for (case, engine, _), outcome in zip(parts, outcomes, strict=True):
            self._keep(case, engine, outcome)
        if self.engine is not None and not self.study.only:
            for case in self.cases:
                done = [by[case.name] for by in (self.main, self.solvers) if case.name in by]
                if case.name not in self.broken and not any(found.checks for found in done):
                    self.checks += untested(self.engine.name, [case], NO_ROW)

    def _found_or_failed(self, part: Part) -> Findings | Check:
        """Run a case and tell when it begins and ends; one that raises is one failed row."""
        case, engine, run = part
        runner = engine or "own solvers"
        self.study.progress(f"{case.name}, {runner}", 0, 1)
        try:
            return run()
        except Exception as error:
            return failed_part(f"{case.name}: {runner}", error)
        finally:
            self.study.progress(f"{case.name}, {runner}", 1, 1)

    def _keep(self, case: Case[Any], engine: str, outcome: Findings | Check) -> None:
        if isinstance(outcome, Check):
            self.checks.append(outcome)
            self.raised.add(case.name)
            self.broken[case.name] = f"its part ended early: {outcome.note}"
            return
        (self.main if engine else self.solvers)[case.name] = outcome
        outcome.checks[:] = [row for row in outcome.checks if self.study.keeps(row, case.name)]
        self.checks += outcome.checks
        died = next((check.note for check in outcome.checks if check.engine_died), "")
        if died:
            self.broken.setdefault(case.name, f"its part ended early: {died}")
        elif engine and self.engine is not None and not self.study.only:
            planned = case.verification.planned(self.study.level, self.engine)
            if planned:
                name = f"{case.name}: rows of level {self.study.level}, {engine}"
                self.checks += judge_plan(name, outcome.checks, planned)

    def scripts(self, others: OtherEngines) -> dict[str, str]:
        """Return the inputs that ran, by name."""
        templates_by_name: dict[str, str] = {}
        if self.engine is not None:
            templates = [get_case(name).template for name in self.main]
            folder = "" if self.engine.name == DEFAULT else f"{self.engine.name}/"
            texts = self.engine.inputs(templates)
            templates_by_name |= {folder + path: text for path, text in texts.items()}
        for name, by_case in others.findings.items():
            if name in others.kinds:
                templates = [get_case(case).template for case in by_case]
                # one that fails to render left its row
                with suppress(EngineError):
                    texts = others.kinds[name].inputs(templates)
                    templates_by_name |= {f"{name}/{path}": text for path, text in texts.items()}
        return templates_by_name


Open = Callable[[str], AbstractContextManager[Engine]]
"""Opens an engine by its name, to be closed after use."""


def verify(  # noqa: PLR0913 - keywords of a public function
    level: str = "default",
    *,
    cases: str | Iterable[str] | Selection | None = None,
    engine: EngineChoice = None,
    engines: str | Iterable[str] = (),
    open_one: Open | None = None,
    fresh: bool = False,
    baseline: Path | Baseline | Literal[False] | None = None,
    progress: Progress = silent,
    strict: bool = False,
) -> Verification:
    """Hold an engine against theory, other codes and the baseline, case by case.

    ``level`` is ``quick``, ``default`` or ``full``. ``cases`` are names, groups or ``all``, or a
    :class:`Selection` of what is in them: those that run by default unless given. ``engine`` is an
    open one or a name, the default one unless given; ``engines`` are compared with it, opened by
    ``open_one``: names, or ``all``. Runs of engines that are opened here are kept; ``fresh`` runs
    them again. ``baseline`` is read, in a folder, the committed one for None, none for False. With
    ``strict`` not tested fails.

    An engine that fails leaves rows that say so and status 3, as does a case asked for by name or
    group of which no engine tested anything; a case that raises is a failed row; the rest goes on.
    Raise RequestError for an unknown level, case or engine, and a damaged file.
    """
    if cases is not None and not isinstance(cases, (str, Selection)):
        cases = ",".join(cases)
    wanted = cases if isinstance(cases, Selection) else Selection(cases)
    checked = checked_level(level)
    if isinstance(engine, str):
        engine_class(engine)  # raises for a name that is not known
    chosen, only, selection = wanted.chosen(checked), wanted.only, selected_engines(engines)
    opens = open_one or partial(opened, fresh=fresh)
    defects = with_further(wanted.defects)
    study = Study(checked, progress, opens, cases=tuple(chosen), only=only, defects=defects)
    accepted = None if baseline is False else chosen_baseline(baseline)
    begun, clock = datetime.now(UTC).isoformat(timespec="seconds"), time.monotonic()
    with ExitStack() as stack:
        run = MainRun(chosen, study)
        run.open(engine, fresh, stack)
        run.cases_side_by_side()
        others = OtherEngines(selection, chosen, study, run.engine).run()
        scripts, logs = run.scripts(others), run.engine.logs() if run.engine else {}
    measured = MeasuredRecords(study.level, run.engine_name, chosen, run.findings, run.broken)
    if only and not run.checks and not others.checks:
        raise nothing_matches(
            only, {row.name for finding in run.findings for row in finding.checks}
        )
    checks, regression = _against_baseline(measured, accepted, others, run)
    return Verification(
        level=study.level,
        cases=tuple(case.name for case in chosen),
        started=begun,
        seconds=time.monotonic() - clock,
        platform=f"{here()}, Python {platform.python_version()}",
        harness_version=__version__,
        provenance=run.provenance,
        checks=(*checks, *regression.checks),
        main=run.main,
        solvers=run.solvers,
        others=others.findings,
        engines=tuple(others.declared),
        scripts=scripts,
        engine_errors=(
            *(check.note for check in checks[: len(run.checks)] if check.engine_died),
            *others.errors,
        ),
        untested_cases=_untested_cases(chosen, wanted.cases, run, others),
        records=tuple(measured.records),
        divergences=(*run.divergences, *regression.divergences),
        baseline=accepted.where if accepted else "",
        baseline_sha256=accepted.digest if accepted else "",
        logs=logs,
        strict=strict,
        defects=_marked_defects(defects, checks),
    )


def _against_baseline(
    measured: MeasuredRecords, accepted: Baseline | None, others: OtherEngines, run: MainRun
) -> tuple[tuple[Check, ...], Regression]:
    """Return the checks, and the rows against the baseline that none of them explains."""
    checks = (*run.checks, *others.checks)
    if accepted is None:
        return checks, Regression()
    if run.study.only:  # what was left out is no row that is missing
        measured_names = {record.name for record in measured.records} | set(measured.errors)
        records = {
            name: record for name, record in accepted.records.items() if name in measured_names
        }
        accepted = replace(accepted, records=records)
    regression = baseline_rows(measured, accepted, others.records)
    rows = explained_by_cells(regression.checks, checks)
    return checks, replace(regression, checks=rows)


def _untested_cases(
    chosen: Sequence[Case[Any]],
    wanted: str | Iterable[str] | None,
    run: MainRun,
    others: OtherEngines,
) -> tuple[str, ...]:
    """Return the cases without a judged row of any engine: asked for by name, or a whole group.

    Of a group one case that is tested is enough. Own solvers do not count: they are no test of an
    engine.
    """
    texts = () if wanted is None else wanted.split(",") if isinstance(wanted, str) else wanted
    words = {text.strip() for text in texts}
    if "all" in words:
        return ()
    by_engine = (run.main, *others.findings.values())
    rows = {case.name: [c for by in by_engine if case.name in by for c in by[case.name].checks]
            for case in chosen if case.name not in run.raised}  # fmt: skip
    untested = {name for name, checks in rows.items() if not any(c.judged for c in checks)}
    tested = {case.group for case in chosen if case.name in rows.keys() - untested}
    return tuple(
        case.name
        for case in chosen
        if case.name in untested and (case.name in words or case.group in words - tested)
    )


def _marked_defects(
    defects: Sequence[KnownDefect], checks: Sequence[Check]
) -> tuple[tuple[KnownDefect, str], ...]:
    named = {defect_of(check) for check in checks}
    return tuple((defect, script_of(defect)) for defect in defects if defect.name in named)


def sections(verification: Verification) -> list[Section]:
    """Return what the cases make of their findings, in the order they were verified.

    Those by which engines qualify come first. A case that raises is a section that says so: the
    report is written all the same.
    """
    result: list[Section] = []
    for name in sorted(verification.cases, key=lambda name: not get_case(name).qualifies):
        solvers = verification.solvers.get(name, Findings(name))
        try:
            result += get_case(name).display.sections(
                verification.main.get(name), solvers, verification.of_case(name)
            )
        except Exception as error:
            text = f"The sections of this case could not be made: {type(error).__name__}: {error}"
            result.append(Section(name, (text,)))
    return result
