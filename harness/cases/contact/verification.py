"""Hold an engine's motion of each trial against the reference at the same steps."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from harness.cases.contact.motion import reference_motion
from harness.cases.contact.submodels import Submodel, Trial
from harness.cases.contract import LevelName
from harness.cases.verification import Study, Verification, places
from harness.comparison.explained import explained
from harness.comparison.verdicts import (
    Cell,
    Check,
    Kind,
    Planned,
    Tolerance,
    Verdict,
    failed_run,
    finding,
    judge,
    not_tested,
)
from harness.comparison.verification import Findings
from harness.engines.contract import Engine, Job, Output
from harness.engines.registry import DEFAULT
from harness.engines.scene_tables import motion_in
from harness.errors import EngineError, EngineNaNError
from harness.model.conventions import Rules
from harness.model.motion import Motion
from harness.model.scene import Scene

if TYPE_CHECKING:
    from harness.cases.contact.contact_case import ContactCase

TOLERANCE = 1e-9  # of the size that a quantity has in its case
REASON = "both take the same steps: what differs is round-off, or a fault"
SMALLEST_FINDING = 1e-4  # [size] moved by an engine's conventions
MOST_SEARCHED = 10  # failing runs of a case whose conventions are searched
QUICK_VARIATION = "defaults"
VARIED_SYSTEM = "two spheres"


@dataclass(frozen=True)
class TrialRun:
    """A trial in an engine, or a variation of it: its scene, conventions and outcome."""

    case: ContactCase[Any]
    trial: Trial
    engine: str
    variation: str
    scene: Scene
    rules: Rules
    outcome: Motion | EngineError

    @property
    def place(self) -> tuple[str, str, str, str, str]:
        """Return case, submodel, system, engine and variation."""
        return (self.case.name, self.trial.submodel, self.trial.system, self.engine, self.variation)

    @cached_property
    def values(self) -> Mapping[str, float]:
        """Return the quantities of the engine's motion; none where its run failed."""
        if isinstance(self.outcome, EngineError):
            return {}
        try:
            return self._observed(self.outcome)
        except (ArithmeticError, IndexError, ValueError):  # samples of no contact
            return {}

    @cached_property
    def expected(self) -> Mapping[str, float]:
        """Return the quantities of the reference by the engine's conventions."""
        return self._observed(reference_motion(self.scene, self.rules))

    def _observed(self, motion: Motion) -> Mapping[str, float]:
        with np.errstate(all="ignore"):  # what has no value is NaN, and fails
            return self.case.observed(self.trial.parameters, motion)

    def tolerance(self, name: str, expected: float) -> Tolerance:
        """Return the tolerance of a quantity."""
        return Tolerance(self.unit(name), TOLERANCE * self.size(name, expected), 0.0, REASON)

    def unit(self, name: str) -> str:
        """Return the unit of a quantity."""
        return next(quantity.unit for quantity in self.case.quantities if quantity.name == name)

    def size(self, name: str, expected: float) -> float:
        """Return the size of a quantity: as the case states it, else its own, of a ratio 1."""
        own = 1.0 if self.unit(name) == "1" else abs(expected) or 1.0
        return self.case.sizes(self.trial.parameters).get(name, own)

    def holds(self, motion: Motion, only: str = "") -> bool:
        """Return whether all quantities, or one, hold to their tolerance against a motion."""
        expected = self._observed(motion)
        return bool(self.values) and all(
            abs(self.values.get(name, math.nan) - value)
            <= self.tolerance(name, self.expected.get(name, value)).absolute
            for name, value in expected.items()
            if math.isfinite(value) and only in ("", name)
        )


@dataclass(frozen=True)
class Evidence:
    """The trials of a case in an engine, that ran or failed."""

    engine_title: str = ""
    tried: tuple[TrialRun, ...] = ()


class ContactVerification(Verification):
    """Goes through the trials of a contact case, one run of each at the same steps."""

    case: ContactCase[Any]

    lists_rows = True

    @property
    def regression(self) -> Mapping[str, Tolerance]:
        """Return nothing: no run is recorded."""
        return {}

    def supported(self, engine: Engine) -> Sequence[Submodel]:
        """Return the submodels that an engine is verified with: more than its own by any other."""
        case = self.case
        return (
            case.submodels if engine.name == DEFAULT else (*case.submodels, *case.other_submodels)
        )

    def selectable(self, level: LevelName) -> set[str]:
        """Return the places of the trials of a level, and their rows."""
        every = (*self.case.submodels, *self.case.other_submodels)
        trials = (*self.case.trials(level, every), *self._varied(level))
        return {name for trial in trials for name in labels(self.case, trial)}

    def planned(self, level: LevelName, engine: Engine) -> Sequence[Planned]:
        """Return a check for each trial."""
        trials = self.case.trials(level, self.supported(engine))
        return [Planned(trial.row_name(self.case.name, engine.name)) for trial in trials]

    def run(self, engine: Engine, study: Study) -> Findings:
        """Judge each trial, and the variations of some.

        An engine beside the main one goes through the trials of ``other_submodels``, too, but
        through none that it ran as the main one.
        """
        case, key, supported = self.case, (self.case.name, engine.name), self.supported(engine)
        if study.role == "main":
            return study.once(key, lambda: self._findings(engine, study, supported))
        done: Findings | None = study.once(key, lambda: None)
        ran = supported if done else ()
        submodels = [each for each in (*case.submodels, *case.other_submodels) if each not in ran]
        findings = self._findings(engine, study, submodels)
        first: Evidence = done.evidence if done and done.evidence else Evidence(engine.title)
        findings.evidence = Evidence(engine.title, (*first.tried, *findings.evidence.tried))
        return findings

    def _findings(self, engine: Engine, study: Study, submodels: Sequence[Submodel]) -> Findings:
        trials = self._selected(self.case.trials(study.level, submodels), study)
        names = {submodel.name for submodel in submodels}
        varied = self._selected(self._varied(study.level), study)
        return verify_trials(
            self.case, engine, study, trials, [t for t in varied if t.submodel in names]
        )

    def _selected(self, trials: Iterable[Trial], study: Study) -> list[Trial]:
        return [trial for trial in trials if study.selects(*labels(self.case, trial))]

    def _varied(self, level: LevelName) -> list[Trial]:
        """Return the trials that a level also runs by the variations of an engine."""
        case = self.case
        names = {"quick": case.by_defaults, "default": (*case.by_defaults, *case.over_ranks)}
        every = [submodel for submodel in case.submodels if submodel in case.invariant]
        wanted = {s.name for s in every} | {*names["default"]}
        if level != "full":
            wanted = {*names[level]}
        return [
            trial
            for trial in case.trials("full", case.submodels)
            if trial.submodel in wanted and (level == "full" or trial.system == VARIED_SYSTEM)
        ]


def labels(case: ContactCase[Any], trial: Trial) -> Iterator[str]:
    """Yield what a pattern may call a trial: its place, its quantities, its rows."""
    yield from places(case.name, trial.submodel, trial.system)
    for quantity in case.quantities:
        yield quantity.name
        yield f"{case.name}, {trial.system}: {trial.submodel}: {quantity.name}"


def verify_trials(
    case: ContactCase[Any],
    engine: Engine,
    study: Study,
    trials: Iterable[Trial],
    varied: Iterable[Trial] = (),
) -> Findings:
    """Return the rows of trials and of the variations of some, refused ones as not tested."""
    findings = Findings(case.name, engine.name)
    jobs: list[tuple[Trial, Job]] = []
    for trial in trials:
        job = case.job(trial.parameters)
        if reason := engine.refuses(job):
            row = not_tested(trial.row_name(case.name, engine.name), Kind.CROSS_CODE, reason)
            findings.checks.append(replace(row, cell=_cell(case, trial, engine.name)))
        else:
            jobs.append((trial, job))
    for trial in varied:
        job = case.job(trial.parameters)
        if job.scene is not None and not job.values and not engine.refuses(job):
            jobs += [
                (trial, replace(job, values={"variation": name}))
                for name, _ in engine.variations(job.scene)
                if study.level != "quick" or name == QUICK_VARIATION
            ]
    runs = _runs(case, engine, jobs)
    version, unexplained = engine.identify().engine_version if runs else "", 0
    for number, run in enumerate(runs):
        search = unexplained < MOST_SEARCHED
        rows = explained(judged(run), run, study.defects, version, search=search)
        unexplained += any(row.verdict is Verdict.FAIL for row in rows)
        findings.checks += rows
        study.progress(case.name, number + 1, len(runs))
    findings.evidence = Evidence(engine.title, tuple(run for run in runs if not run.variation))
    return findings


def _runs(
    case: ContactCase[Any], engine: Engine, jobs: Sequence[tuple[Trial, Job]]
) -> list[TrialRun]:
    outputs = engine.run([job for _, job in jobs]) if jobs else []
    runs = []
    for (trial, job), output in zip(jobs, outputs, strict=True):
        scene = engine.scene_of(job)
        outcome = output if isinstance(output, EngineError) else _motion_in(output, scene)
        name = str(job.values.get("variation", ""))
        rules = engine.rules(scene)
        runs.append(TrialRun(case, trial, engine.name, name, scene, rules, outcome))
    return runs


def _motion_in(output: Output, scene: Scene) -> Motion | EngineError:
    try:
        return motion_in(output, scene)
    except EngineError as error:
        return error


def judged(run: TrialRun) -> list[Check]:
    """Return a row for each quantity of a run, or the one of a run that failed."""
    kind = Kind.INVARIANCE if run.variation else Kind.CROSS_CODE
    name = run.trial.row_name(run.case.name, run.engine)
    name = f"{name}, {run.variation}" if run.variation else name
    cell = replace(_cell(run.case, run.trial, run.engine), invariance=run.variation)
    if isinstance(run.outcome, EngineError):
        row = failed_run(name, kind, run.outcome)
        # with values that are no numbers it ran, and went wrong
        died = not isinstance(run.outcome, EngineNaNError)
        return [replace(row, engine_died=died, cell=cell)]
    exact = {} if run.variation else run.case.closed_forms(run.trial.parameters)
    rows = []
    for quantity, expected in run.expected.items():
        if not math.isfinite(expected):
            continue
        note = ""
        if quantity in exact:
            error = expected - exact[quantity]
            note = f"error of the step {error:.2g} (closed form {exact[quantity]:.9g})"
        row = judge(
            f"{name}: {quantity}",
            kind,
            run.values.get(quantity, math.nan),
            expected,
            run.tolerance(quantity, expected),
            note=note,
        )
        rows.append(replace(row, cell=cell))
    return rows if run.variation else [*rows, *_moved_by_rules(run, name, cell)]


def _moved_by_rules(run: TrialRun, name: str, cell: Cell) -> list[Check]:
    """Return a finding for the quantity that an engine's conventions move most, if any."""
    changed = run.rules.changed
    if not changed:
        return []
    plain = run.case.observed(run.trial.parameters, reference_motion(run.scene))
    moved = {
        quantity: abs(expected - plain[quantity]) / run.size(quantity, plain[quantity])
        for quantity, expected in run.expected.items()
        if math.isfinite(expected - plain.get(quantity, math.nan)) and quantity in run.values
    }
    largest = max(moved, key=moved.__getitem__, default="")
    if not largest or moved[largest] < SMALLEST_FINDING:
        return []
    row = finding(
        f"{name}: {largest} under other rules",
        run.values[largest],
        plain[largest],
        run.unit(largest),
        f"{', '.join(f'{rule} = {word}' for rule, word in changed.items())}: moves it by "
        f"{run.expected[largest] - plain[largest]:.3g} by the reference under both rules",
    )
    return [replace(row, cell=cell)]


def _cell(case: ContactCase[Any], trial: Trial, engine: str) -> Cell:
    return Cell(case.name, trial.submodel, trial.system, engine)
