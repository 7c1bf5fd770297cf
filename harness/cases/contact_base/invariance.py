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
from harness.cases.contact_base.predictions import PredictedDifference
from harness.cases.contact_base.reference import rules_of
from harness.cases.contact_base.rounding import why_not
from harness.cases.contact_base.submodels import Trial
from harness.cases.contact_base.tolerances import SINGLE
from harness.cases.contact_base.views import PARTS
from harness.cases.contact_base.ways import (
    MOVED,
    PLAIN,
    Way,
    Ways,
    chosen,
    first_ways,
    later_ways,
)
from harness.cases.contact_base.widths import of_digits, of_way, sizes_of
from harness.cases.contract import LevelName, Study
from harness.comparison.tolerances import Tolerance
from harness.comparison.verdicts import Cell, Check, Kind, failed_run, judge, not_tested
from harness.engines.contract import Engine, Output
from harness.engines.traits import Traits
from harness.errors import EngineError, EngineMissingError, EngineNaNError
from harness.parameters.contact_scene import ContactScene

if TYPE_CHECKING:
    from harness.cases.contact_base.contact_case import ContactCase


DIGITS = "mdr's force, a difference, loses digits at small overlaps: what its steps add up to"
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
    sizes = sizes_of(one, traits)
    single = traits.digits <= SINGLE and not way.exact
    width, lost = 0.0, 0.0
    if not way.exact:
        width = of_way(way, one, sizes, single=single)
        lost = of_digits(one, sizes, traits, width)
        unknown = why_not(one.ways[PLAIN].scene, lost)
        if unknown:
            return not_tested(name, Kind.INVARIANCE, unknown, "1")
    # a prescribed motion begins at touch: whether the dashpot acts there is the rounding's choice
    touch = 1 if one.ways[PLAIN].scene.segments and not way.exact else 0
    apart = difference(way.back(found), one.ways[way.against].back(expected), sizes, touch)
    worst = max(apart, key=lambda part: np.nan_to_num(apart[part], nan=np.inf))
    whys = (way.why, WRITTEN if single else "", DIGITS if lost else "")
    tolerance = Tolerance("1", width + lost, 0.0, "; ".join(filter(None, whys)))
    against = repr(way.against) if way.against else "the run as it stands"
    held = f"against {against}; largest difference: {worst}"
    row = judge(name, Kind.INVARIANCE, apart[worst], 0.0, tolerance, note=held)
    two = (way, one.ways[way.against], rules_of(way.job, traits))
    predict = PredictedDifference(*two, sizes, width + lost, touch, difference)
    return replace(row, predict=predict)


def difference(
    one: Motion, other: Motion, sizes: Mapping[str, float], touch: int = 0
) -> dict[str, float]:
    """Return the largest difference of each part of two motions, over its size.

    Forces are left out where neither motion tells any, and those of the first ``touch`` samples.
    """
    silent = not one.tells_forces and not other.tells_forces
    return {
        part: _furthest(one, other, part, touch if part in FORCES else 0) / sizes[part]
        for part in PARTS
        if not (silent and part in FORCES)
    }


def _furthest(one: Motion, other: Motion, part: str, first: int) -> float:
    return float(np.max(np.abs(getattr(one, part)[first:] - getattr(other, part)[first:])))
