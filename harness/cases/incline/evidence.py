"""An engine that is verified on the incline, and what its runs left for tables and figures."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from functools import partial

import numpy as np
from numpy.typing import NDArray

from harness.cases.contract import Study
from harness.cases.incline.critical_angle import CriticalAngle
from harness.cases.incline.critical_angles import critical_angle_or_error
from harness.cases.incline.extrapolation import ExtrapolatedAngle
from harness.cases.incline.levels import LEVELS, Level
from harness.cases.incline.parameters import Incline
from harness.cases.incline.records import angle_case, angle_name, in_phases
from harness.cases.incline.result import InclineRun
from harness.cases.incline.template import Route, job_of
from harness.cases.parts import Part
from harness.comparison.findings import Findings
from harness.comparison.verdicts import Check, Kind, not_tested
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

    def part(self, name: str, run: Callable[[Verifying], Sequence[Check]], rows: int = 0) -> Part:
        """Return a part that leaves so many rows at least."""
        return Part(name, partial(run, self), rows)

    def refusal(self, case: Incline, route: Route = "passage") -> str:
        """Return why the engine cannot run a case, or nothing where it can."""
        return self.engine.refuses(job_of(case, route))

    def stated(self, cases: Iterable[Incline]) -> list[Incline]:
        """Return the cases that the engine can run."""
        return [case for case in cases if not self.refusal(case)]

    def untested(
        self,
        name: str,
        case: Incline,
        route: Route = "passage",
        unit: str = "deg",
        kind: Kind = Kind.CROSS_CODE,
    ) -> list[Check]:
        """Return the row that says why the engine cannot run a case; none where it can."""
        reason = self.refusal(case, route)
        return [not_tested(name, kind, reason, unit)] if reason else []

    def angle(self, case: Incline) -> CriticalAngle | EngineError:
        """Return a critical angle by passage, measured once in a verification, or its error."""
        make = partial(critical_angle_or_error, case, engine=self.engine)
        return self.study.once((self.engine, case), make)

    def keep(
        self, cases: Sequence[Incline], angles: Sequence[CriticalAngle | EngineError], phases: int
    ) -> None:
        """Keep angles by passage as records of the baseline, and errors by their key."""
        for case, angle in zip(cases, angles, strict=True):
            if isinstance(angle, EngineError):
                name = angle_name(case, self.engine.name, "passage", in_phases(phases))
                self.found.errors[name] = angle
            else:
                self.found.records.append(angle_case(angle, in_phases(phases)))
