"""The critical angle as an observable: one result type for theory, solver and engine."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from harness.cases.incline.parameters import Incline
from harness.cases.incline.result import InclineRun
from harness.observables.provenance import Provenance
from harness.shown import Shown, power, value_text

if TYPE_CHECKING:
    import pandas as pd

    from harness.shown.figure import Figure


@dataclass(frozen=True)
class Sample:
    """One run on the way to a critical angle; margin in units of m g d."""

    angle_deg: float
    phase: float
    motion: str
    margin: float


@dataclass(frozen=True, repr=False)
class CriticalAngle(Shown):
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
            **more,
        )

    @property
    def phases(self) -> int:
        """Return how many starts within a step the value is the mean of."""
        return max(1, len({sample.phase for sample in self.samples}))

    @property
    def phases_note(self) -> str:
        """Return, for a row, what tells a value of a passage from others at the same steps."""
        if self.method != "passage":
            return ""
        return (
            f"mean over {self.phases} starts within a step; over another number of them it is "
            f"another mean, by up to {self.mean_error_deg:.1g} deg"
        )

    def record(self) -> dict[str, Any]:
        """Return the result as a flat JSON-ready mapping (keys of the command line)."""
        case = self.case
        return {
            "critical_angle_deg": self.value_deg,
            "uncertainty_deg": self.uncertainty_deg,
            "method": self.method,
            "stiffness_N_per_m": case.stiffness,
            "steps_per_contact": case.steps_per_contact,
            "contact": case.contact.name,
            "restitution": case.contact.restitution,
            "damping_ratio": case.contact.zeta,
            "tail": case.contact.tail,
            "effective_mass": case.contact.effective_mass,
            "diameter_m": case.diameter,
            "density_kg_per_m3": case.density,
            "gravity_m_per_s2": case.gravity,
            **({"wells": case.wells} if self.method == "steady" else {}),
            "monotone": self.monotone,
            "note": self.note,
            "runs": len(self.samples),
            "steps": self.steps,
            **self.provenance.record(),
        }

    def frame(self) -> pd.DataFrame:
        """Return the runs behind the value as a table, sorted by angle."""
        import pandas as pd

        return pd.DataFrame([vars(s) for s in self.samples]).sort_values("angle_deg")

    def told(self) -> dict[str, str]:
        """Return the angle, the case and who measured it."""
        case = self.case
        return {
            "critical angle": value_text(self.value_deg, self.uncertainty_deg, "deg"),
            "case": f"incline, {case.contact.name} contact, k = {power(case.stiffness)} N/m, "
            f"{case.steps_per_contact:g} steps per contact time",
            "method": f"{self.method}, {len(self.samples)} runs",
            "engine": self.provenance.told,
            **({"note": self.note} if self.note else {}),
        }

    def drawn(self) -> Figure:
        """Draw what is left of the energy over the next crest (or the fate) of each run."""
        from harness.cases.incline.figures import runs_of_an_angle

        return runs_of_an_angle(self)
