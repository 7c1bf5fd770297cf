"""Run the trials of a contact case at several steps each and judge their limits."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from harness.cases.contact.invariance import invariances
from harness.cases.contact.limits import (
    AGAIN,
    FINEST,
    RECORDED,
    SECONDS,
    STEPS,
    Evidence,
    RefinedTrial,
    Tried,
    lasting_powers,
    powers,
    refine,
    unresolved,
    width_of,
)
from harness.cases.contact.motion import followed, jumps_at_the_end, powers_of, rules_of
from harness.cases.contact.submodels import Submodel, Trial
from harness.cases.contact.transformations import chosen, labels, selected
from harness.cases.contract import LevelName
from harness.cases.verification import Study, Verification
from harness.comparison.convergence import Limit
from harness.comparison.regression import BaselineRecord, made_by, name_in_cell
from harness.comparison.verdicts import (
    Cell,
    Check,
    Kind,
    Planned,
    Tolerance,
    decided,
    failed_run,
    finding,
    is_undecided,
    judge,
    not_tested,
)
from harness.comparison.verification import Findings
from harness.engines.contract import Engine, Output
from harness.engines.registry import DEFAULT
from harness.errors import EngineError, EngineNaNError, RequestError
from harness.observables.row import Row
from harness.parameters.rules import Rules

if TYPE_CHECKING:
    from harness.cases.contact.contact_case import ContactCase


NO_FORCE = "its output tells no forces"

Run = tuple[Any, Output | EngineError]
"""Parameters, and what an engine made of them."""

MOVED = 10.0
"""Errors of a level by which the levels must differ for their order to be known."""


class ContactVerification(Verification):
    """Goes through the trials of a contact case, in the limit of a small step each."""

    case: ContactCase[Any]

    lists_rows = True

    @property
    def regression(self) -> Mapping[str, Tolerance]:
        """Return the same tolerance for each quantity."""
        return {quantity.name: AGAIN for quantity in self.case.quantities}

    def supported(self, engine: Engine) -> Sequence[Submodel]:
        """Return the submodels that an engine is verified with: more than its own by any other."""
        case = self.case
        return (
            case.submodels if engine.name == DEFAULT else (*case.submodels, *case.other_submodels)
        )

    def selectable(self, level: LevelName) -> set[str]:
        """Return the places of the trials of a level, those of invariances too, and their rows."""
        every = (*self.case.submodels, *self.case.other_submodels)
        trials = (*self.case.trials(level, every), *chosen(self.case, level))
        return {name for trial in trials for name in labels(self.case, trial)}

    def planned(self, level: LevelName, engine: Engine) -> Sequence[Planned]:
        """Return a check for each trial, and one for the invariances of each that has any."""
        trials = self.case.trials(level, self.supported(engine))
        values = [Planned(_name(self.case, trial, engine)) for trial in trials]
        moved = [_name(self.case, trial, engine) for trial in chosen(self.case, level)]
        return [*values, *(Planned(name, invariance=True) for name in moved)]

    def run(self, engine: Engine, study: Study) -> Findings:
        """Judge each trial in the limit of a small step, and that nothing else changes it.

        An engine beside the main one goes through the trials of ``other_submodels``, too, but
        through none that it ran as the main one.
        """
        case, key, supported = self.case, (self.case.name, engine.name), self.supported(engine)
        if study.role == "main":
            return study.once(key, lambda: self._with_invariances(engine, study, supported))
        done: Findings | None = study.once(key, lambda: None)
        ran = supported if done else ()
        submodels = [each for each in (*case.submodels, *case.other_submodels) if each not in ran]
        if not done and study.level == "full":
            findings = self._with_invariances(engine, study, submodels)
        else:
            findings = self._trials(engine, study, submodels)
        first: Evidence = done.evidence if done and done.evidence else Evidence(engine.title)
        refined = (*first.refined, *findings.evidence.refined)
        failed = (*first.failed, *findings.evidence.failed)
        findings.evidence = Evidence(engine.title, refined, failed)
        return findings

    def _trials(self, engine: Engine, study: Study, submodels: Sequence[Submodel]) -> Findings:
        trials = selected(self.case, self.case.trials(study.level, submodels), study)
        return verify_trials(self.case, engine, study, trials)

    def _with_invariances(
        self, engine: Engine, study: Study, submodels: Sequence[Submodel]
    ) -> Findings:
        findings = self._trials(engine, study, submodels)
        verifications = [case.verification for case in study.cases]
        contacts = [each.case for each in verifications if isinstance(each, ContactVerification)]
        findings.checks += invariances(self.case, engine, study, contacts)
        return findings


def verify_trials(
    case: ContactCase[Any], engine: Engine, study: Study, trials: Iterable[Trial]
) -> Findings:
    """Return the rows of trials at the steps of a level, refused ones as not tested."""
    findings = Findings(case.name, engine.name)
    runnable: list[Trial] = []
    for trial in trials:
        reason = engine.refuses(case.job(trial.parameters))
        if reason:
            row = not_tested(_name(case, trial, engine), Kind.ANALYTIC, reason)
            findings.checks.append(replace(row, cell=_cell(case, trial, engine)))
        else:
            runnable.append(trial)
    refined = _refined(case, engine, study.level, runnable)
    refined_trials, failed = [], []
    for number, (trial, runs, outcome) in enumerate(refined):
        if isinstance(outcome, EngineError):
            row = failed_run(_name(case, trial, engine), Kind.ANALYTIC, outcome)
            # with values that are no numbers it ran, and went wrong
            died = not isinstance(outcome, EngineNaNError)
            cell = _cell(case, trial, engine)
            findings.checks.append(replace(row, engine_died=died, cell=cell))
            finest = runs[-1][0]
            failed.append(Tried(trial, rules_of(case.job(finest), engine.traits), finest))
        else:
            findings.checks += _judged(case, outcome, engine)
            refined_trials.append(outcome)
            recorded = runs[STEPS[study.level].index(RECORDED)]
            findings.records.append(_record(case, trial, recorded, engine))
        study.progress(case.name, number + 1, len(runnable))
    findings.evidence = Evidence(engine.title, tuple(refined_trials), tuple(failed))
    return findings


def _refined(
    case: ContactCase[Any], engine: Engine, level: LevelName, trials: Sequence[Trial]
) -> list[tuple[Trial, list[Run], RefinedTrial | EngineError]]:
    """Return the runs of trials and their limits, with half the step again while one is undecided.

    No further than :data:`FINEST` allows, or :data:`SECONDS` for a run.
    """
    steps = STEPS[level]
    wanted = [t.parameters.replace(steps_per_contact=n) for t in trials for n in steps]
    outputs = engine.run([case.job(each) for each in wanted]) if wanted else []
    parts = [slice(i * len(steps), (i + 1) * len(steps)) for i in range(len(trials))]
    runs: list[list[Run]] = [list(zip(wanted[p], outputs[p], strict=True)) for p in parts]
    outcomes = [
        _limits_of_trial(case, *each, engine, level) for each in zip(trials, runs, strict=True)
    ]
    going = [*range(len(trials))]
    while True:
        finer = {i: _finer(case, outcomes[i], runs[i][-1][0], engine, level) for i in going}
        following = {i: parameters for i, parameters in finer.items() if parameters is not None}
        if not following:
            return list(zip(trials, runs, outcomes, strict=True))
        going = [*following]
        outputs = engine.run([case.job(each) for each in following.values()])
        for (i, parameters), output in zip(following.items(), outputs, strict=True):
            runs[i].append((parameters, output))
            outcomes[i] = _limits_of_trial(case, trials[i], runs[i], engine, level)


def _finer(
    case: ContactCase[Any],
    outcome: RefinedTrial | EngineError,
    last: Any,
    engine: Engine,
    level: LevelName,
) -> Any:
    """Return the parameters of a run with half the last step, None where none is to be made."""
    if isinstance(outcome, EngineError) or not _undecided_in(case, outcome):
        return None
    steps = 2 * last.steps_per_contact
    if steps > FINEST[level]:
        return None
    parameters = last.replace(steps_per_contact=steps)
    try:
        seconds = case.seconds(parameters, engine.traits)
    except RequestError:  # more steps than any run may have
        return None
    return parameters if seconds <= SECONDS[level] else None


def _undecided_in(case: ContactCase[Any], refined: RefinedTrial) -> bool:
    """Return whether a limit is too uncertain for its verdict.

    Where a force jumps its uncertainty is that of a few phases of the step: too little to fail by.
    """
    return any(
        is_undecided(reached.value, expected.value, reached.uncertainty, width)
        or (refined.jumps and abs(reached.value - expected.value) > width)
        for name, expected in refined.references.items()
        if (reached := refined.limits.get(name)) is not None and math.isfinite(expected.value)
        for width in [_tolerance(case, refined, name).width(expected.value)]
    )


def _tolerance(case: ContactCase[Any], refined: RefinedTrial, name: str) -> Tolerance:
    units = {quantity.name: quantity.unit for quantity in case.quantities}
    return width_of(
        units[name],
        kinked=refined.kinked,
        size=case.sizes(refined.finest).get(name, 1.0),
        along_path=bool(case.scene(refined.finest).segments) and not refined.jumps,
    )


def _limits_of_trial(
    case: ContactCase[Any],
    trial: Trial,
    runs: Sequence[Run],
    engine: Engine,
    level: LevelName,
) -> RefinedTrial | EngineError:
    """Return the limits of a trial, or the error of a run that failed."""
    values_of_levels = []
    for parameters, output in runs:
        if isinstance(output, EngineError):
            return output
        try:
            motion = case.motion(parameters, output)
        except EngineError as error:
            return error
        values_of_levels.append(case.observed(parameters, motion))
    finest = runs[-1][0]
    # what is expected, and what switches, is the same for all steps
    first = runs[len(STEPS[level]) - 1][0]
    steps = [parameters.steps_per_contact for parameters, _ in runs]
    rules = rules_of(case.job(finest), engine.traits)
    integrated = followed(case.scene(first), rules)
    of_law = lasting_powers if case.lasts else powers
    terms = case.powers or of_law(finest, powers_of(case.job(finest), engine.traits))
    ends = jumps_at_the_end(case.scene(first), rules)
    jumps = integrated.jumps or ends
    kinked = integrated.kinked or jumps
    # up to the end of an impact that codes bring on behind the motion the series is that of its law
    resolved = 2 if ends and trial.parameters.lags and not integrated.kinked else 1
    # a series without weights holds on the finest runs best
    used = slice(0 if kinked else -len(STEPS[level]), None)
    durations = np.array([case.scene(parameters).step for parameters, _ in runs[used]])
    bounds = unresolved(case, first, integrated, durations) if kinked else {}
    extrapolate = partial(
        refine, terms, steps[used], kinked=kinked, jumps=jumps, resolved=resolved, bounds=bounds
    )
    limits = extrapolate(values_of_levels[used])
    levels = tuple(parameters for parameters, _ in runs[used])
    references, plain = case.expected(first, rules), case.expected(first, Rules())
    expected = references, plain, limits
    return RefinedTrial(trial, rules, finest, *expected, motion, kinked, jumps, levels, extrapolate)


def _judged(case: ContactCase[Any], refined: RefinedTrial, engine: Engine) -> list[Check]:
    """Return a row for each quantity with a limit, and what is expected of it."""
    trial = refined.trial
    {quantity.name: quantity.unit for quantity in case.quantities}
    rows = []
    for name, expected in refined.references.items():
        reached = refined.limits.get(name)
        if not math.isfinite(expected.value):
            continue
        if reached is None and not refined.motion.tells_forces:
            row_without_force = not_tested(_name(case, trial, engine), Kind.CROSS_CODE, NO_FORCE)
            rows.append(replace(row_without_force, cell=_cell(case, trial, engine)))
            continue
        row = judge(
            f"{_name(case, trial, engine)}: {name}",
            Kind.ANALYTIC if expected.kind == "closed form" else Kind.CROSS_CODE,
            reached.value if reached else math.nan,
            expected.value,
            _tolerance(case, refined, name),
            uncertainty=reached.uncertainty if reached else math.nan,
        )
        steps = refined.finest.steps_per_contact
        row = decided(row, f"{steps} steps of a contact are the finest that the level runs")
        rows.append(replace(row, cell=_cell(case, trial, engine, reached)))
    return [*rows, *_moved_by_rules(case, refined, engine)]


def _moved_by_rules(case: ContactCase[Any], refined: RefinedTrial, engine: Engine) -> list[Check]:
    """Return a finding for the quantity that the engine's rules move most, if they move any."""
    units = {quantity.name: quantity.unit for quantity in case.quantities}
    sizes = case.sizes(refined.finest)
    moved = {}
    for name, plain in refined.plain.items():
        apart = abs(refined.references[name].value - plain.value)
        width = width_of(units[name], kinked=False, size=sizes.get(name, 1.0))
        if name in refined.limits and apart > width.width(plain.value):
            moved[name] = apart / (abs(plain.value) or 1.0)
    if not moved:
        return []
    name = max(moved, key=moved.__getitem__)
    predicted = refined.references[name].value - refined.plain[name].value
    changed = refined.rules.model_dump(exclude_defaults=True)
    row = finding(
        f"{_name(case, refined.trial, engine)}: {name} under other rules",
        refined.limits[name].value,
        refined.plain[name].value,
        units[name],
        f"{', '.join(f'{rule} = {word}' for rule, word in changed.items())}: moves it by "
        f"{predicted:.3g} by the integration under both rules",
        refined.limits[name].uncertainty,
    )
    return [row]


def _cell(
    case: ContactCase[Any], trial: Trial, engine: Engine, reached: Limit | None = None
) -> Cell:
    place = (case.name, trial.submodel, trial.system, engine.name)
    # an order is known where the levels differ by more than what the series misses them by
    if reached is None or np.ptp(reached.y) < MOVED * reached.errors.min():
        return Cell(*place)
    return Cell(*place, reached.order, *reached.order_interval)


def _name(case: ContactCase[Any], trial: Trial, engine: Engine) -> str:
    return trial.row_name(case.name, engine.name)


def _record(
    case: ContactCase[Any],
    trial: Trial,
    run: tuple[Any, Output | EngineError],
    engine: Engine,
) -> BaselineRecord:
    """Return one run, parameters and output, as a record of the baseline."""
    parameters, output = run
    assert isinstance(output, Output)
    values = case.read(parameters, output, engine.traits)
    units = {quantity.name: quantity.unit for quantity in case.quantities}
    return BaselineRecord(
        name=name_in_cell(_cell(case, trial, engine)),
        parameters=parameters.model_dump(mode="json"),
        quantities={
            name: Row(name, value, 0.0, "" if units[name] == "1" else units[name])
            for name, value in values.items()
            if math.isfinite(value) and abs(value) > 1e-9
        },
        case=case.name,
        label=f"{trial.submodel}, {trial.system}",
        family=(trial.submodel,),
        **made_by(output.provenance),
    )
