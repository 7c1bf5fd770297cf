"""The critical angle of rigid spheres: step to zero, then stiffness to infinity.

By passage, with the plastic contact. LAMMPS damps by the velocity of half a step ago: the angle is
of first order in the step. In the stiffness the order k^(-1/2) cancels, as the grain is pressed in
and comes back while it moves on; the error falls as 1/k with a next term k^(-3/2). With friction
so little that shocks slide, the order k^(-1/2) does not cancel: -8.5 deg zeta / sqrt(k) at
mu = 0.03, k in N/m.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import groupby
from typing import TYPE_CHECKING, Any

from pydantic import Field, model_validator

from harness.cases.bench import Bench
from harness.cases.incline.angle import Progress, angle_on, critical_angles
from harness.cases.incline.closed_form import check_passage, rigid_angle, shocks_slide
from harness.cases.incline.search import CriticalAngle, Sample, friction_text
from harness.cases.incline.system import Incline
from harness.engines.jobs import cores, parallel_map
from harness.errors import EngineError
from harness.model.base import Parameters
from harness.model.contact import PLASTIC
from harness.report.notebook import Shown
from harness.report.text import power, value_text
from harness.results.limits import Limit, limit
from harness.store.cache import EngineChoice

if TYPE_CHECKING:
    import pandas as pd

    from harness.report.style import Figure

STEP_EXPONENTS, STIFFNESS_EXPONENTS = (1.0,), (1.0, 1.5)
SLIDING_EXPONENTS = (0.5, 1.0)  # of the stiffness, where shocks slide


def extrapolated_critical_angle(
    case: Incline | None = None,
    *,
    ladder: Ladder | None = None,
    engine: EngineChoice = None,
    fresh: bool = False,
    progress: Progress | None = None,
) -> ExtrapolatedAngle:
    """Return the critical angle [deg] with the step to zero, then the stiffness to infinity.

    By passage, with the plastic contact unless a case is given. Raise the first EngineError;
    raise RequestError for a contact that rebounds too much, before any run.
    """
    case = case or Incline(contact=PLASTIC)
    cases = (ladder or Ladder()).cases(case)
    for refined in cases:
        check_passage(refined)
    angles = critical_angles(cases, engine, fresh=fresh, progress=progress)
    return extrapolate([_angle_or_raise(angle) for angle in angles])


def _angle_or_raise(angle: CriticalAngle | EngineError) -> CriticalAngle:
    if isinstance(angle, EngineError):
        raise angle
    return angle


def extrapolated_on(bench: Bench, ladder: Ladder, case: Incline) -> ExtrapolatedAngle:
    """Return the limit of the critical angle in the engine of a bench."""
    return bench.once(_extrapolated_on, bench, ladder, case)


def known_extrapolation(bench: Bench, case: Incline) -> ExtrapolatedAngle | None:
    """Return the limit of the longest ladder that was measured, None where there is none."""
    found = (
        bench.known(_extrapolated_on, bench, x, case) for x in (FULL_LADDER, Ladder(), QUICK_LADDER)
    )
    return next((angle for angle in found if angle is not None), None)


def _extrapolated_on(bench: Bench, ladder: Ladder, case: Incline) -> ExtrapolatedAngle:
    return extrapolate(parallel_map(lambda c: angle_on(bench, c), ladder.cases(case), cores()))


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
        return sorted(refined, key=lambda one: one.step)


QUICK_LADDER = Ladder(factors=(0.1, 10**-0.5, 1.0, 10**0.5), steps_per_contact=(50.0, 100.0, 200.0))
FULL_LADDER = Ladder(factors=(0.1, 10**-0.5, 1.0, 10**0.5, 10.0, 10**1.5, 100.0))


@dataclass(frozen=True, repr=False)
class ExtrapolatedAngle(Shown):
    """The critical angle of rigid spheres from an engine, with the angles behind it.

    ``at_stiffness`` has the limit in the step at each stiffness [N/m], ``rigid`` the limit of
    those in the inverse stiffness.
    """

    angles: tuple[CriticalAngle, ...]
    at_stiffness: dict[float, Limit]
    rigid: Limit

    @property
    def value(self) -> float:
        """Return the extrapolated critical angle [deg]."""
        return self.rigid.value

    @property
    def uncertainty(self) -> float:
        """Return its uncertainty [deg]."""
        return self.rigid.uncertainty

    @property
    def runs(self) -> tuple[Sample, ...]:
        """Return the runs behind the value."""
        return tuple(run for angle in self.angles for run in angle.runs)

    def to_json(self) -> dict[str, Any]:
        """Return the result, JSON-ready; stiffness and step are null: extrapolated."""
        return {
            **self.angles[0].to_json(),
            "critical_angle_deg": self.value,
            "uncertainty_deg": self.uncertainty,
            "extrapolated": True,
            "stiffness_N_per_m": None,
            "steps_per_contact": None,
            "runs": len(self.runs),
            "steps": sum(angle.steps for angle in self.angles),
            "order_in_stiffness": self.rigid.order,
            "order_in_stiffness_interval": list(self.rigid.order_interval),
            "limits": [
                {
                    "stiffness_N_per_m": stiffness,
                    "critical_angle_deg": found.value,
                    "uncertainty_deg": found.uncertainty,
                    "order_in_step": found.order,
                    "order_in_step_interval": list(found.order_interval),
                }
                for stiffness, found in self.at_stiffness.items()
            ],
            "ladder": self.to_frame().to_dict(orient="records"),
        }

    def to_frame(self) -> pd.DataFrame:
        """Return the angles as a table: stiffness, steps per contact, angle, uncertainty."""
        import pandas as pd

        return pd.DataFrame(
            {
                "stiffness_N_per_m": [a.case.stiffness for a in self.angles],
                "steps_per_contact": [a.case.steps_per_contact for a in self.angles],
                "critical_angle_deg": [a.value for a in self.angles],
                "uncertainty_deg": [a.uncertainty for a in self.angles],
            }
        )

    def summary(self) -> dict[str, str]:
        """Return the angle, the contact, the stiffnesses, the expected angle and the engine."""
        first, stiffnesses = self.angles[0], [*self.at_stiffness]
        expected, model = rigid_angle(first.case)
        return {
            "critical angle": value_text(self.value, self.uncertainty, "deg"),
            "case": f"incline, {first.case.contact.name} contact{friction_text(first.case)}, step "
            "to zero, then stiffness to infinity",
            "ladder": f"{len(self.angles)} angles, k = {power(min(stiffnesses))} to "
            f"{power(max(stiffnesses))} N/m",
            "theory": f"{expected:.5f} deg ({model})",
            "engine": first.output.provenance.label,
        }

    def draw(self) -> Figure:
        """Draw the limits in the step, and their limit in the stiffness."""
        from harness.cases.incline.figures import extrapolation

        return extrapolation(self)


def extrapolate(angles: Sequence[CriticalAngle]) -> ExtrapolatedAngle:
    """Return the limit of angles over stiffnesses and steps.

    Raise RequestError for fewer than three steps at a stiffness or fewer than four stiffnesses.
    """

    def stiffness(angle: CriticalAngle) -> float:
        return angle.case.stiffness

    ordered = sorted(angles, key=lambda a: (stiffness(a), a.case.steps_per_contact))
    limits = {k: _step_limit(list(group)) for k, group in groupby(ordered, key=stiffness)}
    values = [found.value for found in limits.values()]
    errors = [found.uncertainty for found in limits.values()]
    exponents = SLIDING_EXPONENTS if shocks_slide(angles[0].case) else STIFFNESS_EXPONENTS
    rigid = limit([1.0 / k for k in limits], values, errors, exponents)
    return ExtrapolatedAngle(tuple(ordered), limits, rigid)


def _step_limit(angles: Sequence[CriticalAngle]) -> Limit:
    steps = [1.0 / angle.case.steps_per_contact for angle in angles]
    values, errors = [a.value for a in angles], [a.mean_error for a in angles]
    return limit(steps, values, errors, STEP_EXPONENTS)
