"""The suite that every engine goes through: those of this package, and yours.

In a test of your package, a test for each check::

    import pytest
    from harness.testing import engine_checks

    @pytest.mark.parametrize("check", engine_checks(MyEngine))
    def test_my_engine(check):
        check()

or, in one go, ``check_engine(MyEngine)``. A check that the engine has nothing for (no towers, no
scripts) is skipped with the reason. The suite says whether the harness can rely on what comes back;
``dem-harness verify`` says how good the physics is.
"""

from __future__ import annotations

import faulthandler
import json
import math
import multiprocessing
import os
import sys
import tempfile
from collections.abc import Callable, Iterator, Sequence
from contextlib import closing, contextmanager, suppress
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import product
from pathlib import Path
from typing import Any, get_args
from unittest import SkipTest

import numpy as np

from harness.cases.contact.contact_case import ContactCase
from harness.cases.contact.verification import verify_trials
from harness.cases.drop.case import TEMPLATE as DROP
from harness.cases.drop.case import Drop
from harness.cases.drop.case import job_of as drop_job
from harness.cases.drop.case import read as read_drop
from harness.cases.incline.runs import run_inclines
from harness.cases.incline.system import TEMPLATE as INCLINE
from harness.cases.incline.system import Incline, Motion
from harness.cases.incline.system import job_of as incline_job
from harness.cases.qualification import qualify
from harness.cases.registry import all_cases
from harness.cases.tower.run import run_towers
from harness.cases.tower.system import TEMPLATE as TOWER
from harness.cases.tower.system import job_of as tower_job
from harness.cases.tower.system import timing_of
from harness.cases.verification import Study
from harness.comparison.verdicts import Verdict
from harness.engines.contract import Engine, Job, Output, Template
from harness.engines.process import Limits, signal_of
from harness.engines.programs import ProgramEngine
from harness.engines.reference import INTEGRATORS, Reference
from harness.engines.registry import engine_class
from harness.engines.scripts import ScriptSource
from harness.errors import (
    EngineCrashError,
    EngineError,
    EngineMemoryError,
    EngineOutputError,
    EngineTimeoutError,
    HarnessError,
    RequestError,
)
from harness.observables.tower import impulse
from harness.parameters.law import Contact, EffectiveMass, Tail
from harness.parameters.rules import Rules
from harness.parameters.tower import Tower
from harness.solvers.chain import exact

SECONDS = 120.0
"""[s] of wall time that the first run may take."""

ROUNDING = 1e-12
"""Of the largest value: differences of runs that are the same but for what shares their process."""

FLIGHT = 1e-9
"""Of the distance: a free particle moves uniformly in every scheme."""

SPEEDS = (0.25, 0.75, 0.5)
"""[m/s] sideways of drops, one each, by which outcomes are recognized."""

OpenEngine = Callable[[], Engine]


class EngineCheckError(AssertionError):
    """What an engine did against the contract, after the names of the checks."""


@dataclass
class Subject:
    """An engine under test: how it is opened, and what the checks run in it."""

    open: OpenEngine
    seconds: float = SECONDS
    held: list[Engine] = field(default_factory=list)

    @cached_property
    def engine(self) -> Engine:
        """Return the engine, opened once, after a run in a process of its own came back."""
        if self.first_run:
            raise EngineCheckError(f"not tried: {self.first_run}")
        self.held.append(self.open())
        return self.held[0]

    @cached_property
    def first_run(self) -> str:
        """Return what is wrong with a run in a process of its own; nothing where it came back."""
        context = multiprocessing.get_context("fork")
        ours, theirs = context.Pipe(duplex=False)
        process = context.Process(target=_run_alone, args=(self.open, theirs), daemon=False)
        process.start()
        theirs.close()
        with closing(ours):
            if not ours.poll(self.seconds):
                process.kill()
                process.join()
                return f"the first run did not return within {self.seconds:g} s"
            try:
                answer = str(ours.recv())
            except EOFError:
                process.join()
                number = signal_of(process.exitcode or 0)
                how = number.name if number else f"exit status {process.exitcode}"
                return f"the process of the first run died: {how}"
        process.join(self.seconds)
        return answer

    @cached_property
    def contact(self) -> Contact:
        """Return a damped contact that the engine states, overdamped where it can."""
        traits = self.engine.traits
        contacts = (
            Contact(damping_ratio=zeta, tail=tail, effective_mass=mass)
            for zeta, tail in product((5.0, 0.5), get_args(Tail)[::-1])
            for mass in get_args(EffectiveMass)
            if zeta < 1.0 or tail == "clipped"
        )
        return next(contact for contact in contacts if not traits.refuses_contact(contact))

    def drop(self, **values: Any) -> Drop:
        """Return a drop that the engine states, for some tens of samples."""
        defaults = {"steps_per_contact": 200.0, "duration": 2.0, "every": 10, "speed": 1.0}
        return Drop(**{"contact": self.contact, "gap": 1e-3, **defaults, **values})

    def outputs(self, jobs: Sequence[Job]) -> list[Output]:
        """Return the outputs of jobs that must all succeed."""
        outcomes = self.engine.run(jobs)
        require(
            len(outcomes) == len(jobs),
            f"run returned {len(outcomes)} outcomes for {len(jobs)} jobs",
        )
        for outcome in outcomes:
            require(isinstance(outcome, Output), f"a good run failed: {outcome}")
        return [outcome for outcome in outcomes if isinstance(outcome, Output)]

    def close(self) -> None:
        """Close what was opened."""
        for engine in self.held:
            with suppress(HarnessError):
                engine.close()
        self.held.clear()


def _run_alone(open_engine: OpenEngine, answer: Any) -> None:
    """Run a drop and send what went wrong, nothing where it came back."""
    faulthandler.disable()  # the process that waits says how it died
    try:
        with open_engine() as engine:
            subject = Subject(open_engine)
            subject.__dict__["engine"] = engine
            if not engine.states(DROP):
                answer.send("it states no drop: it takes neither scenes nor has a script of one")
                return
            subject.outputs([drop_job(subject.drop())])
    except BaseException as error:
        answer.send(f"the first run raised {type(error).__name__}: {error}")
    else:
        answer.send("")
    finally:
        answer.close()


def require(condition: object, message: str) -> None:
    """Raise EngineCheckError unless a condition holds."""
    if not condition:
        raise EngineCheckError(message)


# ---- who it is ---------------------------------------------------------------------------------


def a_run_returns(subject: Subject) -> None:
    """Require that a run comes back in time, in a process that lives."""
    require(not subject.first_run, subject.first_run)


def it_says_who_it_is(subject: Subject) -> None:
    """Require its name and a version, the same in every opening and in every output."""
    engine = subject.engine
    provenance = engine.identify()
    require(
        provenance.engine == engine.name,
        f"identify names {provenance.engine!r}, the class {engine.name!r}",
    )
    require(provenance.engine_version, "identify names no version")
    require(provenance.engine_version.isprintable(), "its version holds control characters")
    require(engine.identify() == provenance, "identify answers differently when it is asked again")
    with subject.open() as again:
        other = again.identify().engine_version
    require(
        other == provenance.engine_version,
        f"opened again it is {other}, not {provenance.engine_version}",
    )
    (output,) = subject.outputs([drop_job(subject.drop())])
    first = output.provenance
    require(
        (first.engine, first.engine_version) == (provenance.engine, provenance.engine_version),
        f"an output is of {first.engine} {first.engine_version}, identify says "
        f"{provenance.engine} {provenance.engine_version}",
    )


def its_traits_are_sound(subject: Subject) -> None:
    """Require how to get it, a version that was tried, and rules that are known."""
    traits = subject.engine.traits
    require(traits.install_hint, "traits.install_hint is empty: how to get it")
    require(traits.versions, "traits.versions is empty: those that were tried")
    for name, allowed in (("tail", Tail), ("effective_mass", EffectiveMass)):
        supported = traits.frictionless.states.get(name, ())
        require(supported, f"traits.frictionless states no {name}")
        require(
            {*supported} <= {*get_args(allowed)}, f"traits.frictionless: {name} = {supported!r}"
        )
    require(traits.integrator in ("", *INTEGRATORS), f"traits.integrator = {traits.integrator!r}")
    for model in traits.contact_models:
        Rules(**model.rules)


def its_fingerprint_may_be_cached_under(subject: Subject) -> None:
    """Require JSON, the same in every opening, under which a run repeats to the last bit.

    Without a fingerprint nothing is cached, and nothing is required.
    """
    engine = subject.engine
    fingerprint = engine.fingerprint()
    if fingerprint is None:
        raise SkipTest("no fingerprint: nothing is cached")
    try:
        text = json.dumps(fingerprint, sort_keys=True)
    except (TypeError, ValueError) as error:
        raise EngineCheckError(f"its fingerprint is not ready for JSON: {error}") from None
    require(fingerprint, "its fingerprint is empty: any change of the program would go unseen")
    with subject.open() as again:
        other = json.dumps(again.fingerprint(), sort_keys=True)
    require(other == text, f"opened again its fingerprint is another: {other[:200]}")
    job = drop_job(subject.drop(sideways=0.3))
    first, second = (subject.outputs([job])[0] for _ in range(2))
    _same(first, second, 0.0, "a run that is repeated")


# ---- what it refuses ---------------------------------------------------------------------------


def it_refuses_what_it_cannot_state(subject: Subject) -> None:
    """Require a reason, before anything runs, for unknown templates and what breaks its rules."""
    engine = subject.engine
    unknown = Template("no-such-case-of-any-package", {"": {}})
    jobs = [Job(unknown, {})]
    good = drop_job(subject.drop())
    for name, allowed in (("tail", Tail), ("effective_mass", EffectiveMass)):
        unstated = {*get_args(allowed)} - {*engine.traits.frictionless.states[name]}
        jobs += [replace(good, values={**good.values, name: word}) for word in sorted(unstated)]
    require(not engine.states(unknown), "states says that it has a template that nobody wrote")
    require(engine.refuses(good) == "", f"it refuses a plain drop: {engine.refuses(good)}")
    for job in jobs:
        reason = engine.refuses(job)
        require(
            reason, f"it does not refuse {job.template.name!r} with {_changed_values(job, good)}"
        )
        require("\n" not in reason, f"a reason has more than one line: {reason!r}")
        try:
            engine.run([good, job])
        except RequestError as error:
            require(job.template.name in str(error), f"no template is named in {str(error)!r}")
        else:
            raise EngineCheckError(f"run does not refuse what refuses does: {reason}")


def _changed_values(job: Job, good: Job) -> str:
    changed = {n: v for n, v in job.values.items() if good.values.get(n) != v}
    return ", ".join(f"{name} = {value!r}" for name, value in changed.items()) or "no values"


def bad_values_are_refused_or_a_row(subject: Subject) -> None:
    """Require that a value that is no number is refused, or fails in its own row alone."""
    good = drop_job(subject.drop(sideways=0.5))
    for value in (math.nan, math.inf):
        bad = replace(good, values={**good.values, "speed": value})
        try:
            outcomes = subject.engine.run([good, bad, good])
        except RequestError:
            continue
        require(len(outcomes) == 3, f"run returned {len(outcomes)} outcomes for 3 jobs")
        failed = outcomes[1]
        if isinstance(failed, Output):
            with suppress(EngineError):
                read_drop(subject.drop(sideways=0.5), failed)
                raise EngineCheckError(f"speed = {value} m/s gave a motion of finite numbers")
        for outcome in (outcomes[0], outcomes[2]):
            require(isinstance(outcome, Output), f"a bad run took a good one along: {outcome}")


# ---- what it returns ---------------------------------------------------------------------------


def outcomes_are_in_order(subject: Subject) -> None:
    """Require that each outcome is that of its job, however many run side by side."""
    cases = [subject.drop(sideways=speed) for speed in (*SPEEDS, *SPEEDS)]
    jobs = [drop_job(case) for case in cases]
    for case, output in zip(cases, subject.outputs(jobs), strict=True):
        _sideways(case, output)
    by_place = dict(subject.engine.outcomes(jobs))
    require(
        sorted(by_place) == list(range(len(jobs))), f"outcomes yields the places {sorted(by_place)}"
    )
    for place, case in enumerate(cases):
        outcome = by_place[place]
        if isinstance(outcome, EngineError):
            raise EngineCheckError(f"a good run failed: {outcome}")
        _sideways(case, outcome)


def _sideways(case: Drop, output: Output) -> None:
    speed = float(read_drop(case, output).path.vx_m_per_s[0])
    require(
        math.isclose(speed, case.sideways, rel_tol=1e-6),
        f"the job with {case.sideways:g} m/s sideways starts with {speed:g} m/s",
    )


def a_batch_is_its_runs(subject: Subject) -> None:
    """Require that what shares a batch has no influence on a run."""
    jobs = [drop_job(subject.drop(sideways=speed)) for speed in SPEEDS]
    for job, together in zip(jobs, subject.outputs(jobs), strict=True):
        (alone,) = subject.outputs([job])
        _same(alone, together, ROUNDING, "a run in a batch")


def _same(output: Output, other: Output, width: float, label: str) -> None:
    require(output.tables.keys() == other.tables.keys(), f"{label} leaves other tables")
    for name, table in output.tables.items():
        for column, values in table.items():
            others = other.tables[name].get(column)
            same = others is not None and np.shape(others) == np.shape(values)
            if same and others is not None and np.size(values):
                most = width * float(np.nanmax(np.abs(values)))
                same = np.allclose(values, others, rtol=0.0, atol=most, equal_nan=True)
            require(same, f"{label} leaves another column {column!r} of table {name!r}")


def values_are_numbers(subject: Subject) -> None:
    """Require columns of finite numbers, one for each sample that was asked for."""
    case = subject.drop(sideways=0.5)
    (output,) = subject.outputs([drop_job(case)])
    require(output.tables, "an output has no table")
    for name, table in output.tables.items():
        for column, values in table.items():
            finite = np.isfinite(np.asarray(values, dtype=float)).all()
            require(finite, f"column {column!r} of table {name!r} holds what is no number")
    samples, wanted = len(read_drop(case, output).path.time_s), case.steps // case.every + 1
    require(samples == wanted, f"{samples} samples of {wanted}")


def units_are_those_of_a_free_flight(subject: Subject) -> None:
    """Require that a free particle moves by speed times time, in m and s."""
    case = subject.drop(gap=1.0, speed=1.0, sideways=0.5)
    (output,) = subject.outputs([drop_job(case)])
    path = read_drop(case, output).path
    clock = case.step * case.every * np.arange(len(path.time_s))
    written = 10.0 ** (1 - subject.engine.traits.digits)  # of a place, which is about a diameter
    for name, expected in (
        ("time_s", clock),
        ("x_m", case.sideways * clock),
        ("y_m", case.diameter + case.gap - case.speed * clock),
        ("vx_m_per_s", np.full(len(clock), case.sideways)),
        ("vy_m_per_s", np.full(len(clock), -case.speed)),
    ):
        values = getattr(path, name)
        width = FLIGHT * np.abs(expected).max() + written * max(1.0, np.abs(expected).max())
        worst = int(np.argmax(np.abs(values - expected)))
        require(
            abs(values[worst] - expected[worst]) <= width,
            f"{name} of a free particle is {values[worst]:.9g}, must be {expected[worst]:.9g}",
        )


# ---- its physics, coarsely ---------------------------------------------------------------------


def it_qualifies_by_drops(subject: Subject) -> None:
    """Require restitution, free fall, rest, onset and angular momentum on one fixed sphere."""
    qualification = qualify(subject.engine, [all_cases()["drop"]])
    require(qualification.holds, qualification.reason)


def an_incline_stops_and_slides(subject: Subject) -> None:
    """Require that a grain is trapped at 9 deg and moves on at 11 deg, as in the reference DEM."""
    engine = subject.engine
    steps = 400.0 if subject.contact.zeta > 1.0 else 100.0
    cases = [
        Incline(contact=subject.contact, stiffness=1e5, steps_per_contact=steps, angle=angle)
        for angle in (9.0, 11.0)
    ]
    for case in cases:
        _require_stated(engine, incline_job(case, "passage"), INCLINE)
    traits = engine.traits
    theirs = run_inclines(Reference(traits.integrator), cases, "passage")
    for run, expected in zip(run_inclines(engine, cases, "passage"), theirs, strict=True):
        if isinstance(run, EngineError) or isinstance(expected, EngineError):
            raise EngineCheckError(f"the run of an incline failed: {run}")
        angle = f"at {run.case.angle:g} deg"
        wanted = Motion.TRAPPED if run.case.angle < 10.0 else Motion.MOVES_ON
        require(run.motion is wanted, f"{angle} the grain is {run.motion}, must be {wanted}")
        apart = run.margin - expected.margin
        require(abs(apart) < 1e-4, f"{angle} its margin is {apart:.2g} m g d off the reference DEM")


def a_tower_is_the_exact_one(subject: Subject) -> None:
    """Require peak force and impulse on a tower of two as the exact propagator has them."""
    engine, case = subject.engine, Tower(height=2, law="overlap", stiffness=1e5)
    _require_stated(engine, tower_job(case, timing_of(case, 3.0, 2000.0, 2000)), TOWER)
    (run,) = run_towers(engine, [case], 3.0, steps_per_contact=2000.0, samples=2000)
    if isinstance(run, EngineError):
        raise EngineCheckError(f"the run of a tower failed: {run}")
    truth = exact.run(case, run.time[-1], samples=len(run.time) - 1)
    pairs = {
        "peak force": (run.grain_force.max(), truth.grain_force.max()),
        "impulse": (impulse(run), impulse(truth)),
    }
    for name, (measured, wanted) in pairs.items():
        # of first order in the step: omega h is 1.6e-3
        require(
            abs(measured / wanted - 1.0) < 2e-3,
            f"the {name} on a tower of two is {measured:.6g}, must be {wanted:.6g}",
        )


def _require_stated(engine: Engine, job: Job, template: Template) -> None:
    reason = "no template" if not engine.states(template) else engine.refuses(job)
    if reason:
        raise SkipTest(f"{template.name}: {reason}")


def contacts_follow_their_rules(subject: Subject) -> None:
    """Require that a bounce and an oblique impact hold under the rules that it declares."""
    engine, seen, failed = subject.engine, set(), []
    for name in ("bounce", "oblique"):
        case = all_cases().get(name)
        if not isinstance(case, ContactCase) or not engine.states(case.template):
            continue
        for trial in case.trials("quick", case.submodels):
            job = case.job(trial.parameters)
            assert job.scene is not None
            law = (name, job.scene.law.normal)
            if law in seen or engine.refuses(job):
                continue
            seen.add(law)
            checks = verify_trials(case, engine, Study("quick"), [trial]).checks
            failed += [c.name for c in checks if c.verdict is Verdict.FAIL]
    if not seen:
        raise SkipTest("it states no contact with friction")
    require(not failed, "; ".join(failed))


# ---- scripts and processes ---------------------------------------------------------------------


def scripts_are_reproducible(subject: Subject) -> None:
    """Require scripts that are the same each time, name no place of this machine, lose no digit."""
    engine = subject.engine
    if not isinstance(engine, ScriptSource):
        raise SkipTest("it takes scenes, not scripts")
    templates = [case.template for case in all_cases().values()]
    texts = type(engine).inputs(templates)
    require(texts, "it writes no script")
    require(type(engine).inputs(templates) == texts, "its scripts differ when they are made again")
    for name, text in texts.items():
        require(text.endswith("\n"), f"{name} does not end with a line feed")
        for place in (sys.prefix, str(Path.home()), tempfile.gettempdir() + os.sep):
            require(len(place) < 3 or place not in text, f"{name} names {place!r}")
    task = engine.task(drop_job(subject.drop(stiffness=1e6 / 3.0)))
    require(task.script.variables, f"{task.script.name} declares no variable")
    require(task.values, f"nothing can be set in {task.script.name}")
    require(
        any(isinstance(v, float) and float(engine.literal(v)) == v for v in task.values.values()),
        "numbers lose digits in its scripts",
    )


FAULTS: dict[str, tuple[str, type[EngineError]]] = {
    "dies": ("kill -SEGV $$", EngineCrashError),
    "hangs": ("sleep 60", EngineTimeoutError),
    "says nothing": ("exit 0", EngineOutputError),
    "takes more memory than it may": (
        f'exec "{sys.executable}" -c "bytearray(1 << 40)"',
        EngineMemoryError,
    ),
}
"""What a program does, as a shell does it, and the error that names it."""


def faults_of_its_program_are_rows(subject: Subject) -> None:
    """Require a row with the fault's name where its program dies, hangs or is out of memory."""
    for fault, (command, error) in FAULTS.items():
        with _faulty(subject, command) as engine:
            # a busy machine takes seconds to start a program that dies
            engine.limits = Limits(seconds=2.0 if error is EngineTimeoutError else subject.seconds)
            (outcome,) = engine.run([drop_job(subject.drop())])
        require(
            type(outcome) is error,
            f"a program that {fault} ends as {outcome!r}, must be {error.__name__}",
        )
        require("\n" not in str(outcome), f"the error has more than one line: {outcome}")
        log = outcome.log if isinstance(outcome, EngineError) else ""
        require(log, f"the log of a program that {fault} is empty")


@contextmanager
def _faulty(subject: Subject, command: str) -> Iterator[ProgramEngine]:
    """Open the engine, and put a shell command in the place of its program."""
    with tempfile.TemporaryDirectory() as folder, subject.open() as engine:
        if not isinstance(engine, ProgramEngine) or not Path(engine.program).is_file():
            raise SkipTest("it starts no program")
        engine.identify()
        program = Path(folder, Path(engine.program).name)
        program.write_text(f"#!/bin/sh\n{command}\n", encoding="utf-8")
        program.chmod(0o755)
        engine.program = str(program)
        yield engine


def a_closed_engine_runs_nothing(subject: Subject) -> None:
    """Require that it may be closed twice, and that no program starts then."""
    engine = subject.open()
    engine.identify()
    engine.close()
    engine.close()
    try:
        outcomes = engine.run([drop_job(subject.drop())])
    except EngineError:
        return
    require(len(outcomes) == 1, f"closed, it returned {len(outcomes)} outcomes for a job")
    if isinstance(engine, ProgramEngine):
        require(isinstance(outcomes[0], EngineError), "closed, it still starts its program")


CHECKS: tuple[Callable[[Subject], None], ...] = (
    a_run_returns,
    it_says_who_it_is,
    its_traits_are_sound,
    its_fingerprint_may_be_cached_under,
    it_refuses_what_it_cannot_state,
    bad_values_are_refused_or_a_row,
    outcomes_are_in_order,
    a_batch_is_its_runs,
    values_are_numbers,
    units_are_those_of_a_free_flight,
    it_qualifies_by_drops,
    an_incline_stops_and_slides,
    a_tower_is_the_exact_one,
    contacts_follow_their_rules,
    scripts_are_reproducible,
    faults_of_its_program_are_rows,
    a_closed_engine_runs_nothing,
)


@dataclass(frozen=True)
class EngineCheck:
    """A named check of an engine; a call raises EngineCheckError, or SkipTest with a reason."""

    check: Callable[[Subject], None]
    subject: Subject

    @property
    def __name__(self) -> str:
        """Return the name, by which pytest knows it."""
        return self.check.__name__

    def __call__(self) -> None:
        """Make the check."""
        self.check(self.subject)


def engine_checks(
    engine: str | type[Engine] | OpenEngine, *, seconds: float = SECONDS
) -> list[EngineCheck]:
    """Return the checks of an engine: its name, its class, or a function that opens one.

    ``seconds`` of wall time are what the first run may take before it counts as hanging. The
    checks share one opened engine; nothing is opened before the first is made.
    """
    opened = engine_class(engine) if isinstance(engine, str) else engine
    subject = Subject(opened, seconds)
    return [EngineCheck(check, subject) for check in CHECKS]


def check_engine(
    engine: str | type[Engine] | OpenEngine, *, seconds: float = SECONDS
) -> dict[str, str]:
    """Make all checks of an engine; return why some were skipped, by their names.

    Raise EngineCheckError that names the checks that failed, each with what it found.
    """
    skipped, failed = {}, []
    checks = engine_checks(engine, seconds=seconds)
    try:
        for check in checks:
            try:
                check()
            except SkipTest as reason:
                skipped[check.__name__] = str(reason)
            except Exception as error:
                kind = "" if isinstance(error, EngineCheckError) else f"{type(error).__name__}: "
                failed.append(f"{check.__name__}: {kind}{error}")
    finally:
        checks[0].subject.close()
    if failed:
        raise EngineCheckError("\n".join(failed))
    return skipped
