"""The search for a critical angle: the root of a margin by passage, or the change of a fate.

*Passage.* A grain that came over the last crest at rest has the margin M(angle) over the next one.
The map of the energy from crest to crest increases, so motion persists where M >= 0. The critical
angle is the root of M, which is smooth and almost linear: a secant needs few runs. Where the
reference takes the same steps as the engine, the secant runs in it, ten times as fast.

*Steady motion.* The source's definition: the smallest angle that keeps moving. The excess of energy
shrinks by the shock from well to well, so W wells resolve it to shock^W. A window of angles is
scanned, widened until the fate changes in it, and each change of fate is refined. Where in a step a
contact begins changes its shock a little, so fates may alternate: with a stiff contact over 1e-3
deg at most, at coarse steps over more (0.007 deg at 4.8 steps per contact, k = 1e5 N/m, 100 wells).
There more wells are passed, and the angles around each change are probed.

*Extrapolation.* The angle of rigid spheres is the limit of the step to zero, then of the stiffness
to infinity, by passage with the plastic contact. LAMMPS damps by the velocity of half a step ago:
the angle is of first order in the step. In the stiffness the order k^(-1/2) cancels, as the grain
is pressed in and comes back while it moves on; the error falls as 1/k with a next term k^(-3/2).
With so little friction that shocks slide it does not: -8.5 deg zeta / sqrt(k) at mu = 0.03.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import suppress
from itertools import chain, count, pairwise, repeat
from typing import Any

import numpy as np
from pydantic import Field, model_validator
from scipy.optimize import brentq, root_scalar

from harness.cases.bench import Bench, Progress
from harness.cases.incline.angle import CriticalAngle, ExtrapolatedAngle, extrapolate
from harness.cases.incline.closed_form import check_passage, refuse_passage
from harness.cases.incline.runs import Fate, Run, job_of, read, scene_of
from harness.cases.incline.system import Incline, OverRow, Route
from harness.engines.base import Job, Output
from harness.engines.process import cores, parallel_map
from harness.errors import EngineError, EngineOutputError, RequestError, Unsupported
from harness.model.base import Parameters
from harness.model.law import PLASTIC
from harness.report.content import power
from harness.store.cache import EngineChoice, opened
from harness.theory.incline import kept_speed

Measure = Callable[[Sequence[Any]], Sequence[Run]]  # runs cases of one route, in order

TOLERANCES_DEG: dict[Route, float] = {"passage": 1e-3, "steady": 5e-3}
FINEST_DEG, COARSEST_DEG = 1e-9, 1.0  # resolution of a search
PHASES = 8  # starts within a step, over which a passage is averaged
FEWEST_PHASES = 2  # one start shows no range
FIRST_ANGLES = (1.0 / 3.0, 0.35)  # of the half angle of the well: 10 and 10.5 deg
MOST_SECANTS = 12  # a smooth margin takes three
WINDOW = (0.98 / 3.0, 1.08 / 3.0)  # of the half angle of the well: 9.8 to 10.8 deg
STEEPEST = 30.0  # [deg]
SCAN, FINE_SCAN = 6, 8  # angles of the first scan, parts of an interval that is scanned again
MOST_UNDECIDED = 2  # between a trapped and a moving angle
HARDLY_A_MARGIN = 2e-4  # [m g d] 4^-5 of the excess at the start
STIFF_OVERLAP = 1.1e-5  # m g / (k d) up to which fates are taken to change once
COARSE, COARSE_WELLS = 20.0, 100  # steps per contact below which fates mix, and wells to pass there
REACH_DEG, SPACING_DEG = 0.01, 5e-4  # around a change of fate that is probed, between probes
MOST_RUNS = 600  # after which no more probes are made
WELLS = 10  # of a plain grain; their number grows as 1 + SPIN_WELLS / friction
SPIN_WELLS = 0.1
SAME_MARGIN = 1e-9  # [m g d] round-off between the engine's margin and the reference's
TIME_PER_WELL = 40.0  # [sqrt(d/g)] least time limit of steady motion
RUNS: dict[Route, int] = {"passage": 12, "steady": 16}  # of a search, about
DIGITS = 15  # of an engine whose margins are the reference's to round-off


class Ladder(Parameters):
    """Stiffnesses over that of a case, and steps per contact time, of an extrapolation."""

    # fmt: off
    factors: tuple[float, ...] = Field(
        (0.1, 10**-0.5, 1.0, 10**0.5, 10.0), description="[-] stiffness over the case's stiffness")
    steps_per_contact: tuple[float, ...] = Field(
        (50.0, 100.0, 200.0, 400.0), description="[-] steps per contact time")
    # fmt: on

    @model_validator(mode="after")
    def _check(self) -> Ladder:
        if len(set(self.factors)) < 4 or min(self.factors) <= 0.0:
            raise ValueError(f"factors = {self.factors}: needs four different positive ones")
        if len(set(self.steps_per_contact)) < 3:
            raise ValueError(f"steps_per_contact = {self.steps_per_contact}: needs three different")
        return self

    def cases(self, case: Incline) -> list[Incline]:
        """Return the refined cases, the costliest first so that no core idles at the end."""
        refined = [
            case.replace(stiffness=case.stiffness * factor, steps_per_contact=steps)
            for factor in self.factors
            for steps in self.steps_per_contact
        ]
        return sorted(refined, key=lambda case: case.step)


QUICK_LADDER = Ladder(factors=(0.1, 10**-0.5, 1.0, 10**0.5), steps_per_contact=(50.0, 100.0, 200.0))
FULL_LADDER = Ladder(factors=(0.1, 10**-0.5, 1.0, 10**0.5, 10.0, 10**1.5, 100.0))


def critical_angle(
    case: Incline | None = None,
    *,
    method: Route = "passage",
    tolerance_deg: float | None = None,
    phases: int = PHASES,
    wells: int | None = None,
    engine: EngineChoice = None,
    fresh: bool = False,
    progress: Progress = lambda *_: None,
) -> CriticalAngle:
    """Return the critical angle [deg] of a case, the source's contact unless given.

    ``method`` is ``passage`` or ``steady``; ``tolerance_deg`` is the resolution of the search.
    ``phases`` are the starts within a step of a passage, ``wells`` those to pass in steady motion.
    ``engine`` is an open one, or the name of one that is opened and whose runs are kept, LAMMPS
    unless given; ``fresh`` runs again what was kept. Raise EngineError for a run that failed,
    RequestError for a case that the engine cannot run, a contact that rebounds too much for a
    passage, wells of a passage, another method, a tolerance that is not from 1e-9 to 1 deg, or a
    single start, which shows no uncertainty.
    """
    conditions = (
        (method in TOLERANCES_DEG, f"method = {method!r}", "'passage' or 'steady'"),
        (tolerance_deg is None or FINEST_DEG <= tolerance_deg <= COARSEST_DEG,
         f"tolerance_deg = {tolerance_deg!r}",
         f"from {power(FINEST_DEG)} to {COARSEST_DEG:g} deg"),
        (phases >= FEWEST_PHASES, f"phases = {phases!r}", f"at least {FEWEST_PHASES}"),
    )  # fmt: skip
    for holds, value, allowed in conditions:
        if not holds:
            raise RequestError(f"{value}: must be {allowed}")
    case, done = prepared(case or Incline(), method, wells), 0
    with opened(engine, fresh=fresh) as running:
        running.check([job_of(case, method)])
        run = engine_measure(Bench(running), method)

        def measure(cases: Sequence[Incline]) -> Sequence[Run]:
            nonlocal done
            runs = run(cases)
            done += len(runs)
            progress(f"runs, {method}", done, max(RUNS[method], done))
            return runs

        return search(measure, case, method, tolerance_deg, phases)


def extrapolated_critical_angle(
    case: Incline | None = None,
    *,
    ladder: Ladder | None = None,
    engine: EngineChoice = None,
    fresh: bool = False,
    progress: Progress = lambda *_: None,
) -> ExtrapolatedAngle:
    """Return the critical angle [deg] with the step to zero, then the stiffness to infinity.

    By passage, with the plastic contact unless a case is given. Raise the first EngineError;
    raise RequestError for a case that the engine cannot run, and for a contact that rebounds too
    much, before any run.
    """
    case, ladder = case or Incline(contact=PLASTIC), ladder or Ladder()
    for refined in ladder.cases(case):
        check_passage(refined)
    with opened(engine, fresh=fresh) as running:
        running.check([job_of(case, "passage")])
        return extrapolated_on(Bench(running), ladder, case, progress)


# ---- on a bench, which runs nothing twice


def angle_on(
    bench: Bench, case: Incline, method: Route = "passage", tolerance_deg: float | None = None
) -> CriticalAngle:
    """Return the critical angle of a case in the engine of a bench, searched once.

    The reference guides a passage where it can take the engine's steps, and the engine writes as
    many digits.
    """
    return bench.once(_searched, bench, case, method, tolerance_deg)


def _searched(
    bench: Bench, case: Incline, method: Route, tolerance_deg: float | None
) -> CriticalAngle:
    measure, case = engine_measure(bench, method), prepared(case, method)
    if method == "passage" and bench.engine.traits.digits >= DIGITS:
        guide = reference_measure(bench, method)
        with suppress(EngineError, Unsupported):  # of the reference; an engine raises its own again
            return search(measure, case, method, tolerance_deg, guide=guide)
    return search(measure, case, method, tolerance_deg)


def extrapolated_on(
    bench: Bench, ladder: Ladder, case: Incline, progress: Progress = lambda *_: None
) -> ExtrapolatedAngle:
    """Return the limit of the critical angle in the engine of a bench."""
    cases, done = ladder.cases(case), count(1)

    def angle_of(refined: Incline) -> CriticalAngle:
        angle = angle_on(bench, refined)
        progress("critical angles", next(done), len(cases))
        return angle

    return extrapolate(parallel_map(angle_of, cases, cores()))


def engine_measure(bench: Bench, route: Route, job: Callable[..., Job] = job_of) -> Measure:
    """Return a function that runs cases in the engine of a bench.

    Raise Unsupported for a case that the engine refuses, the first EngineError of a run.
    """

    def measure(cases: Sequence[OverRow]) -> list[Run]:
        jobs = [job(case, route) for case in cases]
        if reason := next(filter(None, map(bench.refusal, jobs)), ""):
            raise Unsupported(reason)
        bench.prepare(jobs)
        return [run_of(case, bench.output(job)) for case, job in zip(cases, jobs, strict=True)]

    def run_of(case: OverRow, output: Output) -> Run:
        try:
            return read(case, route, output)
        except EngineError as error:
            raise error.with_log(error.log or output.log) from None

    return measure


def reference_measure(bench: Bench, route: Route) -> Measure:
    """Return a function that runs cases in the reference, by the conventions of a bench's engine.

    Raise Unsupported for a case that the engine cannot run.
    """

    def run(case: Incline) -> Run:
        return read(case, route, bench.reference_output(scene_of(case, route)))

    return lambda cases: parallel_map(run, cases, cores())


# ---- a search


def prepared(case: OverRow, method: Route, wells: int | None = None) -> Any:
    """Return a case for a method: of steady motion with the wells to pass, and the time for it."""
    if method == "passage":
        if wells is not None:
            raise RequestError(f"--wells {wells}: goes with --method steady only")
        return case
    if wells is None:
        coarse = case.steps_per_contact < COARSE
        wells = max(case.wells, COARSE_WELLS if coarse else 0, _wells_to_steady_motion(case))
    return case.replace(wells=wells, time_limit=max(case.time_limit, TIME_PER_WELL * wells))


def _wells_to_steady_motion(case: Any) -> int:
    """Return the wells that shrink an excess of energy as ten do of a plain grain, by 4^-10.

    Each leaves the share s^2. Little friction takes some 1 / mu wells to change a spin.
    """
    if case.is_plain:
        return 0
    s = kept_speed(math.degrees(case.half_angle), case.rolling_inertia)
    spin = 1.0 + SPIN_WELLS / case.friction if case.friction else 1.0
    return math.ceil(spin * WELLS * math.log(4.0) / -math.log(max(s * s, 1e-3)))


def first_cases(case: OverRow, method: Route) -> list[Any]:
    """Return the cases that a search of a prepared case runs first, at once."""
    half_angle = round(math.degrees(case.half_angle), 12)
    parts = FIRST_ANGLES if method == "passage" else WINDOW
    low, high = (round(part * half_angle, 12) for part in parts)
    if method == "passage":
        return at_angles(case, [low, high])
    if _is_monotone(case):
        return at_angles(case.replace(wells=math.ceil(case.wells / 2)), [low, high])
    return at_angles(case, np.linspace(low, high, SCAN))


def at_angles(case: OverRow, angles: Iterable[float]) -> list[Any]:
    """Return a case at each of some angles [deg]."""
    return [case.replace(angle=float(angle)) for angle in angles]


def search(
    measure: Measure, case: Any, method: Route, tolerance_deg: float | None = None,
    phases: int = PHASES, guide: Measure | None = None,
) -> CriticalAngle:  # fmt: skip
    """Return the critical angle [deg] of a case by a function that runs cases of the route.

    ``guide`` runs cases at equal steps in the reference, and may lead a passage to its root.
    """
    tolerance = TOLERANCES_DEG[method] if tolerance_deg is None else tolerance_deg
    if method == "steady":
        return by_steady_motion(measure, case, tolerance)
    check_passage(case)
    return by_passage(measure, case, tolerance, phases, guide)


# ---- by passage


def by_passage(
    measure: Measure, case: Any, tolerance_deg: float = 1e-3, phases: int = PHASES,
    guide: Measure | None = None,
) -> CriticalAngle:  # fmt: skip
    """Return the root of the margin, averaged over starts within a step.

    The root is that of phase 0; then runs with the start shifted by fractions of a step show how
    much it depends on where in a step a contact begins. The margins of a ``guide`` count where
    the one that is measured at its root is the same. Raise EngineOutputError without a root
    between 0 and 30 deg, RequestError for a grain in flight, whose margin is not defined.
    """
    first = list(measure(first_cases(case, "passage")))
    if len({run.margin for run in first}) == 1:
        raise EngineOutputError("the energy margin has no root: it is the same at every angle")
    runs, root, slope = _located(first, guide or measure, case, tolerance_deg / 4.0)
    cases = [case.replace(angle=root, phase=phase / phases) for phase in range(phases)]
    shifted = list(measure(cases))
    if guide is not None:
        (expected,) = guide(cases[:1])
        if not abs(shifted[0].margin - expected.margin) < SAME_MARGIN:
            return by_passage(measure, case, tolerance_deg, phases)
        runs = first
    if not all(run.touching for run in shifted):
        refuse_passage(case, "here the grain was in flight at the crest")
    angles = root - np.array([run.margin for run in shifted]) / slope
    value, half_range = float(angles.mean()), float(np.ptp(angles)) / 2.0
    # the last correction is by a slope good to a few per cent: a tenth of it is uncertain
    root_error = 0.1 * abs(value - root)
    # the angle is a sawtooth of the phase, of half range a: the mean of P starts is off by a / P at
    # most, and the half range of the starts is a (1 - 1 / P)
    return CriticalAngle.of(
        [*runs, *shifted], case, "passage", value=value, uncertainty=half_range + root_error,
        mean_error=half_range / (phases - 1) + root_error,
    )  # fmt: skip


def _located(
    first: Sequence[Run], measure: Measure, case: OverRow, xtol: float
) -> tuple[list[Run], float, float]:
    """Return the runs to the root of the margin, the root [deg] and the slope [m g d / deg].

    The margin of a soft contact may jump: then the root lies between two angles that were run.
    """
    runs = {run.case.angle: run for run in first}

    def margin(angle: float) -> float:
        if not 0.0 <= angle <= STEEPEST:
            raise EngineOutputError(f"no critical angle between 0 and 30 deg (search at {angle:g})")
        if angle not in runs:
            (runs[angle],) = measure(at_angles(case, [angle]))
        return runs[angle].margin

    x0, x1 = runs
    solution = root_scalar(margin, method="secant", x0=x0, x1=x1, xtol=xtol, maxiter=MOST_SECANTS)
    root = float(solution.root)
    if not solution.converged:
        pairs = pairwise(sorted(runs))
        ends = next(((a, b) for a, b in pairs if margin(a) < 0.0 <= margin(b)), None)
        if ends is None:
            raise EngineOutputError("the energy margin changes sign at no angle that was run")
        root = float(brentq(margin, *ends, xtol=xtol))
    # the outermost angles give the slope: there jitter matters least
    low, high = min(runs), max(runs)
    return [*runs.values()], root, (margin(high) - margin(low)) / (high - low)


# ---- by steady motion


def by_steady_motion(measure: Measure, case: Any, tolerance_deg: float = 5e-3) -> CriticalAngle:
    """Return the middle of the lowest interval from a trapped to a moving angle.

    The uncertainty is half of it, and reaches up to the highest trapped angle. Undecided runs
    belong to neither side: they widen the interval. Raise EngineOutputError where no moving angle
    lies above a trapped one.
    """
    runs = _scanned(measure, case, tolerance_deg)
    angles = {fate: [run.case.angle for run in runs if run.fate is fate] for fate in Fate}
    for fate, words in ((Fate.TRAPPED, "was trapped"), (Fate.MOVES_ON, "kept moving")):
        if not angles[fate]:
            raise EngineOutputError(f"no angle from 0 to 30 deg {words}")
    rising = [(a.case.angle, b.case.angle) for a, b in _changes(runs) if b.fate is Fate.MOVES_ON]
    if not rising:
        raise EngineOutputError("no angle from 0 to 30 deg kept moving above a trapped one")
    trapped, undecided = max(angles[Fate.TRAPPED]), len(angles[Fate.UNDECIDED])
    monotone = trapped < min(angles[Fate.MOVES_ON])
    notes = [f"not monotone: trapped again up to {trapped:.5g} deg"] * (not monotone)
    notes += [f"{undecided} angles undecided within the time limit"] * (undecided > 0)
    value = (rising[0][0] + rising[0][1]) / 2.0
    error = rising[-1][1] - value
    return CriticalAngle.of(
        runs, case, "steady", value=value, uncertainty=error, mean_error=error,
        monotone=monotone, note="; ".join(notes),
    )  # fmt: skip


def _is_monotone(case: OverRow) -> bool:
    """Return whether fates alternate over 1e-3 deg at most: with a stiff contact, at fine steps."""
    return case.static_overlap <= STIFF_OVERLAP and case.steps_per_contact >= COARSE


def _scanned(measure: Measure, case: OverRow, tolerance_deg: float) -> list[Run]:
    """Return the runs of a scan, of the intervals in which the fate changes, and of probes."""
    runs: list[Run] = []
    parts = chain([SCAN - 1 if _is_monotone(case) else FINE_SCAN], repeat(2))
    angles = [first.angle for first in first_cases(case, "steady")]
    while angles:
        runs = sorted([*runs, *_decided(measure, case, angles)], key=lambda run: run.case.angle)
        angles = _beyond(runs) or _inside_changes(runs, 2.0 * tolerance_deg, parts)
        angles = angles or _probes(runs, case)
    return runs


def _decided(measure: Measure, case: OverRow, angles: Sequence[float]) -> list[Run]:
    """Run angles, where fates change once through half of the wells if those decide.

    They leave 4^-5 of the excess: a trapped grain stays trapped, one with more margin moves on.
    """
    if not _is_monotone(case):
        return list(measure(at_angles(case, angles)))
    half = case.replace(wells=math.ceil(case.wells / 2))
    runs = list(measure(at_angles(half, angles)))
    for place, run in enumerate(runs):
        if run.fate is Fate.MOVES_ON and run.margin < HARDLY_A_MARGIN:
            (runs[place],) = measure(at_angles(case, [run.case.angle]))
    return runs


def _beyond(runs: Sequence[Run]) -> list[float]:
    """Return an angle that widens a window whose ends are not trapped below and moving above."""
    low, high = runs[0].case.angle, runs[-1].case.angle
    if runs[0].fate is not Fate.TRAPPED and low > 0.0:
        return [max(0.0, low - (high - low))]
    if runs[-1].fate is not Fate.MOVES_ON and high < STEEPEST:
        return [min(STEEPEST, high + (high - low))]
    return []


def _changes(runs: Sequence[Run]) -> list[tuple[Run, Run]]:
    """Return the pairs of decided neighbours whose fates differ."""
    decided = [run for run in runs if run.fate is not Fate.UNDECIDED]
    return [(low, high) for low, high in pairwise(decided) if low.fate is not high.fate]


def _inside_changes(runs: Sequence[Run], width: float, parts: Iterator[int]) -> list[float]:
    """Return the angles that cut every change of fate wider than ``width`` into the next parts."""
    ends = [[r.case.angle for r in runs if low.case.angle <= r.case.angle <= high.case.angle]
            for low, high in _changes(runs)]  # fmt: skip
    wide = [e for e in ends if e[-1] - e[0] > width and len(e) <= MOST_UNDECIDED + 2]
    cuts = next(parts) if wide else 0
    angles: list[float] = []
    for inside in wide:
        widest = int(np.argmax(np.diff(inside)))
        angles += np.linspace(inside[widest], inside[widest + 1], cuts + 1)[1:-1].tolist()
    return angles


def _probes(runs: Sequence[Run], case: OverRow) -> list[float]:
    """Return angles that leave no wide gap around a change of fate that may not be the only one."""
    changes = _changes(runs)
    if (len(changes) < 2 and case.steps_per_contact >= COARSE) or len(runs) >= MOST_RUNS:
        return []
    reached = [(a.case.angle - REACH_DEG, b.case.angle + REACH_DEG) for a, b in changes]
    angles: list[float] = []
    for low, high in pairwise(run.case.angle for run in runs):
        near = [(max(low, start), min(high, end)) for start, end in reached]
        start = min((start for start, end in near if end > start), default=high)
        end = max((end for start, end in near if end > start), default=low)
        if end - start > SPACING_DEG * (1.0 + 1e-9):
            angles += np.linspace(start, end, math.ceil((end - start) / SPACING_DEG) + 1).tolist()
    return sorted(set(angles) - {run.case.angle for run in runs})
