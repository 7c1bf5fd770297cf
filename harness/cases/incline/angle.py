"""The critical angle of the incline in an engine: by passage, by steady motion, extrapolated.

*Passage* takes the root of the energy margin over one well. A grain that came over the last crest
at rest has, past the next shock, the margin M(theta) over the next crest. The map of the energy
from crest to crest is increasing, so motion persists iff M >= 0: the root of M is the critical
angle. M is smooth and almost linear, so a secant needs few runs.

*Steady* is the source's definition: the smallest angle that keeps moving. The grain starts with
more energy than it needs and the excess shrinks by the shock, about 1/4, from well to well: passing
W wells resolves the energy to 4^-W of the excess. The outcome need not be monotone in the angle, so
the angles are scanned before they are bisected, and every interval between two neighbours of
different fate is refined.

Where in a step a contact begins decides on its shock. At coarse steps fates so mix over an interval
of angles, and where in it a run falls is a matter of its start: at 4.8 steps per contact (MFiX's
contact and scheme) and k = 1e5 N/m over 0.03 deg with 10 wells and over 0.007 deg with 100 (of 32
starts that differ by 3 % in speed, one moves on at 10.166 deg and the last at 10.173 deg), at
1e6 N/m over 0.01 and 0.002 deg. More wells trap more angles: there the value with 10 wells
lies 0.02 deg below that with 100. So at coarse steps more wells are passed, the angles around each
change of fate are probed, and the uncertainty reaches over all that these found mixed; at
1e5 N/m another start, or another step by 1e-4, may still move the value by 0.003 deg.

*Extrapolated*: the step to zero first, then the stiffness to infinity. LAMMPS's damping feels the
velocity of half a step ago, so the angle is first order in the step. In the plastic contact the
grain is pressed in and comes back while it moves on: what the spring moves cancels at order
k^(-1/2), and the bias falls as 1/k with a next term k^(-3/2).
"""

from __future__ import annotations

import itertools
import math
import threading
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import partial
from itertools import groupby, pairwise
from typing import TYPE_CHECKING, Any, ClassVar, Literal, TypeVar

import numpy as np
from scipy.optimize import brentq, root_scalar

from harness.cases.grain import complete
from harness.cases.incline.closed_forms import (
    ONE_SHOCK,
    PASSAGES,
    rebound,
    rebound_in_steps,
    theory_in_words,
)
from harness.cases.incline.levels import COARSE, COARSE_WELLS, RUNS_BY_PASSAGE, STEADY_RUNS, Ladder
from harness.cases.incline.runs import run_inclines
from harness.cases.incline.system import (
    SPEED_AFTER_SHOCK,
    Incline,
    InclineRun,
    Motion,
    Route,
    settled_before,
)
from harness.cases.verification import Progress, silent
from harness.comparison.convergence import Limit, limit
from harness.engines.contract import Engine
from harness.engines.process import cores, parallel_map
from harness.errors import EngineError, EngineOutputError, RequestError
from harness.observables.provenance import Provenance
from harness.parameters.law import PLASTIC
from harness.shown import Result, power, value_text
from harness.store.cache import EngineChoice, opened
from harness.theory.incline import critical_angle as closed_form_angle

if TYPE_CHECKING:
    import pandas as pd

    from harness.shown.figure import Figure


@dataclass(frozen=True)
class Sample:
    """One run of the search for a critical angle; margin in units of m g d."""

    angle_deg: float
    phase: float
    motion: str
    margin: float


@dataclass(frozen=True, repr=False)
class CriticalAngle(Result):
    """A critical angle [deg] at one stiffness and step, with its uncertainty [deg].

    The uncertainty is that of the measurement at this stiffness and step
    (bracket or root, and where in a step the contacts begin). It does not
    contain the bias of a finite stiffness: that is what extrapolation is for.
    ``mean_error_deg`` is the error of the value as a mean over where in a step
    contacts begin; the uncertainty is the range a single run may fall in.
    ``monotone`` is false when an angle above a moving one was trapped.
    """

    value_deg: float
    uncertainty_deg: float
    mean_error_deg: float
    method: str
    case: Incline
    provenance: Provenance
    samples: tuple[Sample, ...] = field(default=(), repr=False)
    monotone: bool = True
    note: str = ""
    steps: int = 0
    seconds: float = 0.0
    ranks: int | None = None

    JSON: ClassVar = {
        "critical_angle_deg": "value_deg",
        "uncertainty_deg": "uncertainty_deg",
        "method": "method",
        "stiffness_N_per_m": "case.stiffness",
        "steps_per_contact": "case.steps_per_contact",
        "contact": "case.contact.name",
        "restitution": "case.contact.restitution",
        "damping_ratio": "case.contact.zeta",
        "tail": "case.contact.tail",
        "effective_mass": "case.contact.effective_mass",
        "diameter_m": "case.diameter",
        "density_kg_per_m3": "case.density",
        "gravity_m_per_s2": "case.gravity",
        "**wells": "wells_of_steady",
        "monotone": "monotone",
        "note": "note",
        "runs": "runs",
        "steps": "steps",
        "**provenance": "provenance",
    }

    @classmethod
    def of(
        cls, runs: Sequence[InclineRun], case: Incline, value_deg: float, **more: Any
    ) -> CriticalAngle:
        """Return the angle of a case that runs led to; ``more`` are its other fields."""
        return cls(
            value_deg=value_deg,
            case=case,
            provenance=runs[-1].provenance,
            samples=tuple(
                Sample(run.case.angle, run.case.phase, run.motion.value, run.margin) for run in runs
            ),
            steps=sum(run.steps for run in runs),
            seconds=sum(run.seconds for run in runs),
            ranks=runs[-1].ranks,
            **more,
        )

    @property
    def phases(self) -> int:
        """Return how many starts within a step the value is the mean of."""
        return max(1, len({sample.phase for sample in self.samples}))

    @property
    def phases_note(self) -> str:
        """Return the note of a row on the phases that a passage is averaged over."""
        if self.method != "passage":
            return ""
        return (
            f"mean over {self.phases} starts within a step; over another number of them it is "
            f"another mean, by up to {self.mean_error_deg:.1g} deg"
        )

    def to_frame(self) -> pd.DataFrame:
        """Return the runs behind the value as a table, sorted by angle."""
        import pandas as pd

        return pd.DataFrame([vars(s) for s in self.samples]).sort_values("angle_deg")

    @property
    def wells_of_steady(self) -> dict[str, int]:
        """Return the wells of a run of the steady method, which other methods do not have."""
        return {"wells": self.case.wells} if self.method == "steady" else {}

    @property
    def runs(self) -> int:
        """Return how many runs the angle took."""
        return len(self.samples)

    def summary(self) -> dict[str, str]:
        """Return the angle, the case and who measured it."""
        case = self.case
        return {
            "critical angle": value_text(self.value_deg, self.uncertainty_deg, "deg"),
            "case": f"incline, {case.contact.name} contact, k = {power(case.stiffness)} N/m, "
            f"{case.steps_per_contact:g} steps per contact time",
            "method": f"{self.method}, {len(self.samples)} runs",
            "engine": self.provenance.label,
            **({"note": self.note} if self.note else {}),
        }

    def draw(self) -> Figure:
        """Draw what is left of the energy over the next crest (or the fate) of each run."""
        from harness.cases.incline.figures import runs_of_an_angle

        return runs_of_an_angle(self)


Measure = Callable[[Sequence[Incline]], Sequence[InclineRun]]

FIRST_ANGLES = (10.0, 10.5)
PHASES = 8

MOST_SECANTS = 12
"""A smooth margin takes three; more is a sign of a jump."""


def check_passage(*cases: Incline) -> None:
    """Raise RequestError for a contact whose rebounds go on where a passage is judged.

    What counts is the restitution that the contact has in the steps of the case.
    """
    for case in cases:
        e, steps = rebound(case.contact), case.steps_per_contact
        if e <= ONE_SHOCK:
            continue
        in_steps = rebound_in_steps(case.contact, steps)
        if in_steps > (most := most_restitution(case)):
            up_to = f", up to {in_steps:.3g} at {steps:g} steps per contact" if e <= most else ""
            raise RequestError(
                "method = 'passage' needs a contact that ends the rebounds within one well, one of "
                f"restitution {most:.3g} at most at stiffness {case.stiffness:g} (here {e:.3g}"
                f"{up_to}): use method 'steady'; {theory_in_words(case.contact)}"
            )


def most_restitution(case: Incline) -> float:
    """Return the restitution up to which a passage of a contact so stiff is measured.

    The hops of rigid spheres end a contact time before the passage is judged: those of a
    spring end up to half a contact time later or earlier (found in the reference DEM at
    k d / m g of 1e4 to 1e6). In a DEM of k >= 1e5 N/m (k d / m g >= 1e4) it is judged 10 deg
    before the crest.
    """
    from harness.solvers.hard_sphere import hops_end

    upright = case.replace(angle=closed_form_angle())
    contact_way = SPEED_AFTER_SHOCK * case.contact_time * math.sqrt(case.gravity / case.diameter)
    judged = math.degrees(settled_before(upright) + contact_way)
    if hops_end(PASSAGES) >= judged:
        return PASSAGES
    return float(brentq(lambda e: hops_end(e) - judged, 0.0, PASSAGES, xtol=1e-4))


def critical_angle_by_passage(
    measure: Measure, case: Incline, *, tolerance_deg: float = 1e-3, phases: int = PHASES
) -> CriticalAngle:
    """Return the critical angle of ``case`` (whose own angle is ignored).

    ``measure`` runs inclines in the passage route. The root is found at phase
    0; then ``phases`` runs with the start shifted by fractions of a step tell
    how much the angle depends on where in a step a contact begins. The value
    is their mean, the uncertainty half their range plus the root's own.

    Raise EngineOutputError when there is no root between 0 and 30 deg, and
    RequestError when the grain was in flight, where the margin is not defined.
    """
    # both at once: an engine starts once for a batch
    runs = list(measure([case.replace(angle=angle) for angle in FIRST_ANGLES]))
    first = dict(zip(FIRST_ANGLES, (run.margin for run in runs), strict=True))
    if len(set(first.values())) == 1:
        raise EngineOutputError("the energy margin has no root: it is the same at every angle")

    def margin(angle: float) -> float:
        if angle in first:
            return first[angle]
        if not 0.0 <= angle <= 30.0:
            raise EngineOutputError(f"no critical angle between 0 and 30 deg (search at {angle:g})")
        runs.extend(measure([case.replace(angle=float(angle))]))
        return runs[-1].margin

    solution = root_scalar(
        margin,
        method="secant",
        x0=FIRST_ANGLES[0],
        x1=FIRST_ANGLES[1],
        xtol=tolerance_deg / 4,
        maxiter=MOST_SECANTS,
    )
    root = (
        float(solution.root) if solution.converged else _bisected(margin, runs, tolerance_deg / 4)
    )
    slope = _slope(runs)
    shifts = np.arange(phases) / phases
    shifted = measure([case.replace(angle=root, phase=float(shift)) for shift in shifts])
    _refuse_flight(shifted)
    angles = root - np.array([run.margin for run in shifted]) / slope
    # the last correction uses a slope good to a few per cent: a tenth of it is uncertain
    root_error = 0.1 * abs(float(angles.mean()) - root)
    half_range = float(np.ptp(angles)) / 2
    return CriticalAngle.of(
        [*runs, *shifted],
        case,
        float(angles.mean()),
        uncertainty_deg=half_range + root_error,
        # the angle jumps once a step as the phase shifts: P even phases miss the mean of
        # such a sawtooth by at most its half range over P
        mean_error_deg=half_range / phases + root_error,
        method="passage",
    )


def _bisected(margin: Callable[[float], float], runs: Sequence[InclineRun], xtol: float) -> float:
    """Return where the margin changes sign between two angles that were run.

    The margin of a soft, rebounding contact jumps: a secant runs off there, a
    bracket does not. Raise EngineOutputError where no sign changes.
    """
    ordered = sorted(runs, key=lambda run: run.case.angle)
    for low, high in pairwise(ordered):
        if low.margin < 0.0 <= high.margin:
            return float(brentq(margin, low.case.angle, high.case.angle, xtol=xtol))
    raise EngineOutputError("the energy margin changes sign at no angle that was run")


def _slope(runs: Sequence[InclineRun]) -> float:
    """Return dM/dtheta [1/deg] from the two outermost angles: jitter weighs least there."""
    ordered = sorted(runs, key=lambda run: run.case.angle)
    low, high = ordered[0], ordered[-1]
    return (high.margin - low.margin) / (high.case.angle - low.case.angle)


def _refuse_flight(runs: Sequence[InclineRun]) -> None:
    if not all(run.touching for run in runs):
        raise RequestError(
            "method = 'passage' needs a contact that ends the rebounds within one well; "
            "here the grain was in flight at the crest: use method 'steady'; "
            + theory_in_words(runs[0].case.contact)
        )


WINDOW = (9.8, 10.8)
SCAN = 6
FINE_SCAN = 8
MOST_UNDECIDED = 2
"""Between a trapped and a moving angle: with more undecided ones, stop asking."""


REACH, SPACING = 0.01, 5e-4
"""[deg] How far from a change of fate is probed, and the largest gap between the probes."""

MOST_RUNS = 600
"""With so many runs no more probes are made: fates that mix without an end."""


def critical_angle_by_steady_motion(
    measure: Measure,
    case: Incline,
    *,
    tolerance_deg: float = 5e-3,
    window: tuple[float, float] = WINDOW,
) -> CriticalAngle:
    """Return the smallest angle of ``case`` that keeps moving (its own angle is ignored).

    ``measure`` runs inclines in the steady route. The window is scanned, and
    widened within 0 to 30 deg until its lower end is trapped and its upper end
    moves; each interval in which the fate changes is scanned again, then
    bisected. Where steps are coarse or the outcome was not monotone, the angles around
    each change are probed until no probe finds another. The value is the middle of the lowest
    interval whose lower end is trapped and upper end moves; the uncertainty is half of it, and
    reaches up to the highest trapped angle where the outcome is not monotone. Undecided runs
    belong to neither side: they widen the interval.

    Raise EngineOutputError when the fate is the same at 0 and 30 deg, when no
    moving angle lies above a trapped one, or when nothing is decided.
    """
    runs = _scan(measure, case, window)
    parts = FINE_SCAN
    while angles := _inside_changes(runs, 2 * tolerance_deg, parts) or _probes(runs, case):
        fresh = measure([case.replace(angle=angle) for angle in angles])
        runs = sorted([*runs, *fresh], key=lambda run: run.case.angle)
        parts = 2
    return _result(runs, case)


def _scan(measure: Measure, case: Incline, window: tuple[float, float]) -> list[InclineRun]:
    """Run the window's angles, widening it until it holds the change of fate."""
    low, high = window
    runs = list(measure([case.replace(angle=float(a)) for a in np.linspace(low, high, SCAN)]))
    while runs[0].motion is not Motion.TRAPPED and low > 0.0:
        low = max(0.0, low - (high - low))
        runs.insert(0, measure([case.replace(angle=low)])[0])
    while runs[-1].motion is not Motion.MOVES_ON and high < 30.0:
        high = min(30.0, high + (high - low))
        runs.append(measure([case.replace(angle=high)])[0])
    if not any(run.motion is Motion.TRAPPED for run in runs):
        raise EngineOutputError("no angle from 0 to 30 deg was trapped")
    if not any(run.motion is Motion.MOVES_ON for run in runs):
        raise EngineOutputError("no angle from 0 to 30 deg kept moving")
    return runs


def _changes(runs: Sequence[InclineRun]) -> list[tuple[InclineRun, InclineRun]]:
    """Return the pairs of decided neighbours of different fate, undecided ones between them."""
    decided = [run for run in runs if run.motion is not Motion.UNDECIDED]
    pairs = itertools.pairwise(decided)
    return [(low, high) for low, high in pairs if low.motion is not high.motion]


def _inside_changes(runs: Sequence[InclineRun], width: float, parts: int) -> list[float]:
    """Return the angles that cut every change of fate wider than ``width`` into parts."""
    angles: list[float] = []
    for low, high in _changes(runs):
        ends = [r.case.angle for r in runs if low.case.angle <= r.case.angle <= high.case.angle]
        if ends[-1] - ends[0] <= width or len(ends) > MOST_UNDECIDED + 2:
            continue
        widest = int(np.argmax(np.diff(ends)))
        angles += np.linspace(ends[widest], ends[widest + 1], parts + 1)[1:-1].tolist()
    return angles


def _probes(runs: Sequence[InclineRun], case: Incline) -> list[float]:
    """Return angles that leave no wide gap around a change of fate, where it may not be the one."""
    changes = _changes(runs)
    if (len(changes) < 2 and case.steps_per_contact >= COARSE) or len(runs) >= MOST_RUNS:
        return []
    angles: list[float] = []
    for low, high in itertools.pairwise(run.case.angle for run in runs):
        near = [
            (max(low, a.case.angle - REACH), min(high, b.case.angle + REACH)) for a, b in changes
        ]
        start = min((start for start, end in near if end > start), default=high)
        end = max((end for start, end in near if end > start), default=low)
        if end - start > SPACING * (1.0 + 1e-9):
            angles += np.linspace(start, end, math.ceil((end - start) / SPACING) + 1).tolist()
    return sorted(set(angles) - {run.case.angle for run in runs})


def _result(runs: Sequence[InclineRun], case: Incline) -> CriticalAngle:
    rising = [(a, b) for a, b in _changes(runs) if b.motion is Motion.MOVES_ON]
    if not rising:
        raise EngineOutputError("no angle from 0 to 30 deg kept moving above a trapped one")
    low, high = rising[0]
    value = (low.case.angle + high.case.angle) / 2
    highest_trapped = max(r.case.angle for r in runs if r.motion is Motion.TRAPPED)
    first_moving = min(r.case.angle for r in runs if r.motion is Motion.MOVES_ON)
    monotone = highest_trapped < first_moving
    undecided = [r.case.angle for r in runs if r.motion is Motion.UNDECIDED]
    note = "" if monotone else f"not monotone: trapped again up to {highest_trapped:.5g} deg"
    if undecided:
        note += f"{'; ' if note else ''}{len(undecided)} angles undecided within the time limit"
    uncertainty = max(high.case.angle, rising[-1][1].case.angle) - value
    return CriticalAngle.of(
        runs,
        case,
        value,
        uncertainty_deg=uncertainty,
        mean_error_deg=uncertainty,
        method="steady",
        monotone=monotone,
        note=note,
    )


STEP_EXPONENTS = (1.0,)
STIFFNESS_EXPONENTS = (1.0, 1.5)


@dataclass(frozen=True, repr=False)
class ExtrapolatedAngle(Result):
    """The critical angle of rigid spheres from an engine, with the values extrapolated from.

    ``at_stiffness`` maps each stiffness [N/m] to its limit in the step;
    ``rigid`` is the limit of those in the inverse stiffness.
    """

    angles: tuple[CriticalAngle, ...]
    at_stiffness: dict[float, Limit]
    rigid: Limit

    @property
    def value_deg(self) -> float:
        """Return the extrapolated critical angle [deg]."""
        return self.rigid.value

    @property
    def uncertainty_deg(self) -> float:
        """Return its uncertainty [deg]."""
        return self.rigid.uncertainty

    def summary(self) -> dict[str, str]:
        """Return the angle, the contact, the stiffnesses and steps, and the engine."""
        first, stiffnesses = self.angles[0], [*self.at_stiffness]
        return {
            "critical angle": value_text(self.value_deg, self.uncertainty_deg, "deg"),
            "case": f"incline, {first.case.contact.name} contact, step to zero, then stiffness "
            "to infinity",
            "ladder": f"{len(self.angles)} angles, k = {power(min(stiffnesses))} to "
            f"{power(max(stiffnesses))} N/m",
            "closed form": f"{closed_form_angle():.5f} deg (no rebound)",
            "engine": first.provenance.label,
        }

    def draw(self) -> Figure:
        """Draw the limits in the step, and their limit in the stiffness."""
        from harness.cases.incline.figures import extrapolation

        return extrapolation(self, closed_form_angle(), self.angles[0].provenance.engine)

    def to_json(self) -> dict[str, Any]:
        """Return the result as a JSON-ready mapping; stiffness and step are null: extrapolated."""
        return {
            **self.angles[0].to_json(),
            "critical_angle_deg": self.value_deg,
            "uncertainty_deg": self.uncertainty_deg,
            "extrapolated": True,
            "stiffness_N_per_m": None,
            "steps_per_contact": None,
            "runs": sum(len(a.samples) for a in self.angles),
            "steps": sum(a.steps for a in self.angles),
            "order_in_stiffness": self.rigid.order,
            "order_in_stiffness_interval": list(self.rigid.order_interval),
            "limits": [
                {
                    "stiffness_N_per_m": stiffness,
                    "critical_angle_deg": at_step_zero.value,
                    "uncertainty_deg": at_step_zero.uncertainty,
                    "order_in_step": at_step_zero.order,
                    "order_in_step_interval": list(at_step_zero.order_interval),
                }
                for stiffness, at_step_zero in self.at_stiffness.items()
            ],
            "ladder": self.to_frame().to_dict(orient="records"),
        }

    def to_frame(self) -> pd.DataFrame:
        """Return the ladder as a table: stiffness, steps per contact, angle, uncertainty."""
        import pandas as pd

        return pd.DataFrame(
            {
                "stiffness_N_per_m": [a.case.stiffness for a in self.angles],
                "steps_per_contact": [a.case.steps_per_contact for a in self.angles],
                "critical_angle_deg": [a.value_deg for a in self.angles],
                "uncertainty_deg": [a.uncertainty_deg for a in self.angles],
            }
        )


def extrapolate(angles: Sequence[CriticalAngle]) -> ExtrapolatedAngle:
    """Return the limit of angles measured over a ladder of stiffnesses and steps.

    Raise RequestError for fewer than three steps at each stiffness or fewer than
    four stiffnesses.
    """

    def stiffness(angle: CriticalAngle) -> float:
        return angle.case.stiffness

    ordered = sorted(angles, key=lambda a: (stiffness(a), a.case.steps_per_contact))
    limits = {k: step_limit(list(group)) for k, group in groupby(ordered, key=stiffness)}
    rigid = limit(
        [1.0 / k for k in limits],
        [at_step_zero.value for at_step_zero in limits.values()],
        [at_step_zero.uncertainty for at_step_zero in limits.values()],
        STIFFNESS_EXPONENTS,
    )
    return ExtrapolatedAngle(tuple(ordered), limits, rigid)


def step_limit(angles: Sequence[CriticalAngle]) -> Limit:
    """Return the limit in the step at one stiffness."""
    return limit(
        [1.0 / a.case.steps_per_contact for a in angles],
        [a.value_deg for a in angles],
        [a.mean_error_deg for a in angles],
        STEP_EXPONENTS,
    )


Angle = TypeVar("Angle")

Method = Literal["passage", "steady"]

Runner = Callable[[Engine, Sequence[Any], Route], Sequence[InclineRun | EngineError]]
"""Runs cases by a route and returns their results in order, errors in place."""

TOLERANCES_DEG = {"passage": 1e-3, "steady": 5e-3}

TIME_PER_WELL = 40.0
"""[sqrt(d/g)] Least time limit of steady motion for each well."""


def critical_angle(  # noqa: PLR0913 - keywords of a public function
    case: Incline | None = None,
    *,
    method: Method = "passage",
    tolerance_deg: float | None = None,
    phases: int = PHASES,
    wells: int | None = None,
    engine: EngineChoice = None,
    fresh: bool = False,
    progress: Progress = silent,
    run: Runner = run_inclines,
) -> CriticalAngle:
    """Return the critical angle [deg] of a case (the source's contact by default).

    ``tolerance_deg`` [deg] is how closely it is searched for.
    ``method`` is ``passage`` (root of the energy margin over one well) or
    ``steady`` (smallest angle that keeps moving, the source's definition);
    ``phases`` is how many starts within a step the passage is averaged over; ``wells`` are to be
    passed in steady motion: those of the case unless given, 100 or more at coarse steps.
    ``engine`` is an open one, or the name of one that is opened and whose runs are kept; LAMMPS
    in-process unless given. ``fresh`` runs again what was kept. ``progress`` is called with the
    runs done and those expected. ``run`` runs cases of another kind. Raise EngineError when
    the engine fails, RequestError for a contact that rebounds too much for a passage.
    """
    case = case or Incline()
    if method == "passage":
        check_passage(case)
    tolerance = TOLERANCES_DEG[method] if tolerance_deg is None else tolerance_deg
    with opened(engine, fresh=fresh) as running:
        if method == "steady":
            measure = _counted(run, running, method, STEADY_RUNS, progress)
            passing_case = passing(case, wells)
            return critical_angle_by_steady_motion(measure, passing_case, tolerance_deg=tolerance)
        measure = _counted(run, running, method, RUNS_BY_PASSAGE, progress)
        return critical_angle_by_passage(measure, case, tolerance_deg=tolerance, phases=phases)


def critical_angle_or_error(case: Incline, **options: Any) -> CriticalAngle | EngineError:
    """Return :func:`critical_angle`, or the error in its place.

    That a passage cannot measure a case is an error too: one case of many is no reason to lose the
    others, and a grain that flies where it should slide is the engine's doing.
    """
    try:
        return critical_angle(case, **options)
    except EngineError as error:
        return error
    except RequestError as error:
        return EngineOutputError(str(error))


def _counted(
    run: Runner, engine: Engine, route: Route, expected: int, progress: Progress
) -> Measure:
    """Return a function that runs inclines in an engine and reports the runs done and expected.

    The expected number is exact only for the last runs of a search.
    """
    done = 0

    def measure(cases: Sequence[Incline]) -> list[InclineRun]:
        nonlocal done
        progress(f"runs, {route}", done, max(expected, done + len(cases)))
        outcomes = complete(run(engine, cases, route))
        done += len(outcomes)
        progress(f"runs, {route}", done, max(expected, done))
        return outcomes

    return measure


def passing(case: Incline, wells: int | None) -> Incline:
    """Return a case with the wells to pass in steady motion, and the time for them."""
    if wells is None:
        wells = max(case.wells, COARSE_WELLS if case.steps_per_contact < COARSE else 0)
    return case.replace(wells=wells, time_limit=max(case.time_limit, TIME_PER_WELL * wells))


def critical_angles(
    cases: Sequence[Incline],
    engine: EngineChoice,
    *,
    fresh: bool = False,
    method: Method = "passage",
    phases: int = PHASES,
    stage: str = "critical angles",
    progress: Progress = silent,
) -> list[CriticalAngle | EngineError]:
    """Return the critical angle [deg] of each case, side by side; errors in place."""
    with opened(engine, fresh=fresh) as running:
        measure = partial(critical_angle_or_error, method=method, phases=phases, engine=running)
        return side_by_side(measure, cases, stage, progress)


def side_by_side(
    measure: Callable[[Incline], Angle], cases: Sequence[Incline], stage: str, progress: Progress
) -> list[Angle]:
    """Return ``measure`` of each case, run over the cores; report the progress."""
    done, lock = 0, threading.Lock()

    def angle_of(case: Incline) -> Angle:
        nonlocal done
        result = measure(case)
        with lock:
            done += 1
            progress(stage, done, len(cases))
        return result

    progress(stage, 0, len(cases))
    return parallel_map(angle_of, cases, cores())


def extrapolated_critical_angle(
    case: Incline | None = None,
    *,
    ladder: Ladder | None = None,
    engine: EngineChoice = None,
    fresh: bool = False,
    stage: str = "extrapolation",
    progress: Progress = silent,
) -> ExtrapolatedAngle:
    """Return the critical angle [deg] with the step to zero, then the stiffness to infinity.

    The plastic contact unless a case says otherwise; passage route. Raise the
    first EngineError: an incomplete set of angles is not extrapolated. Raise RequestError for a
    contact that rebounds too much for a passage, before any run.
    """
    case = case or Incline(contact=PLASTIC)
    cases = (ladder or Ladder()).cases(case)
    check_passage(*cases)
    angles = critical_angles(cases, engine, fresh=fresh, stage=stage, progress=progress)
    return extrapolate(complete(angles))
