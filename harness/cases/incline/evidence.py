"""What the runs of a verification of the incline left, for its tables and figures."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from harness.cases.contract import Study
from harness.cases.incline.critical_angle import CriticalAngle
from harness.cases.incline.extrapolation import ExtrapolatedAngle
from harness.cases.incline.levels import LEVELS, Level
from harness.cases.incline.parameters import Incline
from harness.cases.incline.records import angle_case, angle_name, in_phases
from harness.cases.incline.result import InclineRun
from harness.cases.incline.template import Route, job_of
from harness.comparison.findings import Findings
from harness.engines.contract import Engine
from harness.errors import EngineError


@dataclass(frozen=True)
class Recursion:
    """Energy after each shock in a run, and by the recursion from the first; in m g d."""

    run: InclineRun
    measured: NDArray[np.float64]
    predicted: NDArray[np.float64]


@dataclass
class InclineEvidence:
    """What the main engine's runs of the incline left.

    ``who`` is the engine as reports write it. ``by_contact`` maps the name of a contact to its
    angles over stiffness and step.
    """

    who: str
    closed_form_deg: float
    extrapolated: ExtrapolatedAngle | None = None
    by_contact: dict[str, list[CriticalAngle]] = field(default_factory=dict)
    routes: list[CriticalAngle] = field(default_factory=list)
    motions: list[InclineRun] = field(default_factory=list)
    passages: list[InclineRun] = field(default_factory=list)
    recursion: Recursion | None = None


@dataclass(frozen=True)
class Verifying:
    """An engine under verification: how much is run, and where rows, records and runs are kept."""

    engine: Engine
    study: Study
    found: Findings
    evidence: InclineEvidence

    @property
    def level(self) -> Level:
        """Return how much is run."""
        return LEVELS[self.study.level]

    @property
    def who(self) -> str:
        """Return the engine's name as reports write it."""
        return self.evidence.who

    def refusal(self, case: Incline, route: Route = "passage") -> str:
        """Return why the engine cannot run a case, or nothing where it can."""
        return self.engine.refuses(job_of(case, route))

    def keep(
        self,
        cases: list[Incline],
        angles: list[CriticalAngle | EngineError],
        phases: int,
    ) -> None:
        """Keep angles by passage as records of the baseline, and errors by their key."""
        for case, angle in zip(cases, angles, strict=True):
            if isinstance(angle, EngineError):
                name = angle_name(case, self.engine.name, "passage", in_phases(phases))
                self.found.errors[name] = angle
            else:
                self.found.records.append(angle_case(angle, in_phases(phases)))
