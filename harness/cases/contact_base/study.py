"""Run the trials of a contact case on a ladder of steps and judge the limits."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from harness.cases.contact_base.evidence import Climbed, Evidence, Failed
from harness.cases.contact_base.impact import steps_of
from harness.cases.contact_base.ladder import RECORDED, STEPS, climb, powers
from harness.cases.contact_base.motion import motion_of
from harness.cases.contact_base.reference import (
    followed,
    jumps_at_the_end,
    powers_of,
    rules_of,
)
from harness.cases.contact_base.submodels import Trial
from harness.cases.contact_base.tolerances import jump_of, width_of
from harness.cases.contract import Study
from harness.comparison.baseline_record import BaselineRecord, Quantity, made_by, name_in_cell
from harness.comparison.convergence import Limit
from harness.comparison.findings import Findings
from harness.comparison.verdicts import (
    Cell,
    Check,
    Kind,
    failed_run,
    finding,
    judge,
    not_tested,
)
from harness.engines.contract import Engine, Output
from harness.errors import EngineError, EngineNaNError
from harness.parameters.contact_rules import Rules

if TYPE_CHECKING:
    from harness.cases.contact_base.contact_case import ContactCase


NO_FORCE = "its output tells no forces"

MOVED = 10.0
"""Errors of a rung by which the rungs must differ for their order to be told."""


def verify_trials(
    case: ContactCase[Any], engine: Engine, study: Study, trials: Iterable[Trial]
) -> Findings:
    """Return the rows of trials on the ladder of a level, refused ones as not tested."""
    findings = Findings(case.name, engine.name)
    runnable: list[Trial] = []
    for trial in trials:
        reason = engine.refuses(case.job(trial.parameters))
        if reason:
            row = not_tested(_name(case, trial, engine), Kind.ANALYTIC, reason)
            findings.checks.append(replace(row, cell=_cell(case, trial, engine)))
        else:
            runnable.append(trial)
    steps = STEPS[study.level]
    rungs = [t.parameters.replace(steps_per_contact=n) for t in runnable for n in steps]
    outputs = engine.run([case.job(one) for one in rungs]) if rungs else []
    climbed, failed = [], []
    for number, trial in enumerate(runnable):
        own = slice(number * len(steps), (number + 1) * len(steps))
        runs = list(zip(rungs[own], outputs[own], strict=True))
        try:
            found = _climbed(case, trial, runs, engine)
        except EngineError as error:
            row = failed_run(_name(case, trial, engine), Kind.ANALYTIC, error)
            # with values that are no numbers it ran, and went wrong
            died = not isinstance(error, EngineNaNError)
            cell = _cell(case, trial, engine)
            findings.checks.append(replace(row, engine_died=died, cell=cell))
            failed.append(_failed(case, trial, runs, engine, error))
        else:
            findings.checks += _judged(case, found, engine)
            climbed.append(found)
            findings.records.append(_record(case, trial, runs[steps.index(RECORDED)], engine))
        study.progress(case.name, number + 1, len(runnable))
    drawn = study.level != "quick"
    findings.evidence = Evidence(engine.title, tuple(climbed), drawn=drawn, failed=tuple(failed))
    return findings


def _climbed(
    case: ContactCase[Any],
    trial: Trial,
    runs: Sequence[tuple[Any, Output | EngineError]],
    engine: Engine,
) -> Climbed:
    """Return the limits of a trial; raise the EngineError of a run that failed."""
    rungs = []
    for parameters, output in runs:
        if isinstance(output, EngineError):
            raise output
        motion = motion_of(output, case.scene(parameters))
        rungs.append(case.observed(parameters, motion))
    finest = runs[-1][0]
    steps = [parameters.steps_per_contact for parameters, _ in runs]
    rules = rules_of(case.job(finest), engine.traits)
    integrated = followed(case.scene(finest), rules)
    terms = case.powers or powers(trial.parameters, powers_of(case.job(finest), engine.traits))
    ends = jumps_at_the_end(case.scene(finest), rules)
    jumps = integrated.jumps or ends
    kinked = integrated.kinked or jumps
    slides = integrated.jumps and math.isfinite(integrated.ended)
    # up to the end of an impact that codes bring on behind the motion the series is that of its law
    known = 2 if ends and trial.parameters.lags and not integrated.kinked else 1
    limits = climb(terms, steps, rungs, kinked=kinked, jumps=jumps, known=known)
    references, plain = case.expected(finest, rules), case.expected(finest, Rules())
    told = trial, references, rules, finest, _command(output.log)
    return Climbed(*told, limits, plain, motion, kinked, slides, ends)


def _failed(
    case: ContactCase[Any],
    trial: Trial,
    runs: Sequence[tuple[Any, Output | EngineError]],
    engine: Engine,
    error: EngineError,
) -> Failed:
    """Return what is expected of a trial of which a run failed, and how."""
    finest, last = runs[-1]
    rules = rules_of(case.job(finest), engine.traits)
    # a run that ended may be found wrong only as it is read
    left = next((output for _, output in runs if isinstance(output, EngineError)), last)
    nan = isinstance(error, EngineNaNError)
    why = "left no finite value" if nan else f"left no value ({error.kind})"
    references = case.expected(finest, rules)
    return Failed(trial, references, rules, finest, _command(left.log), why)


def _command(log: str) -> str:
    """Return what a log begins with: the command that runs the same again."""
    return log.partition("\n")[0].removeprefix("# ")


def _judged(case: ContactCase[Any], found: Climbed, engine: Engine) -> list[Check]:
    """Return a row for each quantity with a limit, and what is expected of it."""
    trial = found.trial
    units = {quantity.name: quantity.unit for quantity in case.quantities}
    rows = []
    for name, expected in found.references.items():
        reached = found.limits.get(name)
        if not math.isfinite(expected.value):
            continue
        if reached is None and not found.motion.tells_forces:
            told = not_tested(_name(case, trial, engine), Kind.CROSS_CODE, NO_FORCE)
            rows.append(replace(told, cell=_cell(case, trial, engine)))
            continue
        digits = engine.traits.digits
        finest, where = found.finest, {"slides": found.slides, "ends": found.ends}
        jump = jump_of(finest.law, steps_of(finest), name, **where)
        tolerance = width_of(units[name], kinked=found.kinked, jump=jump, digits=digits)
        row = judge(
            f"{_name(case, trial, engine)}: {name}",
            Kind.ANALYTIC if expected.kind == "closed form" else Kind.CROSS_CODE,
            reached.value if reached else math.nan,
            expected.value,
            tolerance,
            uncertainty=reached.uncertainty if reached else math.nan,
        )
        rows.append(replace(row, cell=_cell(case, trial, engine, reached)))
    return [*rows, *_moved_by_rules(case, found, engine)]


def _moved_by_rules(case: ContactCase[Any], found: Climbed, engine: Engine) -> list[Check]:
    """Return a finding for the quantity that the engine's rules move most, if they move any."""
    units = {quantity.name: quantity.unit for quantity in case.quantities}
    moved = {}
    for name, plain in found.plain.items():
        apart = abs(found.references[name].value - plain.value)
        if name in found.limits and apart > width_of(units[name], kinked=False).width(plain.value):
            moved[name] = apart / (abs(plain.value) or 1.0)
    if not moved:
        return []
    name = max(moved, key=moved.__getitem__)
    predicted = found.references[name].value - found.plain[name].value
    told = found.rules.model_dump(exclude_defaults=True)
    row = finding(
        f"{_name(case, found.trial, engine)}: {name} under other rules",
        found.limits[name].value,
        found.plain[name].value,
        units[name],
        f"{', '.join(f'{rule} = {word}' for rule, word in told.items())}: moves it by "
        f"{predicted:.3g} by the integration under both rules",
        found.limits[name].uncertainty,
    )
    return [row]


def _cell(
    case: ContactCase[Any], trial: Trial, engine: Engine, reached: Limit | None = None
) -> Cell:
    place = (case.name, trial.submodel, trial.system, engine.name)
    # an order is told where the rungs differ by more than what the series misses them by
    if reached is None or np.ptp(reached.y) < MOVED * reached.errors.min():
        return Cell(*place)
    return Cell(*place, reached.order, *reached.order_interval)


def _name(case: ContactCase[Any], trial: Trial, engine: Engine) -> str:
    return f"{case.name}, {trial.system}: {trial.submodel}, {engine.name}"


def _record(
    case: ContactCase[Any],
    trial: Trial,
    run: tuple[Any, Output | EngineError],
    engine: Engine,
) -> BaselineRecord:
    """Return one rung, parameters and output, as a record of the baseline."""
    parameters, output = run
    assert isinstance(output, Output)
    values = case.read(parameters, output, engine.traits)
    units = {quantity.name: quantity.unit for quantity in case.quantities}
    return BaselineRecord(
        name=name_in_cell(_cell(case, trial, engine)),
        parameters=parameters.model_dump(mode="json"),
        quantities={
            name: Quantity(value, 0.0, "" if units[name] == "1" else units[name])
            for name, value in values.items()
            if math.isfinite(value) and abs(value) > 1e-9
        },
        case=case.name,
        label=f"{trial.submodel}, {trial.system}",
        family=(trial.submodel,),
        **made_by(output.provenance),
    )
