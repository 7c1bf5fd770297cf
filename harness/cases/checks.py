"""Run checks: exactly one row of each, whatever happens; and explain those that fail.

A job that the engine refuses, or a run that ends undecided: not tested, with the reason. An
engine's error: a failed row with its log. Any other error: a harness error.

Rows that share the scenes of their jobs are one run. Where one of them fails, the reference is run
with the switch of each defect that may act there. The run has a defect where all its rows that are
compared with other codes hold with the switch. A search, which runs more scenes than its first
ones, has the defect with which the reference gives its value. A row without a scene can only have
the error of a defect, or one that is undetermined. Such a one excuses no row that is off by more
than its size, if that is known, and the row says that it hides other faults.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from harness.cases.base import LEVELS, Case, CaseError, Check, Level, Quantity, Value
from harness.cases.bench import Bench, output_of
from harness.engines.base import Engine, Job, Output
from harness.engines.process import cores, parallel_map
from harness.errors import (
    EngineError,
    EngineInputError,
    EngineLostAtomsError,
    EngineMemoryError,
    EngineMissingError,
    EngineNaNError,
    EngineOutputError,
    EngineTimeoutError,
    EngineUndecidedError,
    Unsupported,
)
from harness.model.base import Parameters
from harness.results.defects import (
    NO_MOTION,
    KnownDefect,
    Motions,
    Trial,
    error_defect,
    explanation,
)
from harness.results.rows import (
    Failure,
    Kind,
    Row,
    Tolerance,
    Verdict,
    failed,
    joined,
    judge,
    matches,
    not_tested,
)

if TYPE_CHECKING:
    from harness.model.scene import Motion, Scene

P = TypeVar("P", bound=Parameters)
Values = Callable[["Motion"], Mapping[str, float]]  # the quantities of a motion
Key = tuple[str, str, str, str, str]  # of a row
ROUND_OFF = 1e-9  # of the scale of a quantity
SAME_VALUE = 1e-8  # of the value of a search: the round-off of its runs
REASON = "both take the same steps: what differs is round-off, or a fault"
FULL_DIGITS = 15  # from which on what is cut is round-off
DIGIT_DRAWS = 8
SEARCH_LIMIT = 100_000  # steps times bodies of a scene beyond which no convention is searched
FAILURES: tuple[tuple[type[EngineError], Failure], ...] = (
    (EngineTimeoutError, Failure.TIMEOUT),
    (EngineMemoryError, Failure.MEMORY),
    (EngineNaNError, Failure.NOT_A_NUMBER),
    (EngineLostAtomsError, Failure.ENGINE),  # a kind of refused input
    (EngineInputError, Failure.WRONG_INPUT),
    (EngineError, Failure.ENGINE),
)


def selected(case: str, checks: Iterable[Check], level: Level, only: str = "*") -> list[Check]:
    """Return the checks of a level whose ``case/setup/quantity`` matches a pattern."""
    return [
        check
        for check in checks
        if runs_at(check.level, level) and matches(f"{case}/{check.setup}/{check.quantity}", only)
    ]


def runs_at(shortest: Level, level: Level) -> bool:
    """Return whether a level runs what a shorter one does."""
    return LEVELS.index(shortest) <= LEVELS.index(level)


def run_checks(
    case: str,
    checks: Sequence[Check],
    bench: Bench,
    *,
    version: str = "",
    defects: Sequence[KnownDefect] | None = None,
) -> list[Row]:
    """Return the row of each check, in order. Raise ValueError for two checks of one key.

    With known ``defects`` a failing row has those that explain it, or is not tested where one of
    them is undetermined; a row that passes without a defect of the release is fixed. The note of
    any other failure names the single conventions under which its run would hold.
    """
    keys = Counter((check.setup, check.quantity, check.check) for check in checks)
    for key, count in keys.items():
        if count > 1:
            raise ValueError(f"case {case!r}: two checks {' / '.join(key)}")
    refusals = [next(filter(None, map(bench.refusal, check.jobs)), "") for check in checks]
    pairs = zip(checks, refusals, strict=True)
    if jobs := [job for check, refusal in pairs if not refusal for job in check.jobs]:
        bench.prepare(jobs)

    def row_of(place: int) -> Row:
        check = checks[place]
        blank = Row(
            case=case,
            setup=check.setup,
            quantity=check.quantity,
            engine=bench.name,
            check=check.check,
            version=version,
            unit=check.unit,
            kind=check.kind,
            level=check.level,
            inputs=bench.inputs_digest(check.jobs),
        )
        if refusals[place]:
            return not_tested(blank, refusals[place])
        return row_in(bench, check, blank)

    rows = parallel_map(row_of, range(len(checks)), cores())
    rows = rows if defects is None else _explained(bench, checks, rows, defects)
    bench.rows[case] += rows
    return rows


def row_in(bench: Bench, check: Check, blank: Row) -> Row:
    """Return the row of a check: measured, expected and judged."""
    try:
        value = Value.of(check.measure(bench))
        expected = check.expected(bench) if callable(check.expected) else check.expected
        tolerance = check.tolerance(bench) if callable(check.tolerance) else check.tolerance
    except Exception as error:  # a case of a plug-in may raise anything
        return error_row(blank, error)
    note = joined(check.note, value.note)
    row = replace(
        blank, value=value.value, uncertainty=value.uncertainty, expected=expected, note=note
    )
    return judge(row, tolerance, failure=value.failure)


def error_row(blank: Row, error: Exception) -> Row:
    """Return the row of an error: not tested, a run that failed, or an error of the harness."""
    if isinstance(error, Unsupported | EngineMissingError | EngineUndecidedError):
        return not_tested(blank, str(error))
    if isinstance(error, EngineError):
        failure = next(failure for kind, failure in FAILURES if isinstance(error, kind))
        return failed(blank, failure, f"{error.kind}: {error}", error.log)
    text = str(error) if isinstance(error, CaseError) else f"{type(error).__name__}: {error}"
    return failed(blank, Failure.HARNESS, text)


# ---- checks at equal steps: each quantity of a run against the reference's


def equal_steps_check(
    quantity: Quantity[Any],
    values: Callable[[Bench], Mapping[str, float]],
    expected: Callable[[Bench], Mapping[str, float]],
    tolerance: Tolerance | Callable[[Bench], Tolerance],
    *,
    exact: float | None,
    **fields: Any,
) -> Check:
    """Return the check of a quantity among the values of a run, each computed once in a bench.

    ``fields`` are more of the check. The note has the error of the step where there is an
    ``exact`` value. A value that needs forces which an engine does not write is not tested.
    """
    name, jobs = quantity.name, fields.get("jobs", ())

    def measure(bench: Bench) -> Value:
        try:
            value = bench.once(values, bench)[name]
        except EngineOutputError:
            if why := bench.unwritten(jobs):
                raise Unsupported(why) from None
            raise
        if math.isnan(value) and (why := bench.unwritten(jobs)):
            raise Unsupported(why)
        if exact is None:
            return Value(value)
        error = bench.once(expected, bench)[name] - exact
        return Value(value, note=f"error of the step {error:.2g} (closed form {exact:.9g})")

    return Check(
        quantity=name,
        unit=quantity.unit,
        measure=measure,
        expected=lambda bench: bench.once(expected, bench)[name],
        tolerance=tolerance,
        **fields,
    )


def with_digits(tolerance: Tolerance, unit: float, bench: Bench) -> Tolerance:
    """Return a tolerance with the error of the digits that an engine writes, times ``unit``."""
    digits = bench.engine.traits.digits
    error = 1.25 * 10.0 ** (1 - digits) * unit
    if error <= 0.1 * tolerance.absolute:
        return tolerance
    return Tolerance(tolerance.absolute + error, reason=f"{tolerance.reason}; {digits} digits")


def equal_steps_tolerance(
    values: Values, scene: Scene | None, name: str, size: float, bench: Bench
) -> Tolerance:
    """Return round-off of the ``size`` of a quantity, and what the engine's digits hide of it.

    ``values`` returns the quantities of a motion. A difference of two large numbers loses more
    than their last digit: how much is measured on the reference's motion of the ``scene``.
    """
    plain = Tolerance(ROUND_OFF * size, reason=REASON)
    digits = bench.engine.traits.digits
    if scene is None or digits >= FULL_DIGITS:
        return with_digits(plain, size, bench)
    lost = bench.once(_digit_errors, values, scene, bench)[name]
    return with_digits(plain, max(size, lost / 10.0 ** (1 - digits)), bench)


def _digit_errors(values: Values, scene: Scene, bench: Bench) -> dict[str, float]:
    """Return the largest errors of quantities where all numbers have the engine's digits.

    In each draw every number is off by half its last digit, up or down at random.
    """
    motion = bench.reference(scene)
    half, signs = 0.5 * 10.0 ** (1 - bench.engine.traits.digits), np.random.default_rng(0)
    expected = values(motion)
    errors = dict.fromkeys(expected, 0.0)
    for _ in range(DIGIT_DRAWS):
        changed = {
            name: numbers * (1.0 + half * signs.choice((-1.0, 1.0), numbers.shape))
            for name, numbers in vars(motion).items()
            if name != "time" and numbers is not None
        }
        with suppress(EngineOutputError):  # so few digits may not show the contact
            for name, value in values(replace(motion, **changed)).items():
                errors[name] = max(errors[name], abs(value - expected[name]))
    return errors


def equal_steps_checks(
    case: Case[P],
    engine: Engine,  # noqa: ARG001 - all checks of a case are of an engine
    setups: Mapping[str, P],
    level: Level = "quick",
) -> Iterator[Check]:
    """Yield a check of each quantity of one run in each setup, by the name of the setup.

    The tolerance is a part of the quantity's scale, and the last digit of the engine's output.
    """
    for setup, parameters in setups.items():
        job, exact = case.job(parameters), case.exact(parameters)
        values, expected = partial(_measured, case, parameters), partial(case.reference, parameters)
        scene = case.scene(parameters)
        of_motion = partial(_measured_motion, case, parameters, scene)
        for quantity in case.quantities:
            if not quantity.varies:  # a search of several runs
                yield equal_steps_check(
                    quantity,
                    values,
                    expected,
                    partial(
                        equal_steps_tolerance,
                        of_motion,
                        scene,
                        quantity.name,
                        quantity.size(parameters),
                    ),
                    exact=exact.get(quantity.name),
                    setup=setup,
                    level=level,
                    jobs=(job,),
                )


def _measured(case: Case[P], parameters: P, bench: Bench) -> Mapping[str, float]:
    return case.measure(parameters, bench.output(case.job(parameters)))


def _measured_motion(
    case: Case[P], parameters: P, scene: Scene | None, motion: Motion
) -> Mapping[str, float]:
    return {} if scene is None else case.measure(parameters, output_of(motion, scene))


# ---- failures explained: known defects, defects that are gone, conventions that would pass


def _explained(
    bench: Bench, checks: Sequence[Check], rows: Sequence[Row], defects: Sequence[KnownDefect]
) -> list[Row]:
    groups: dict[object, list[tuple[Check, Row]]] = {}  # of a run; alone without a scene
    for check, row in zip(checks, rows, strict=True):
        scenes = [(j.scene, j.values.get("variation")) for j in check.jobs if j.scene is not None]
        groups.setdefault(tuple(scenes) or row.key, []).append((check, row))
    runs = []
    for group in groups.values():
        alike = {(row.setup, row.check): row for _, row in group}.values()
        acting = [defect for defect in defects if any(map(defect.concerns, alike))]
        acting = [d for d in acting if d.is_in_program(bench.engine.identify().how)]
        runs.append(_Run(bench, group, acting))
    marked = {row.key: row for run in parallel_map(_Run.marked, runs, cores()) for row in run}
    return [marked[row.key] for row in rows]


@dataclass(frozen=True)
class _Run:
    """The checks and rows that share their scenes, with the defects that may act in one of them."""

    bench: Bench
    judged: Sequence[tuple[Check, Row]]
    defects: Sequence[KnownDefect]

    @cached_property
    def rows(self) -> list[Row]:
        return [row for _, row in self.judged]

    @cached_property
    def deciding(self) -> list[tuple[Check, Row]]:
        """The checks with rows that decide about the run: they are judged against other codes."""
        verdicts = (Verdict.PASS, Verdict.FAIL)
        return [
            (check, row)
            for check, row in self.judged
            if row.kind is Kind.CROSS_CODE and row.verdict in verdicts
        ]

    def marked(self) -> list[Row]:
        failing = [row for row in self.rows if row.verdict is Verdict.FAIL]
        if not failing:
            return self._fixed()
        if any(row.failure is Failure.HARNESS for row in failing):
            return self.rows  # an error of this package is no defect of the engine
        if dead := [row for row in failing if math.isnan(row.value)]:
            errors = {row.key: error_defect(self.defects, row.note) for row in dead}
            return self._marked({key: (defect,) for key, defect in errors.items() if defect})
        defects = explanation(self.defects, self.trial) if self.trial else ()
        defects = defects or tuple(filter(self._is_given_by, self.defects))[:1]
        defects = defects or next(filter(None, map(self._hidden_by, self.defects)), ())
        deciding = {row.key: row.quantity for _, row in self.deciding if row in failing}
        if not defects:
            passing = self._passing_rules()
            return [
                replace(row, note=joined(row.note, passing)) if row.key in deciding else row
                for row in self.rows
            ]
        # a closed form is missed by a defect where its quantity fails against other codes, too
        explained = [
            row
            for row in failing
            if row.kind is Kind.CROSS_CODE or not self.trial or row.quantity in deciding.values()
        ]
        return self._marked({row.key: defects for row in explained})

    def _marked(self, causes: Mapping[Key, Sequence[KnownDefect]]) -> list[Row]:
        rows = []
        for row in self.rows:
            if defects := causes.get(row.key):
                open_ = any(defect.undetermined for defect in defects)
                row = replace(
                    row,
                    verdict=Verdict.NOT_TESTED if open_ else Verdict.KNOWN_DEFECT,
                    failure=Failure.NONE,
                    defect=", ".join(defect.name for defect in defects),
                    note=joined(*(defect.note for defect in defects), row.note),
                )
            rows.append(row)
        return rows

    def _hidden_by(self, defect: KnownDefect) -> tuple[KnownDefect, ...]:
        """Return an undetermined defect whose size the rows have, with those next to it."""
        if not defect.undetermined:
            return ()
        rows = [row for _, row in self.deciding or self.judged if row.verdict is Verdict.FAIL]
        size = defect.largest
        if size is None or all(abs(row.difference) <= size * row.tolerance for row in rows):
            return (defect,)
        trial = self.trial and replace(self.trial, holds=partial(self._holds, size=size))
        others = explanation(self.defects, trial) if trial else ()
        return (defect, *others) if others else ()

    def _fixed(self) -> list[Row]:
        """Mark the rows that show that a defect is gone: its switch would move them."""
        gone: dict[Key, KnownDefect] = {}
        for defect in self.defects:
            gone = dict.fromkeys(self._moved_by(defect), defect) | gone
        rows = []
        for row in self.rows:
            if fixed := gone.get(row.key):
                note = joined(f"no longer there: {fixed.note}", row.note)
                row = replace(row, verdict=Verdict.FIXED, defect=fixed.name, note=note)
            rows.append(row)
        return rows

    def _moved_by(self, defect: KnownDefect) -> list[Key]:
        """Return the keys of the rows that fail with a defect."""
        if self.trial is None or defect.command or not (defect.error or defect.switched):
            return []
        if defect.error:
            return [row.key for _, row in self.deciding]
        try:
            if not self.trial.is_changed_by(defect):
                return []
            bench = self.bench.substituting(self.trial.motions((defect,)))
        except NO_MOTION:
            return []
        return [row.key for check, row in self.deciding if not _passes(bench, check, row)]

    @cached_property
    def trial(self) -> Trial | None:
        """The run as a trial, None without a scene or a row that decides."""
        jobs = [job for job in self.judged[0][0].jobs if job.scene is not None]
        if not jobs or not self.deciding:
            return None
        try:
            scenes = map(self.bench.engine.scene_of, jobs)
            rules = {scene: self.bench.rules(scene) for scene in scenes}
        except Unsupported:
            return None
        motion = None
        if len(rules) == 1:
            with suppress(EngineError):  # of a job whose output has no samples
                motion = self.bench.motion(jobs[0])
        return Trial(rules, self._holds, motion)

    def _holds(self, motions: Motions, size: float = 1.0) -> bool:
        bench = self.bench.substituting(motions)
        return all(_passes(bench, check, row, size) for check, row in self.deciding)

    def _is_given_by(self, defect: KnownDefect) -> bool:
        """Return whether the reference gives the values that fail, with a switch and only so."""

        def gives(*defects: KnownDefect) -> bool:
            bench = _ReferenceBench(self.bench.engine, defects)
            failing = [pair for pair in self.judged if pair[1].verdict is Verdict.FAIL]
            errors = [abs(row_in(bench, check, row).value - row.value) for check, row in failing]
            sizes = [min(row.tolerance, SAME_VALUE * abs(row.value)) for _, row in failing]
            return all(error <= size for error, size in zip(errors, sizes, strict=True))

        is_search = len(self.judged[0][0].jobs) > 1
        return is_search and defect.switched and gives(defect) and not gives()

    def _passing_rules(self) -> str:
        if not self.trial or len(self.trial.rules) != 1:
            return ""
        (scene,) = self.trial.rules
        if scene.steps * len(scene.bodies) > SEARCH_LIMIT:
            return ""
        names = self.trial.passing_rules()
        return f"passes under {', or under '.join(names)}" if names else ""


class _ReferenceBench(Bench):
    """The reference with the switches of defects, in the place of an engine."""

    def __init__(self, engine: Engine, defects: Sequence[KnownDefect]) -> None:
        super().__init__(engine)
        self._defects = defects

    def prepare(self, jobs: Sequence[Job]) -> None:
        pass  # the reference runs a scene where its output is needed

    def outcomes(self, jobs: Sequence[Job]) -> list[Output | EngineError]:
        return [self.reference_output(self.engine.scene_of(job)) for job in jobs]

    def reference(self, scene: Scene) -> Motion:
        trial = Trial({scene: self.rules(scene)}, bool)
        return self._memo(scene, lambda: trial.motions(self._defects)[scene])


def _passes(bench: Bench, check: Check, row: Row, size: float = 1.0) -> bool:
    """Return whether a row passes, or with a ``size`` above 1 is off by so many tolerances."""
    row = row_in(bench, check, row)
    near = size > 1.0 and abs(row.difference) <= size * row.tolerance
    return near or row.verdict is Verdict.PASS
