"""Failures explained: rows of known defects, defects that are gone, conventions that would pass.

Rows that share the scenes of their jobs are one run. Where one of them fails, the reference is run
with the switch of each defect that may act there. The run has a defect where all its rows that are
held against other codes hold with the switch. A row without a scene can only have the error of a
defect, or one that is undetermined.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

from harness.cases.base import Check
from harness.cases.bench import Bench
from harness.cases.checks import Explain, row_in
from harness.engines.base import Job
from harness.engines.jobs import cores, parallel_map
from harness.engines.scene_tables import motion_in
from harness.errors import EngineError, Unsupported
from harness.model.motion import Motion
from harness.model.scene import Scene
from harness.results.defect_switches import passing_rules
from harness.results.defects import (
    KnownDefect,
    Motions,
    Trial,
    error_defect,
    explanation,
)
from harness.results.rows import NAN, Failure, Kind, Row, Verdict, joined
from harness.store.committed import known_defects

__all__ = ["explained", "known_defects"]

Key = tuple[str, str, str, str, str]
SEARCH_LIMIT = 100_000  # steps times bodies of a scene beyond which no convention is searched


def explained(defects: Sequence[KnownDefect], version: str) -> Explain:
    """Return the function that marks rows of an engine's release.

    A failing row becomes a known defect, or is not tested where the defect is undetermined; a row
    that passes without a defect of the release is fixed. The note of any other failure names the
    single conventions under which its run would hold.
    """

    def explain(bench: Bench, checks: Sequence[Check], rows: Sequence[Row]) -> list[Row]:
        relevant = [d for d in defects if d.engine == bench.name]
        runs = _runs(bench, checks, rows, relevant, version)
        marked = list(rows)
        for run, found in zip(runs, parallel_map(_Run.marked, runs, cores()), strict=True):
            for place, row in zip(run.places, found, strict=True):
                marked[place] = row
        return marked

    return explain


@dataclass(frozen=True)
class _Run:
    """The rows of checks that share their scenes, by their place among all rows."""

    bench: Bench
    places: Sequence[int]
    checks: Sequence[Check]
    rows: Sequence[Row]
    jobs: tuple[Job, ...]  # with scenes; none of checks without a scene
    defects: Sequence[KnownDefect]  # that may act here

    def marked(self) -> list[Row]:
        """Return the rows, marked."""
        if any(row.verdict is Verdict.FAIL for row in self.rows):
            return self._explained()
        fixed = self._fixed() if self.defects and self.trial is not None else {}
        return [_gone(row, fixed[row.key]) if row.key in fixed else row for row in self.rows]

    def _explained(self) -> list[Row]:
        dead = [row for row in self.rows if row.verdict is Verdict.FAIL and math.isnan(row.value)]
        if dead:
            return [self._died(row) if row in dead else row for row in self.rows]
        undetermined = next((d for d in self.defects if d.undetermined), None)
        defect = (explanation(self.defects, self.trial) if self.trial else None) or undetermined
        if defect is None:
            passing = self._passing_rules()
            return [_with_note(row, passing) if self._decides(row) else row for row in self.rows]
        return [_marked(row, defect) if self._is_of_run(row) else row for row in self.rows]

    def _died(self, row: Row) -> Row:
        defect = error_defect(self.defects, row.note)
        return row if defect is None else _marked(row, defect)

    def _fixed(self) -> dict[Key, KnownDefect]:
        """Return the rows that show that a defect is gone, by key: its switch would move them."""
        assert self.trial is not None
        fixed: dict[Key, KnownDefect] = {}
        for defect in self.defects:
            motions = self.trial.motions((defect,)) if defect.switched else None
            for row in filter(self._decides, self.rows):
                moved = motions is not None and not self._holds(motions, only=row)
                if moved or defect.error:
                    fixed.setdefault(row.key, defect)
        return fixed

    def _decides(self, row: Row) -> bool:
        """Return whether a row decides what its run has: it is judged against other codes."""
        return row.kind is Kind.CROSS_CODE and row.verdict in (Verdict.PASS, Verdict.FAIL)

    def _is_of_run(self, row: Row) -> bool:
        """Return whether the explanation of the run is one of a row.

        A closed form is missed by a defect too, where the same quantity fails against other codes.
        """
        if self.trial is None or row.kind is Kind.CROSS_CODE:
            return row.verdict is Verdict.FAIL
        failing = [r for r in self.rows if self._decides(r) and r.verdict is Verdict.FAIL]
        return row.verdict is Verdict.FAIL and row.quantity in {r.quantity for r in failing}

    # ---- the reference with other motions

    @cached_property
    def trial(self) -> Trial | None:
        """Return the run as a trial, None without a scene or a row that decides."""
        scenes = [self.bench.engine.scene_of(job) for job in self.jobs]
        if not scenes or not any(map(self._decides, self.rows)):
            return None
        try:
            rules = {scene: self.bench.rules(scene) for scene in scenes}
        except Unsupported:
            return None
        return Trial(rules, self._holds, self._motion(scenes[0]) if len(rules) == 1 else None)

    def _holds(self, motions: Motions, only: Row | None = None) -> bool:
        bench = self.bench.substituting(motions)
        for check, row in zip(self.checks, self.rows, strict=True):
            chosen = self._decides(row) if only is None else row is only
            if chosen and row_in(bench, check, _blank(row)).verdict is not Verdict.PASS:
                return False
        return True

    def _motion(self, scene: Scene) -> Motion | None:
        """Return the motion of the engine, None of a job whose output has no samples of it."""
        try:
            return motion_in(self.bench.output(self.jobs[0]), scene)
        except EngineError:
            return None

    def _passing_rules(self) -> str:
        if self.trial is None or len(self.trial.rules) != 1:
            return ""
        ((scene, rules),) = self.trial.rules.items()
        if scene.steps * len(scene.bodies) > SEARCH_LIMIT:
            return ""
        found = passing_rules(scene, rules, lambda motion: self._holds({scene: motion}))
        return f"passes under {', or under '.join(found)}" if found else ""


def _runs(
    bench: Bench,
    checks: Sequence[Check],
    rows: Sequence[Row],
    defects: Sequence[KnownDefect],
    version: str,
) -> list[_Run]:
    """Return the runs that checks share; a check without a scene is one by itself."""
    groups: dict[object, list[int]] = {}
    for place, check in enumerate(checks):
        keys = tuple((job.scene, job.values.get("variation")) for job in _scene_jobs(check))
        groups.setdefault(keys or place, []).append(place)
    runs = []
    for places in groups.values():
        chosen = [rows[place] for place in places]
        dated = [replace(row, version=version) for row in chosen]
        acting = [d for d in defects if any(map(d.concerns, dated))]
        chosen_checks = [checks[place] for place in places]
        jobs = _scene_jobs(chosen_checks[0])
        runs.append(_Run(bench, places, chosen_checks, chosen, jobs, acting))
    return runs


def _scene_jobs(check: Check) -> tuple[Job, ...]:
    return tuple(job for job in check.jobs if job.scene is not None)


def _blank(row: Row) -> Row:
    """Return the row before it was measured and judged."""
    return replace(row, value=NAN, uncertainty=0.0, expected=NAN, tolerance=NAN, note="", defect="")


def _marked(row: Row, defect: KnownDefect) -> Row:
    verdict = Verdict.NOT_TESTED if defect.undetermined else Verdict.KNOWN_DEFECT
    note = joined(defect.undetermined, defect.note, row.note)
    return replace(row, verdict=verdict, failure=Failure.NONE, defect=defect.name, note=note)


def _gone(row: Row, defect: KnownDefect) -> Row:
    note = joined(f"no longer there: {defect.note}", row.note)
    return replace(row, verdict=Verdict.FIXED, defect=defect.name, note=note)


def _with_note(row: Row, note: str) -> Row:
    return replace(row, note=joined(row.note, note)) if row.verdict is Verdict.FAIL else row
