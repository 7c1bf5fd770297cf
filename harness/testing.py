"""Five checks that every engine passes: those of this package, and yours (engines/README.md)."""

from __future__ import annotations

import json
import tempfile
from collections.abc import Callable, Sequence
from contextlib import suppress
from functools import partial, wraps
from pathlib import Path
from unittest import SkipTest

import numpy as np

from harness.cases.drop import FEWEST_DIGITS
from harness.engines.base import Engine, Job, Output, Template, scene_job
from harness.engines.registry import engine_class
from harness.engines.scenes import FORCES, PARTS, motion_in, moved_bodies, unknown_parts
from harness.engines.scripts import ProgramEngine
from harness.errors import RequestError
from harness.model.law import Law
from harness.model.scene import Body, Motion, Scene, Wall, sphere
from harness.solvers import reference

TOLERANCE = 1e-9  # of the largest value: equal steps differ by round-off, mostly by 1e-13
ROUNDING = 1e-12  # of the largest value: a run in a batch against the run alone
# of what turns none of the spheres: over the speeds, and over the forces
BESIDE = {"angular_velocity": "velocity", "torque": "force"}
OpenEngine = Callable[[], Engine]
Check = Callable[[Engine, OpenEngine], None]


def _drop(law: Law, motion: str) -> Scene:
    """Return a grain that falls aslant on a fixed sphere, without friction."""
    grain = Body(radius=0.5, mass=1.0, position=(0.1, 1.0, 0.0), velocity=(0.25, -1.0, 0.0))
    fixed = Body(radius=0.5, mass=1.0, motion=motion)
    return Scene(bodies=(grain, fixed), law=law, gravity=(0.0, -9.81, 0.0), step=1.5e-5, steps=400,
                 every=10)  # fmt: skip


BALL = sphere(0.05, 2500.0, position=(0.0, 0.0, 0.05005), velocity=(0.5, 0.1, -1.0),
              angular_velocity=(3.0, -2.0, 5.0))  # fmt: skip
LAWS = {  # each engine has some of them
    "hooke": Law(normal_stiffness=1e5, damping="velocity", damping_coefficient=50.0, clipped=True,
                 tangential="linear_history", tangential_damping=0.5),
    "undamped hooke": Law(normal_stiffness=1e5, tangential="linear_history"),
    "hertz": Law(normal="hertz", youngs_modulus=1e7, tangential="mindlin"),
    "jkr": Law(normal="jkr", youngs_modulus=1e7, surface_energy=10.0, tangential="mindlin"),
}  # fmt: skip
SCENES = {
    f"drop, {tail}, {motion}": _drop(Law.linear(1e6, 0.2, tail == "clipped"), motion)
    for tail in ("attractive", "clipped")
    for motion in ("frozen", "held")
} | {
    f"oblique impact, {name}": Scene(
        bodies=(BALL,), walls=(Wall(),), law=law, step=1.5e-4, steps=100
    )
    for name, law in LAWS.items()
}
# the ball falls beyond the range of floating point
ENDLESS = Scene(bodies=(BALL,), walls=(Wall(),), law=Law(normal_stiffness=1e-3), step=1.0,
                steps=100, gravity=(0.0, 0.0, -1e308))  # fmt: skip
# the first process that is started dies, the others are the program
DYING = """#!/bin/sh
mkdir '{folder}/died' 2>/dev/null && kill -SEGV $$
exec '{program}' "$@"
"""


class EngineCheckError(AssertionError):
    """A line for each check that failed: engine, check, expected, found."""


def identifies_itself(engine: Engine, open_engine: OpenEngine) -> None:
    """Require name, version and fingerprint, the same in every opening and in an output."""
    (output,) = _run(engine, [*_jobs(engine).values()][:1])
    version = engine.identify().engine_version
    with open_engine() as again:
        origins = [engine.identify(), again.identify(), output.provenance]
        prints = {json.dumps(e.fingerprint(), sort_keys=True) for e in (engine, again)}
    names = sorted({f"{origin.engine} {origin.engine_version}" for origin in origins})
    same = version and names == [f"{engine.name} {version}"]
    _require(same, f"{engine.name!r} and a version in all openings and outputs", names)
    _require(len(prints) == 1, "one fingerprint in all openings", sorted(prints))


def refuses_what_it_does_not_state(engine: Engine, _: OpenEngine) -> None:
    """Require one line of reason and no run of an unknown template, and of scenes it refuses."""
    jobs = _jobs(engine)
    bad = {"a template that nobody wrote": Job(Template("no-such-template", {"": {}}), {})}
    bad |= {name: scene_job(scene) for name, scene in SCENES.items() if name not in jobs}
    for name, job in bad.items():
        reason = engine.refuses(job)
        _require(reason and "\n" not in reason, f"a line of reason against {name}", repr(reason))
        with suppress(RequestError):
            engine.run([*jobs.values(), job])
            _require(False, f"RequestError from run for {name}", "outcomes")


def returns_an_outcome_for_each_job(engine: Engine, _: OpenEngine) -> None:
    """Require as many outcomes as jobs, in order: first, middle and last as of the job alone."""
    jobs = _jobs(engine)
    names = [*jobs]
    outputs = dict(zip(names, _run(engine, [*jobs.values()]), strict=True))
    for name in (names[0], names[len(names) // 2], names[-1]):
        (alone,) = _run(engine, [jobs[name]])
        motion, expected = (motion_in(output, SCENES[name]) for output in (outputs[name], alone))
        _require_equal(SCENES[name], motion, expected, ROUNDING, f"in the {name} alone")


def reports_a_run_that_dies(engine: Engine, _: OpenEngine) -> None:
    """Require an error in place of a run that dies, and outputs of the others."""
    good, endless = [*_jobs(engine).values()][:2], scene_job(ENDLESS)
    if not engine.refuses(endless):
        with suppress(RequestError):  # refused before anything runs
            _run(engine, [good[0], endless, good[-1]], errors=1)
    if isinstance(engine, ProgramEngine) and Path(engine.program).is_file():
        engine.identify()  # before its program is another
        with tempfile.TemporaryDirectory() as folder:
            program = Path(folder, Path(engine.program).name)
            program.write_text(DYING.format(folder=folder, program=engine.program))
            program.chmod(0o755)
            engine.program = str(program)
            _run(engine, [*good, good[0]], errors=1)


def matches_the_reference(engine: Engine, _: OpenEngine) -> None:
    """Require the drops and oblique impacts of the reference at equal steps, by its own rules."""
    digits = engine.traits.digits
    _require(digits >= FEWEST_DIGITS, f"traits.digits of at least {FEWEST_DIGITS}", digits)
    limit, jobs = TOLERANCE + 10.0 ** (1 - digits), _jobs(engine)
    for name, output in zip(jobs, _run(engine, [*jobs.values()]), strict=True):
        scene = SCENES[name]
        expected = reference.run(scene, engine.rules(scene))
        motion = motion_in(output, scene)
        _require_equal(scene, motion, expected, limit, f"in the reference's {name}")


CHECKS = (identifies_itself, refuses_what_it_does_not_state, returns_an_outcome_for_each_job,
          reports_a_run_that_dies, matches_the_reference)  # fmt: skip


def engine_checks(engine: str | OpenEngine) -> list[Callable[[], None]]:
    """Return the checks of an engine: its name, its class, or a function that opens one."""
    open_engine = engine_class(engine) if isinstance(engine, str) else engine
    return [wraps(check)(partial(_make_check, check, open_engine)) for check in CHECKS]


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


def _make_check(check: Check, open_engine: OpenEngine) -> None:
    """Make a check of a new engine; whatever it raises is an EngineCheckError of a line."""
    with open_engine() as engine:
        try:
            check(engine, open_engine)
        except SkipTest:
            raise
        except Exception as error:
            is_failure = isinstance(error, EngineCheckError)
            text = str(error) if is_failure else f"expected no exception, found {error!r}"
            line = f"{engine.label()}: {check.__name__}: {' '.join(text.split())}"
            raise EngineCheckError(line) from error


def _require(holds: object, expected: str, value: object) -> None:
    if not holds:
        raise EngineCheckError(f"expected {expected}, found {value}")


def _jobs(engine: Engine) -> dict[str, Job]:
    """Return the jobs that an engine does not refuse; skip the check where it refuses all."""
    jobs = {name: scene_job(scene) for name, scene in SCENES.items()}
    reasons = {name: engine.refuses(job) for name, job in jobs.items()}
    if all(reasons.values()):
        raise SkipTest(f"it states no drop and no impact: {'; '.join(sorted({*reasons.values()}))}")
    return {name: job for name, job in jobs.items() if not reasons[name]}


def _run(engine: Engine, jobs: Sequence[Job], errors: int = 0) -> list[Output]:
    """Return the outputs of jobs; require an outcome for each, and so many errors."""
    outcomes = engine.run(jobs)
    texts = [str(outcome) for outcome in outcomes if not isinstance(outcome, Output)]
    same = [len(outcomes), len(texts), "\n" in "".join(texts)] == [len(jobs), errors, False]
    expected = f"{len(jobs)} outcomes, of them {errors} errors of a line"
    _require(same, expected, f"{len(outcomes)}, of them {len(texts)}: {'; '.join({*texts})}")
    return [outcome for outcome in outcomes if isinstance(outcome, Output)]


def _require_equal(
    scene: Scene, motion: Motion, expected: Motion, limit: float, where: str
) -> None:
    """Require equal motions within a limit of the largest value, and forces that are known."""
    moved, unknown = moved_bodies(scene), unknown_parts(scene, motion)
    for name in (part for part in PARTS if part not in unknown):
        bodies = moved if name in FORCES else slice(None)
        values, targets = (getattr(each, name)[:, bodies].ravel() for each in (motion, expected))
        worst = np.argmax(np.abs(values - targets))
        scale = np.abs(targets).max()
        if name in BESIDE:  # of spheres that do not turn
            scale = max(scale, np.abs(getattr(expected, BESIDE[name])).max())
        close = abs(values[worst] - targets[worst]) <= limit * scale
        _require(close, f"{name} = {targets[worst]:.15g} {where}", f"{values[worst]:.15g}")
