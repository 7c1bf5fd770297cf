"""Hold a run of a contact against the same run transformed, within what round-off can do.

Each is held against a run of the same engine, with the same law, step and scheme: no reference is
needed, and what is left is round-off, or nothing.

Each step rounds positions and velocities. mdr's force of a flat at the depth d, in an ellipse of
axes A and B, E' A B / 4 (theta - sin theta cos theta), cos theta = 1 - 2 d / A, is a difference in
which digits are lost, more of them the smaller d. As codes write it, acos(1 - y) - (1 - y) sqrt(2 y
- y^2), y = 2 d / A: 1 - y is rounded by eps / 4, which acos multiplies by 1 / sin theta, at most
pi / (2 theta); what else is rounded is theta at most, eight times by eps / 2. The difference is off
by eps (1 / (2 theta) + 4 theta) at most, and by sqrt(eps) where 1 - y is rounded to 1.

What that leaves of a motion follows from the overlaps that an engine goes through: at each step a
push of that error, carried on by the law made linear about them, their absolute values added up.
Friction takes mu of it along the surface, 5/2 of that over the radius in a spin. Two runs differ
by twice the sum. Where it yields, a sphere that is pressed in has no such difference, one that
springs back that of its own ellipse; of the bulk, the ellipse keeps the depth of its first step.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from harness.cases.contact.impact import overlap_of
from harness.cases.contact.motion import FORCES, Array, Motion, followed, motion_of, rules_of
from harness.cases.contact.parameters import rest_overlap
from harness.cases.contact.submodels import Trial
from harness.cases.contact.transformations import (
    MOVED,
    PARTS,
    PLAIN,
    ROUNDINGS,
    STEPPED,
    TransformedRun,
    TrialRuns,
    chosen,
    first_runs,
    later_runs,
    selected,
    why_not,
)
from harness.cases.contract import LevelName
from harness.cases.verification import Study
from harness.comparison.verdicts import Cell, Check, Kind, Tolerance, failed_run, judge, not_tested
from harness.engines.contract import Engine, Output
from harness.engines.traits import Traits
from harness.errors import EngineError, EngineMissingError, EngineNaNError
from harness.parameters.rules import Rules
from harness.parameters.scene import ContactScene
from harness.solvers.pair.normal import ELASTIC, PLASTIC, SWELLING, pressed, sprung_back
from harness.solvers.pair.records import System, compiled
from harness.solvers.pair.system import system_of

if TYPE_CHECKING:
    from harness.cases.contact.contact_case import ContactCase


def sizes_of(runs: TrialRuns, traits: Traits) -> dict[str, float]:
    """Return what differences are measured in: overlap, speed of the contact, largest force.

    The overlap is that of the largest force at rest, the speed at least what moves by it in
    the time of a contact; both with the radius as the lever. A force that a code does not tell is
    that of the law.
    """
    motion, law, plain = runs.motion(PLAIN), runs.trial.parameters, runs.runs[PLAIN]
    assert motion is not None
    scene, r, pulled = plain.scene, law.radius, motion.force[:, 0]
    if not motion.tells_forces:
        pulled = followed(scene, rules_of(plain.job, traits)).motion.force[:, 0]
    weight = scene.bodies[0].mass * np.array(scene.gravity)
    force = float(np.linalg.norm(pulled - weight, axis=1).max())
    overlap = rest_overlap(law, force)
    speed = max(
        float(np.linalg.norm(motion.velocity, axis=2).max()),
        r * float(np.linalg.norm(motion.omega, axis=2).max()),
        overlap / (law.steps_per_contact * scene.step),
    )
    return {
        "position": overlap,
        "velocity": speed,
        "omega": speed / r,
        "force": force,
        "torque": force * r,
    }


def of_digits(runs: TrialRuns, sizes: Mapping[str, float], traits: Traits, width: float) -> float:
    """Return what the round-off of mdr's force may leave of the sizes, besides that of the run."""
    stepped, plain = runs.motion(STEPPED), runs.runs[PLAIN]
    if runs.trial.parameters.normal != "mdr":
        return 0.0
    if stepped is None:
        return math.inf

    overlaps, _ = overlap_of(runs.trial.parameters, stepped)
    rules, slack = rules_of(plain.job, traits), width * sizes["position"]
    return of_force(plain.scene, rules, overlaps, sizes, slack)


def round_off_of(run: TransformedRun, runs: TrialRuns, sizes: Mapping[str, float]) -> float:
    """Return the part of the sizes that round-off may change."""
    motion, scene = runs.motion(PLAIN), runs.runs[PLAIN].scene
    assert motion is not None
    far = float(np.abs(motion.position).max()) + run.drift * scene.duration + run.reach
    fast = float(np.abs(motion.velocity).max()) + run.drift
    rounded = far / sizes["position"] + fast / sizes["velocity"]
    return ROUNDINGS * run.scene.steps * float(np.finfo(float).eps) * rounded


EPS = float(np.finfo(float).eps)

FORCE_ROUND_OFF = 8.0
"""Roundings of a force besides, each of eps of itself, at most."""


@compiled
def lost(theta: float) -> float:
    """Return by how much theta - sin theta cos theta is off at most, as codes write it."""
    most = math.sqrt(EPS)
    return most if theta <= 0.0 else min(most, EPS * (0.5 / theta + 4.0 * theta))


def of_force(
    scene: ContactScene, rules: Rules, overlaps: Array, sizes: Mapping[str, float], slack: float
) -> float:
    """Return the part of the sizes by which two runs of mdr may differ for its force's round-off.

    ``overlaps`` (M,) [m] are those of every step, each off by ``slack`` [m] at most.
    """
    system = system_of(scene, rules)
    h, mass = scene.step, float(system.contacts[0]["mass"])
    errors, slopes = _errors(system, overlaps, slack)
    pushes = np.flatnonzero(errors)
    x, v = np.zeros(len(pushes)), np.zeros(len(pushes))
    worst, begun = 0.0, 0
    for k in range(len(overlaps)):
        x += h * v
        v -= h / mass * slopes[k] * x
        if errors[k] > 0.0:
            v[begun] += h / mass * errors[k]
            begun += 1
        away, fast = float(np.abs(x).sum()), float(np.abs(v).sum())
        worst = max(
            worst,
            away / sizes["position"],
            fast / sizes["velocity"],
            (errors[k] + slopes[k] * away) / sizes["force"],
        )
    return 2.0 * (1.0 + 3.5 * (scene.law.friction or 0.0)) * worst


@compiled
def _errors(system: System, overlaps: Array, slack: float) -> tuple[Array, Array]:
    """Return by how much the force is off at each overlap [N], at most, and its slope [N/m]."""
    law, contact = system.law, system.contacts[0]
    flats = 1.0 if contact.second < 0 else 2.0
    first, largest = 0.0, 0.0
    errors, slopes = np.zeros(len(overlaps)), np.zeros(len(overlaps))
    for k in range(len(overlaps)):
        overlap = overlaps[k]
        if overlap + slack <= contact.last:
            continue
        if first == 0.0:
            first = max(overlap, 0.0)
        opens = overlap < largest
        largest = max(largest, overlap)
        _follow(system, largest, flats, opens)
        elastic = pressed(law, contact, overlap)
        depth = min(overlap, first) if law.bulk else overlap
        errors[k] = FORCE_ROUND_OFF * EPS * abs(elastic.force)
        errors[k] += _of_ellipse(system, depth - slack, flats, opens)
        slopes[k] = elastic.slope
    return errors, slopes


@compiled
def _follow(system: System, largest: float, flats: float, opens: bool) -> None:
    """Tell the contact how far it has been pressed in [m], and whether it opens."""
    law, contact = system.law, system.contacts[0]
    depth = largest / flats
    contact.stage = ELASTIC
    if law.yields and depth > contact.onset:
        contact.stage = SWELLING if depth > contact.swells else PLASTIC
        contact.last = flats * sprung_back(law, contact, depth, contact.first_radius).residual
    contact.largest = largest if opens else 0.0


@compiled
def _of_ellipse(system: System, overlap: float, flats: float, opens: bool) -> float:
    """Return by how much the force of the ellipse is off at an overlap [m], at most [N]."""
    law, contact = system.law, system.contacts[0]
    modulus = 2.0 * law.stiffness
    if contact.stage != ELASTIC:
        if not opens:
            return 0.0
        dent = sprung_back(law, contact, contact.largest / flats, contact.first_radius)
        depth = (overlap / flats - dent.residual) * dent.stretch
        return float(0.25 * modulus * dent.height * dent.width * lost(_angle(depth / dent.height)))
    first, second = contact.first_radius, contact.second_radius
    most = max(contact.largest, overlap)
    share = 1.0 if flats < 2.0 else 0.5 * (2.0 * second - most) / (first + second - most)
    sides = first**2 * lost(_angle(0.25 * share * overlap / first))
    if flats < 2.0:
        return float(2.0 * modulus * sides)
    sides += second**2 * lost(_angle(0.25 * (1.0 - share) * overlap / second))
    return float(modulus * sides)


@compiled
def _angle(part: float) -> float:
    return 2.0 * math.asin(math.sqrt(min(1.0, part))) if part > 0.0 else 0.0


DIGITS = "mdr's force, a difference, loses digits at small overlaps: what its steps add up to"


def invariances(
    case: ContactCase[Any],
    engine: Engine,
    study: Study,
    together: Sequence[ContactCase[Any]] = (),
) -> list[Check]:
    """Return a row for each transformed run of the trials of a level.

    On several MPI ranks those of the cases ``together`` run in one batch: the start of a process
    on several ranks costs more than the runs in it.
    """
    level = study.level
    trials = [
        first_runs(case, trial, level) for trial in selected(case, chosen(case, level), study)
    ]
    _run(trials, engine)
    for runs in trials:
        runs.runs |= {
            later_run.name: later_run
            for later_run in later_runs(runs, engine, level)
            if later_run.ranks == 1
        }
    _run(trials, engine)
    rows = [row for runs in trials for row in _rows(runs, engine)]
    if level == "quick":
        return rows
    return rows + _over_ranks(case, engine, study, tuple(together) or (case,))


def _over_ranks(
    case: ContactCase[Any], engine: Engine, study: Study, together: Sequence[ContactCase[Any]]
) -> list[Check]:
    """Return the rows of a case on several MPI ranks."""
    names = tuple(each.name for each in together)
    rows = study.once(
        ("over ranks", engine.name, names), lambda: _all_over_ranks(together, engine, study)
    )
    return [row for row in rows if row.cell and row.cell.case == case.name]


def _all_over_ranks(cases: Sequence[ContactCase[Any]], engine: Engine, study: Study) -> list[Check]:
    """Return the rows of cases on several MPI ranks, those of one number of ranks run together."""
    level = study.level
    trials = [
        first_runs(case, trial, level)
        for case in cases
        for trial in selected(case, chosen(case, level), study)
        if _most_ranks(case, trial, level) > 1
    ]
    for runs in trials:
        runs.runs = {name: run for name, run in runs.runs.items() if name in (PLAIN, MOVED)}
    _run(trials, engine)
    for runs in trials:
        ranks = range(2, _most_ranks(runs.case, runs.trial, level) + 1)
        runs.runs |= {w.name: w for w in later_runs(runs, engine, level) if w.ranks in ranks}
    _run(trials, engine)
    return [row for runs in trials for row in _rows(runs, engine, lambda run: run.ranks > 1)]


def _most_ranks(case: ContactCase[Any], trial: Trial, level: LevelName) -> int:
    """Return on how many ranks a trial is run: all of them on four at level full."""
    if level == "full":
        return 4
    return 2 if trial.submodel in case.over_ranks else 1


def _run(trials: Sequence[TrialRuns], engine: Engine) -> None:
    """Run those that have not run, those of each number of ranks together."""
    todo = [(runs, w) for runs in trials for w in runs.runs.values() if w.name not in runs.motions]
    for ranks in sorted({run.ranks for _, run in todo}):
        here = [(runs, run) for runs, run in todo if run.ranks == ranks]
        if ranks == 1:
            _run_in(engine, here)
            continue
        try:
            with engine.on_ranks(ranks) as there:
                _run_in(there, here)
        except EngineMissingError as error:
            for runs, run in here:
                runs.motions[run.name] = str(error)


def _run_in(engine: Engine, todo: Sequence[tuple[TrialRuns, TransformedRun]]) -> None:
    """Run in an engine and keep the motions; a reason where it refuses one."""
    runnable = []
    for runs, run in todo:
        reason = engine.refuses(run.job)
        if reason:
            runs.motions[run.name] = reason
        else:
            runnable.append((runs, run))
    outputs = engine.run([run.job for _, run in runnable]) if runnable else []
    for (runs, run), output in zip(runnable, outputs, strict=True):
        runs.motions[run.name] = _motion(output, run.scene)


def _motion(output: Output | EngineError, scene: ContactScene) -> Motion | EngineError:
    try:
        return output if isinstance(output, EngineError) else motion_of(output, scene)
    except EngineError as error:
        return error


def _rows(
    runs: TrialRuns,
    engine: Engine,
    wanted: Callable[[TransformedRun], bool] = lambda run: run.name != PLAIN,
) -> Iterator[Check]:
    """Yield a row for each wanted run; one, with why, where the run as it stands is missing."""
    name, trial = runs.case.name, runs.trial
    head = trial.row_name(name, engine.name)
    cell = Cell(name, trial.submodel, trial.system, engine.name)
    if runs.motion(PLAIN) is None:
        why = runs.motions[PLAIN]
        reason = why if isinstance(why, str) else f"the run as it stands is missing: {why}"
        row = not_tested(f"{head}: invariances", Kind.INVARIANCE, reason)
        yield replace(row, cell=replace(cell, invariance="all"))
        return
    for run in runs.runs.values():
        if wanted(run) and run.judged:
            row = _row(f"{head}: {run.name}", run, runs, engine.traits)
            yield replace(row, cell=replace(cell, invariance=run.name))


def _row(name: str, run: TransformedRun, runs: TrialRuns, traits: Traits) -> Check:
    outcome, expected = runs.motions[run.name], runs.motion(run.against)
    if isinstance(outcome, EngineError):
        row = failed_run(name, Kind.INVARIANCE, outcome, "1")
        return replace(row, engine_died=not isinstance(outcome, EngineNaNError))
    if isinstance(outcome, str):
        return not_tested(name, Kind.INVARIANCE, outcome, "1")
    if expected is None:
        return not_tested(name, Kind.INVARIANCE, f"{run.against!r} is missing", "1")
    sizes = sizes_of(runs, traits)
    if sizes["force"] == 0.0:
        unscaled = "no sample of the run as it stands has a force: differences have no scale"
        return not_tested(name, Kind.INVARIANCE, unscaled, "1")
    width, lost = 0.0, 0.0
    if not run.exact:
        width = round_off_of(run, runs, sizes)
        lost = of_digits(runs, sizes, traits, width)
        unknown = why_not(runs.runs[PLAIN].scene, lost)
        if unknown:
            return not_tested(name, Kind.INVARIANCE, unknown, "1")
    # a prescribed motion begins at touch: whether the dashpot acts there is the rounding's choice
    touch = 1 if runs.runs[PLAIN].scene.segments and not run.exact else 0
    apart = difference(run.back(outcome), runs.runs[run.against].back(expected), sizes, touch)
    worst = max(apart, key=lambda part: np.nan_to_num(apart[part], nan=np.inf))
    whys = (run.why, DIGITS if lost else "")
    tolerance = Tolerance("1", width + lost, 0.0, "; ".join(filter(None, whys)))
    against = repr(run.against) if run.against else "the run as it stands"
    held = f"against {against}; largest difference: {worst}"
    return judge(name, Kind.INVARIANCE, apart[worst], 0.0, tolerance, note=held)


def difference(
    motion: Motion, other: Motion, sizes: Mapping[str, float], touch: int = 0
) -> dict[str, float]:
    """Return the largest difference of each part of two motions, over its size.

    Forces are left out where neither motion tells any, and those of the first ``touch`` samples.
    """
    silent = not motion.tells_forces and not other.tells_forces
    return {
        part: _furthest(motion, other, part, touch if part in FORCES else 0) / sizes[part]
        for part in PARTS
        if not (silent and part in FORCES)
    }


def _furthest(motion: Motion, other: Motion, part: str, first: int) -> float:
    return float(np.max(np.abs(getattr(motion, part)[first:] - getattr(other, part)[first:])))
