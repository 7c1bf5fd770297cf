"""Critical angle with the step to zero first, then the stiffness to infinity.

LAMMPS's damping feels the velocity of half a step ago, so the angle is first
order in the step. In the plastic contact the grain is pressed in and comes
back while it moves on: what the spring moves cancels at order k^(-1/2), and
the bias falls as 1/k with a next term k^(-3/2).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import groupby
from typing import TYPE_CHECKING, Any

from harness.cases.incline.critical_angle import CriticalAngle
from harness.comparison.convergence import Limit, limit
from harness.shown import Shown, power, value_text
from harness.theory.critical_angle import critical_angle

if TYPE_CHECKING:
    import pandas as pd

    from harness.shown.figure import Figure

STEP_EXPONENTS = (1.0,)
STIFFNESS_EXPONENTS = (1.0, 1.5)


@dataclass(frozen=True, repr=False)
class ExtrapolatedAngle(Shown):
    """The critical angle of rigid spheres as an engine sees it, and the way there.

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

    def told(self) -> dict[str, str]:
        """Return the angle, the contact, the ladder and who climbed it."""
        first, stiffnesses = self.angles[0], [*self.at_stiffness]
        return {
            "critical angle": value_text(self.value_deg, self.uncertainty_deg, "deg"),
            "case": f"incline, {first.case.contact.name} contact, step to zero, then stiffness "
            "to infinity",
            "ladder": f"{len(self.angles)} angles, k = {power(min(stiffnesses))} to "
            f"{power(max(stiffnesses))} N/m",
            "closed form": f"{critical_angle():.5f} deg (no rebound)",
            "engine": first.provenance.told,
        }

    def drawn(self) -> Figure:
        """Draw the limits in the step, and their limit in the stiffness."""
        from harness.cases.incline.figures import extrapolation

        return extrapolation(self, critical_angle(), self.angles[0].provenance.engine)

    def record(self) -> dict[str, Any]:
        """Return the result as a JSON-ready mapping; stiffness and step are null: extrapolated."""
        return {
            **self.angles[0].record(),
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
                    "critical_angle_deg": found.value,
                    "uncertainty_deg": found.uncertainty,
                    "order_in_step": found.order,
                    "order_in_step_interval": list(found.order_interval),
                }
                for stiffness, found in self.at_stiffness.items()
            ],
            "ladder": self.frame().to_dict(orient="records"),
        }

    def frame(self) -> pd.DataFrame:
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

    Raise RequestError when the ladder has too few rungs: three steps at each
    stiffness, four stiffnesses.
    """

    def stiffness(angle: CriticalAngle) -> float:
        return angle.case.stiffness

    ordered = sorted(angles, key=lambda a: (stiffness(a), a.case.steps_per_contact))
    limits = {k: step_limit(list(group)) for k, group in groupby(ordered, key=stiffness)}
    rigid = limit(
        [1.0 / k for k in limits],
        [found.value for found in limits.values()],
        [found.uncertainty for found in limits.values()],
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
