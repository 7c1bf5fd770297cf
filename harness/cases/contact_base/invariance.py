"""Runs of contacts that nothing may change: turned, moved, mirrored, restarted, over ranks, ...

Each is held against a run of the same engine, with the same law, step and scheme: no reference is
needed, and what is left is round-off, or nothing.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from harness.cases.contact_base.motion import FORCES, Motion, motion_of
from harness.cases.contact_base.reference import followed, rules_of
from harness.cases.contact_base.scales import rest_overlap
from harness.cases.contact_base.submodels import Trial
from harness.cases.contact_base.tolerances import SINGLE
from harness.cases.contact_base.views import PARTS
from harness.cases.contact_base.ways import (
    MOVED,
    PLAIN,
    ROUNDINGS,
    Way,
    Ways,
    chosen,
    first_ways,
    later_ways,
)
from harness.cases.contract import LevelName, Study
from harness.comparison.tolerances import Tolerance
from harness.comparison.verdicts import Cell, Check, Kind, failed_run, judge, not_tested
from harness.engines.contract import Engine, Output
from harness.engines.traits import Traits
from harness.errors import EngineError, EngineMissingError, EngineNaNError
from harness.parameters.contact_scene import ContactScene

if TYPE_CHECKING:
    from harness.cases.contact_base.contact_case import ContactCase


NO_WIDTH = {
    "mdr": "its force is the difference of an acos and a root, rounded to about eps (R/overlap)^2 "
    "of itself: where a step first touches, no width follows from steps and coordinates"
}
"""Normal laws whose round-off is not that of positions and velocities alone, and why.

theta - sin theta cos theta, cos theta = 1 - x, is off by up to 3 eps / (8 x^2) of itself where
acos(1 - x) and sqrt(2 x - x^2) each round 1 - x; 2 x is the overlap with a flat over the radius.
"""

WRITTEN = "written in single precision: its eps of the room of the bodies, and of speeds"


def invariances(case: ContactCase[Any], engine: Engine, study: Study) -> list[Check]:
    """Return a row for each way to run the trials of a level that must change nothing."""
    level = study.level
    found = [first_ways(case, trial, level) for trial in chosen(case, level)]
    _run(found, engine)
    for one in found:
        one.ways |= {way.name: way for way in later_ways(one, engine, level) if way.ranks == 1}
    _run(found, engine)
    rows = [row for one in found for row in _rows(one, engine)]
    return rows + (_over_ranks(case, engine, study) if level != "quick" else [])


def _over_ranks(case: ContactCase[Any], engine: Engine, study: Study) -> list[Check]:
    """Return the rows of a case on several MPI ranks.

    Those of all cases of a study run together: the start of a process on several ranks costs more
    than the runs in it.
    """
    from harness.cases.contact_base.contact_case import ContactCase

    together = [one for one in study.cases if isinstance(one, ContactCase)] or [case]
    names = tuple(one.name for one in together)
    rows = study.once(
        ("over ranks", engine.name, names), lambda: _all_over_ranks(together, engine, study.level)
    )
    return [row for row in rows if row.cell and row.cell.case == case.name]


def _all_over_ranks(
    cases: Sequence[ContactCase[Any]], engine: Engine, level: LevelName
) -> list[Check]:
    """Return the rows of cases on several MPI ranks, those of one number of ranks run together."""
    found = [
        first_ways(case, trial, level)
        for case in cases
        for trial in chosen(case, level)
        if _most_ranks(case, trial, level) > 1
    ]
    for one in found:
        one.ways = {name: way for name, way in one.ways.items() if name in (PLAIN, MOVED)}
    _run(found, engine)
    for one in found:
        ranks = range(2, _most_ranks(one.case, one.trial, level) + 1)
        one.ways |= {w.name: w for w in later_ways(one, engine, level) if w.ranks in ranks}
    _run(found, engine)
    return [row for one in found for row in _rows(one, engine, lambda way: way.ranks > 1)]


def _most_ranks(case: ContactCase[Any], trial: Trial, level: LevelName) -> int:
    """Return on how many ranks a trial is run: all of them on four at level full."""
    if level == "full":
        return 4
    return 2 if trial.submodel in case.over_ranks else 1


def _run(found: Sequence[Ways], engine: Engine) -> None:
    """Run the ways that have not been run, those of each number of ranks together."""
    todo = [(one, w) for one in found for w in one.ways.values() if w.name not in one.motions]
    for ranks in sorted({way.ranks for _, way in todo}):
        here = [(one, way) for one, way in todo if way.ranks == ranks]
        if ranks == 1:
            _run_in(engine, here)
            continue
        try:
            with engine.on_ranks(ranks) as there:
                _run_in(there, here)
        except EngineMissingError as error:
            for one, way in here:
                one.motions[way.name] = str(error)


def _run_in(engine: Engine, todo: Sequence[tuple[Ways, Way]]) -> None:
    """Run ways in an engine and keep their motions; a reason where it refuses one."""
    runnable = []
    for one, way in todo:
        reason = engine.refuses(way.job)
        if reason:
            one.motions[way.name] = reason
        else:
            runnable.append((one, way))
    outputs = engine.run([way.job for _, way in runnable]) if runnable else []
    for (one, way), output in zip(runnable, outputs, strict=True):
        one.motions[way.name] = _motion(output, way.scene)


def _motion(output: Output | EngineError, scene: ContactScene) -> Motion | EngineError:
    try:
        return output if isinstance(output, EngineError) else motion_of(output, scene)
    except EngineError as error:
        return error


def _rows(
    one: Ways, engine: Engine, wanted: Callable[[Way], bool] = lambda way: way.name != PLAIN
) -> Iterator[Check]:
    """Yield a row for each wanted way; one, with why, where the run as it stands is missing."""
    name, trial = one.case.name, one.trial
    head = f"{name}, {trial.system}: {trial.submodel}, {engine.name}"
    cell = Cell(name, trial.submodel, trial.system, engine.name)
    if one.motion(PLAIN) is None:
        why = one.motions[PLAIN]
        reason = why if isinstance(why, str) else f"the run as it stands is missing: {why}"
        row = not_tested(f"{head}: invariances", Kind.INVARIANCE, reason)
        yield replace(row, cell=replace(cell, invariance="all"))
        return
    for way in one.ways.values():
        if wanted(way) and way.judged:
            row = _row(f"{head}: {way.name}", way, one, engine.traits)
            yield replace(row, cell=replace(cell, invariance=way.name))


def _row(name: str, way: Way, one: Ways, traits: Traits) -> Check:
    """Return the verdict on a way in an engine of these traits."""
    found, expected = one.motions[way.name], one.motion(way.against)
    if isinstance(found, EngineError):
        row = failed_run(name, Kind.INVARIANCE, found, "1")
        return replace(row, engine_died=not isinstance(found, EngineNaNError))
    if isinstance(found, str):
        return not_tested(name, Kind.INVARIANCE, found, "1")
    if expected is None:
        return not_tested(name, Kind.INVARIANCE, f"{way.against!r} is missing", "1")
    unknown = "" if way.exact else NO_WIDTH.get(one.trial.parameters.normal, "")
    if unknown:
        return not_tested(name, Kind.INVARIANCE, unknown, "1")
    sizes = _sizes(one, traits)
    apart = difference(way.back(found), one.ways[way.against].back(expected), sizes)
    worst = max(apart, key=lambda part: np.nan_to_num(apart[part], nan=np.inf))
    single = traits.digits <= SINGLE and not way.exact
    width = 0.0 if way.exact else _width(way, one, sizes, single=single)
    tolerance = Tolerance("1", width, 0.0, f"{way.why}; {WRITTEN}" if single else way.why)
    against = repr(way.against) if way.against else "the run as it stands"
    held = f"against {against}; largest difference: {worst}"
    return judge(name, Kind.INVARIANCE, apart[worst], 0.0, tolerance, note=held)


def difference(one: Motion, other: Motion, sizes: Mapping[str, float]) -> dict[str, float]:
    """Return the largest difference of each part of two motions, over its size.

    Forces are left out where neither motion tells any.
    """
    silent = not one.tells_forces and not other.tells_forces
    return {
        part: float(np.max(np.abs(getattr(one, part) - getattr(other, part)))) / sizes[part]
        for part in PARTS
        if not (silent and part in FORCES)
    }


def _sizes(one: Ways, traits: Traits) -> dict[str, float]:
    """Return what differences are measured in: overlap, speed of the contact, largest force.

    The overlap is that of the largest force at rest, the speed at least what moves by it in
    the time of a contact; both with the radius as the lever. A force that a code does not tell is
    that of the law.
    """
    motion, law, plain = one.motion(PLAIN), one.trial.parameters, one.ways[PLAIN]
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


def _width(way: Way, one: Ways, sizes: Mapping[str, float], *, single: bool) -> float:
    """Return the part of the sizes that round-off may change, ``single`` where it is written."""
    motion, scene = one.motion(PLAIN), one.ways[PLAIN].scene
    assert motion is not None
    far = float(np.abs(motion.position).max()) + way.drift * scene.duration + way.reach
    fast = float(np.abs(motion.velocity).max()) + way.drift
    rounded = far / sizes["position"] + fast / sizes["velocity"]
    width = ROUNDINGS * scene.steps * float(np.finfo(float).eps) * rounded
    if single:
        room = float(one.ways[PLAIN].job.values["room"])
        shown = room / sizes["position"] + fast / sizes["velocity"]
        width += ROUNDINGS * float(np.finfo(np.float32).eps) * shown
    return width
