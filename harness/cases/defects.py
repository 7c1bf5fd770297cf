"""Failures explained: rows of known defects, defects that are gone, conventions that would pass.

Rows that share the scenes of their jobs are one run. Where one of them fails, the reference is run
with the switch of each defect that may act there. The run has a defect where all its rows that are
compared with other codes hold with the switch. A row without a scene can only have the error of a
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
from harness.engines.process import cores, parallel_map
from harness.errors import EngineError, Unsupported
from harness.model.scene import Motion
from harness.results.defects import KnownDefect, Motions, Trial, error_defect, explanation
from harness.results.rows import NAN, Failure, Kind, Row, Verdict, joined
from harness.results.switches import passing_rules

Key = tuple[str, str, str, str, str]
SEARCH_LIMIT = 100_000  # steps times bodies of a scene beyond which no convention is searched


def explained(defects: Sequence[KnownDefect], version: str) -> Explain:
    """Return the function that marks rows of an engine's release.

    A failing row becomes a known defect, or is not tested where the defect is undetermined; a row
    that passes without a defect of the release is fixed. The note of any other failure names the
    single conventions under which its run would hold.
    """

    def explain(bench: Bench, checks: Sequence[Check], rows: Sequence[Row]) -> list[Row]:
        groups: dict[object, list[int]] = {}  # of a run; a check without a scene is one by itself
        for place, check in enumerate(checks):
            variations = [(job.scene, job.values.get("variation")) for job in _scene_jobs(check)]
            groups.setdefault(tuple(variations) or place, []).append(place)
        runs = [
            _Run(bench, [checks[p] for p in places], [rows[p] for p in places], defects, version)
            for places in groups.values()
        ]
        marked = list(rows)
        results = parallel_map(_Run.marked, runs, cores())
        for places, run in zip(groups.values(), results, strict=True):
            for place, row in zip(places, run, strict=True):
                marked[place] = row
        return marked

    return explain


@dataclass(frozen=True)
class _Run:
    """The rows of checks that share their scenes."""

    bench: Bench
    checks: Sequence[Check]
    rows: Sequence[Row]
    candidates: Sequence[KnownDefect]
    version: str

    @cached_property
    def defects(self) -> list[KnownDefect]:
        """The defects that may act in a row."""
        places = {(row.setup, row.check): row for row in self.rows}.values()
        rows = [replace(row, version=self.version) for row in places]
        return [defect for defect in self.candidates if any(map(defect.concerns, rows))]

    @cached_property
    def jobs(self) -> tuple[Job, ...]:
        return _scene_jobs(self.checks[0])

    def marked(self) -> list[Row]:
        if any(row.verdict is Verdict.FAIL for row in self.rows):
            return self._explained()
        fixed = self._fixed() if self.defects and self.trial is not None else {}
        return [_gone(row, fixed[row.key]) if row.key in fixed else row for row in self.rows]

    def _explained(self) -> list[Row]:
        dead = [row for row in self.rows if row.verdict is Verdict.FAIL and math.isnan(row.value)]
        if dead:
            causes = {row.key: error_defect(self.defects, row.note) for row in dead}
            return [_marked(row, causes.get(row.key)) for row in self.rows]
        undetermined = next((d for d in self.defects if d.undetermined), None)
        defect = (explanation(self.defects, self.trial) if self.trial else None) or undetermined
        if defect is not None:
            return [_marked(row, defect if self._is_of_run(row) else None) for row in self.rows]
        passing, failing = self._passing_rules(), {row.key for row in self._failing}
        return [
            replace(row, note=joined(row.note, passing)) if row.key in failing else row
            for row in self.rows
        ]

    def _fixed(self) -> dict[Key, KnownDefect]:
        """Return the rows that show that a defect is gone, by key: its switch would move them."""
        assert self.trial is not None
        fixed: dict[Key, KnownDefect] = {}
        for defect in self.defects:
            motions = self.trial.motions((defect,)) if defect.switched else None
            bench = None if motions is None else self.bench.substituting(motions)
            for check, row in self.deciding:
                if defect.error or (bench is not None and not _passes(bench, check, row)):
                    fixed.setdefault(row.key, defect)
        return fixed

    @cached_property
    def deciding(self) -> list[tuple[Check, Row]]:
        """The checks with rows that decide about the run: they are judged against other codes."""
        pairs = zip(self.checks, self.rows, strict=True)
        judged = (Verdict.PASS, Verdict.FAIL)
        return [(c, r) for c, r in pairs if r.kind is Kind.CROSS_CODE and r.verdict in judged]

    @property
    def _failing(self) -> list[Row]:
        return [row for _, row in self.deciding if row.verdict is Verdict.FAIL]

    def _is_of_run(self, row: Row) -> bool:
        """Return whether the explanation of the run is one of a row.

        A closed form is missed by a defect too, where the same quantity fails against other codes.
        """
        if row.verdict is not Verdict.FAIL or self.trial is None or row.kind is Kind.CROSS_CODE:
            return row.verdict is Verdict.FAIL
        return row.quantity in {failing.quantity for failing in self._failing}

    # ---- the reference with other motions

    @cached_property
    def trial(self) -> Trial | None:
        """The run as a trial, None without a scene or a row that decides."""
        scenes = [self.bench.engine.scene_of(job) for job in self.jobs]
        if not scenes or not self.deciding:
            return None
        try:
            rules = {scene: self.bench.rules(scene) for scene in scenes}
        except Unsupported:
            return None
        return Trial(rules, self._holds, self._motion() if len(rules) == 1 else None)

    def _holds(self, motions: Motions) -> bool:
        bench = self.bench.substituting(motions)
        return all(_passes(bench, check, row) for check, row in self.deciding)

    def _motion(self) -> Motion | None:
        """Return the motion of the engine, None of a job whose output has no samples of it."""
        try:
            return self.bench.motion(self.jobs[0])
        except EngineError:
            return None

    def _passing_rules(self) -> str:
        if self.trial is None or len(self.trial.rules) != 1:
            return ""
        ((scene, rules),) = self.trial.rules.items()
        if scene.steps * len(scene.bodies) > SEARCH_LIMIT:
            return ""
        names = passing_rules(scene, rules, lambda motion: self._holds({scene: motion}))
        return f"passes under {', or under '.join(names)}" if names else ""


def _scene_jobs(check: Check) -> tuple[Job, ...]:
    return tuple(job for job in check.jobs if job.scene is not None)


def _passes(bench: Bench, check: Check, row: Row) -> bool:
    blank = replace(
        row, value=NAN, uncertainty=0.0, expected=NAN, tolerance=NAN, note="", defect=""
    )
    return row_in(bench, check, blank).verdict is Verdict.PASS


def _marked(row: Row, defect: KnownDefect | None) -> Row:
    if defect is None:
        return row
    verdict = Verdict.NOT_TESTED if defect.undetermined else Verdict.KNOWN_DEFECT
    note = joined(defect.undetermined, defect.note, row.note)
    return replace(row, verdict=verdict, failure=Failure.NONE, defect=defect.name, note=note)


def _gone(row: Row, defect: KnownDefect) -> Row:
    note = joined(f"no longer there: {defect.note}", row.note)
    return replace(row, verdict=Verdict.FIXED, defect=defect.name, note=note)
