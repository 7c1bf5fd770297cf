"""Five checks that every engine passes: those of this package, and yours (engines/README.md)."""

from __future__ import annotations

import json
import tempfile
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import wraps
from pathlib import Path
from unittest import SkipTest

import numpy as np

from harness.cases.drop.case import HEAD_ON, Drop, job_of
from harness.cases.grain import COLUMNS, path_in
from harness.engines.border import engine_label
from harness.engines.contract import Engine, Job, Output, Template
from harness.engines.output import SERIES, Table
from harness.engines.programs import ProgramEngine
from harness.engines.reference import Reference
from harness.engines.registry import engine_class
from harness.engines.scene_jobs import scene_job
from harness.engines.scene_tables import motion_table
from harness.engines.traits import FRICTIONLESS
from harness.errors import RequestError
from harness.model.law import Law
from harness.model.scene import Scene, Wall, sphere
from harness.solvers import reference

TOLERANCE = 1e-9  # of the largest value: equal steps differ by round-off, mostly by 1e-13
ROUNDING = 1e-12  # of the largest value: a run in a batch against the run alone
LAWS = {  # an engine states some of them
    "hooke": Law(normal_stiffness=1e5, damping="velocity", damping_coefficient=50.0, clipped=True,
                 tangential="linear_history", tangential_damping=0.5),
    "undamped hooke": Law(normal_stiffness=1e5, tangential="linear_history"),
    "hertz": Law(normal="hertz", youngs_modulus=1e7, tangential="mindlin"),
    "jkr": Law(normal="jkr", youngs_modulus=1e7, surface_energy=10.0, tangential="mindlin"),
}  # fmt: skip
BALL = sphere(0.05, 2500.0, position=(0.0, 0.0, 0.05005), velocity=(0.5, 0.1, -1.0),
              angular_velocity=(3.0, -2.0, 5.0))  # fmt: skip
SCENES = {name: Scene(bodies=(BALL,), walls=(Wall(),), law=law, step=1.5e-4, steps=100)
          for name, law in LAWS.items()}  # fmt: skip
IMPACTS = {name: scene_job(scene) for name, scene in SCENES.items()}
OpenEngine = Callable[[], Engine]
Check = Callable[[Engine, OpenEngine], None]


class EngineCheckError(AssertionError):
    """A line for each check that failed: engine, check, expected, found."""


def identifies_itself(engine: Engine, open_engine: OpenEngine) -> None:
    """Require name, version and fingerprint, the same in every opening and in an output."""
    (output,), version = _run(engine, _drops(engine)[:1]), engine.identify().engine_version
    with open_engine() as again:
        found = [engine.identify(), again.identify(), output.provenance]
        prints = {json.dumps(each.fingerprint(), sort_keys=True) for each in (engine, again)}
    names = sorted({f"{each.engine} {each.engine_version}" for each in found})
    same = version and names == [f"{engine.name} {version}"]
    _require(same, f"{engine.name!r} and a version in all openings and outputs", names)
    _require(len(prints) == 1, "one fingerprint in all openings", sorted(prints))


def refuses_what_it_does_not_state(engine: Engine, _: OpenEngine) -> None:
    """Require one line of reason and no run of unknown templates, words and laws."""
    good, states = _drops(engine)[0], engine.traits.frictionless.states
    bad = {"a template that nobody wrote": Job(Template("no-such-template", {"": {}}), {})}
    for name, words in FRICTIONLESS.items():
        for word in set(words) - set(states.get(name, words)):
            bad[f"drop with {name} = {word}"] = replace(good, values={**good.values, name: word})
    bad |= {f"an impact with {law}": IMPACTS[law] for law in set(IMPACTS) - set(_stated(engine))}
    for name, job in bad.items():
        reason = engine.refuses(job)
        _require(reason and "\n" not in reason, f"a line of reason against {name}", repr(reason))
        with suppress(RequestError):
            engine.run([good, job])
            _require(False, f"RequestError from run for {name}", "outcomes")


def returns_an_outcome_for_each_job(engine: Engine, _: OpenEngine) -> None:
    """Require as many outcomes as jobs, in order, each the same as that of the job alone."""
    jobs = [*_drops(engine), *_stated(engine).values()]
    for place, output in enumerate(_run(engine, jobs)):
        found, alone = (out.tables[SERIES] for out in (output, *_run(engine, [jobs[place]])))
        _require_equal(found, alone, ROUNDING, f"in job {place} alone")


def reports_a_run_that_dies(engine: Engine, _: OpenEngine) -> None:
    """Require an error in place of a run that dies, and outputs of the others."""
    good = _drops(engine)
    bad = replace(good[1], values={**good[1].values, "speed": np.nan})
    with suppress(RequestError):  # refused before anything runs
        _run(engine, [good[0], bad, good[2]], errors=1)
    if isinstance(engine, ProgramEngine) and Path(engine.program).is_file():
        engine.identify()  # before its program is another
        with tempfile.TemporaryDirectory() as folder:
            program = Path(folder, Path(engine.program).name)
            die = f"mkdir '{folder}/died' 2>/dev/null && kill -SEGV $$"  # the first one started
            program.write_text(f"#!/bin/sh\n{die}\nexec '{engine.program}' \"$@\"\n")
            program.chmod(0o755)
            engine.program = str(program)
            _run(engine, good, errors=1)


def matches_the_reference(engine: Engine, _: OpenEngine) -> None:
    """Require the drop and oblique impacts of the reference at equal steps, by its own rules."""
    limit, impacts = TOLERANCE + 10.0 ** (1 - engine.traits.digits), _stated(engine)
    if integrator := engine.traits.integrator:
        runs = [_run(each, _drops(engine)) for each in (engine, Reference(integrator))]
        tables = [vars(path_in(outputs[0].table(COLUMNS))) for outputs in runs]
        _require_equal(tables[0], tables[1], limit, "in the reference's drop")
    for law, output in zip(impacts, _run(engine, [*impacts.values()]), strict=True):
        motion = reference.run(SCENES[law], engine.rules(SCENES[law]))
        table = motion_table(motion, SCENES[law])
        _require_equal(output.tables[SERIES], table, limit, f"in the reference's {law} impact")
    if not impacts:
        raise SkipTest(f"oblique: {engine.refuses(IMPACTS['hooke'])}")


CHECKS = (identifies_itself, refuses_what_it_does_not_state, returns_an_outcome_for_each_job,
          reports_a_run_that_dies, matches_the_reference)  # fmt: skip


def engine_checks(engine: str | OpenEngine) -> list[Callable[[], None]]:
    """Return the checks of an engine: its name, its class, or a function that opens one."""
    opened = engine_class(engine) if isinstance(engine, str) else engine
    return [_bound(check, opened) for check in CHECKS]


def check_engine(engine: str | OpenEngine) -> dict[str, str]:
    """Make all checks; return the reasons of skipped ones, raise EngineCheckError for failures."""
    skipped, failed = {}, []
    for check in engine_checks(engine):
        try:
            check()
        except SkipTest as reason:
            skipped[check.__name__] = str(reason)
        except EngineCheckError as error:
            failed.append(str(error))
    if failed:
        raise EngineCheckError("\n".join(failed))
    return skipped


def _bound(check: Check, open_engine: OpenEngine) -> Callable[[], None]:
    @wraps(check)
    def call() -> None:
        with open_engine() as engine:
            try:
                check(engine, open_engine)
            except SkipTest:
                raise
            except Exception as error:
                known = isinstance(error, EngineCheckError)
                text = str(error) if known else f"expected no exception, found {error!r}"
                line = f"{engine_label(engine)}: {check.__name__}: {' '.join(text.split())}"
                raise EngineCheckError(line) from error

    return call


def _require(holds: object, expected: str, found: object) -> None:
    if not holds:
        raise EngineCheckError(f"expected {expected}, found {found}")


def _drops(engine: Engine) -> list[Job]:
    words = {n: engine.traits.frictionless.states[n][0] for n in ("tail", "effective_mass")}
    drop = Drop(contact=HEAD_ON, gap=1e-3, speed=1.0, gravity=9.81, steps_per_contact=200.0,
                duration=2.0, every=10)  # fmt: skip
    jobs = [job_of(drop.replace(sideways=speed)) for speed in (0.25, 0.75, 0.5)]
    return [replace(job, values={**job.values, **words}) for job in jobs]


def _stated(engine: Engine) -> dict[str, Job]:
    return {law: job for law, job in IMPACTS.items() if not engine.refuses(job)}


def _run(engine: Engine, jobs: Sequence[Job], errors: int = 0) -> list[Output]:
    """Return the outputs of jobs; require an outcome for each, and so many errors."""
    outcomes = engine.run(jobs)
    found = [str(outcome) for outcome in outcomes if not isinstance(outcome, Output)]
    same = [len(outcomes), len(found), "\n" in "".join(found)] == [len(jobs), errors, False]
    expected = f"{len(jobs)} outcomes, of them {errors} errors of a line"
    _require(same, expected, f"{len(outcomes)}, of them {len(found)}: {'; '.join({*found})}")
    return [outcome for outcome in outcomes if isinstance(outcome, Output)]


def _require_equal(output: Table, expected: Table, limit: float, where: str) -> None:
    """Require equal columns, but for forces, within a limit of the largest value."""
    for name in (name for name in expected if not name.endswith(("_N", "_N_m", "step"))):
        value, found = (np.ravel(table.get(name, ())) for table in (expected, output))
        _require(value.size == found.size, f"{value.size} values of {name} {where}", found.size)
        worst = np.argmax(np.abs(found - value))
        close = abs(found[worst] - value[worst]) <= limit * np.abs(value).max()
        _require(close, f"{name} = {value[worst]:.15g} {where}", f"{found[worst]:.15g}")
