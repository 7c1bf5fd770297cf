"""An engine that is verified on the incline: its evidence for tables and figures, its records."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from functools import partial

import numpy as np
from numpy.typing import NDArray

from harness.cases.contract import Study
from harness.cases.grain import COLUMNS
from harness.cases.incline.critical_angle import CriticalAngle
from harness.cases.incline.critical_angles import critical_angle_or_error
from harness.cases.incline.extrapolation import ExtrapolatedAngle
from harness.cases.incline.levels import LEVELS, Level
from harness.cases.incline.parameters import Incline
from harness.cases.incline.result import InclineRun
from harness.cases.incline.template import NAME, Route, job_of
from harness.cases.parts import Part
from harness.comparison.baseline_record import BaselineRecord, Quantity, made_by
from harness.comparison.divergence import Series
from harness.comparison.findings import Findings
from harness.comparison.verdicts import Check, Kind, not_tested
from harness.engines.contract import Engine
from harness.errors import EngineError

NOT_OF_AN_ANGLE = {"angle", "phase"}
"""What a search for the critical angle sets itself."""


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


def short(value: float) -> str:
    """Return a number for the name of a file: ``1e6``, ``3.16e5``, ``200``."""
    text = f"{value:.3g}" if value < 1e4 else f"{value:.3g}".replace("e+0", "e").replace("e+", "e")
    return text if "e" in text or value < 1e4 else f"{value:.2e}".replace("e+0", "e")


def in_phases(phases: int) -> str:
    """Return the resolution of a passage: over how many starts within a step it is averaged."""
    return f"{phases}-phases"


def angle_name(case: Incline, engine: str, method: str, resolution: str) -> str:
    """Return the name of a critical angle; ``resolution`` as in ``8-phases`` or ``0.001-deg``."""
    contact = case.contact.name.replace(", ", "-").replace(" ", "-")
    return (
        f"{engine}/incline-{method}-{contact}-k{short(case.stiffness)}"
        f"-{case.steps_per_contact:g}-steps-{resolution}"
    )


def angle_case(angle: CriticalAngle, resolution: str) -> BaselineRecord:
    """Return a critical angle as a record."""
    who = angle.provenance
    own = angle.case.model_dump(mode="json", exclude=NOT_OF_AN_ANGLE)
    return BaselineRecord(
        name=angle_name(angle.case, who.engine, angle.method, resolution),
        parameters={**own, "method": angle.method, "resolution": resolution},
        quantities={"critical_angle_deg": Quantity(angle.value_deg, angle.uncertainty_deg, "deg")},
        case=NAME,
        label=(
            f"{angle.method}, {angle.case.contact.name}, k = {short(angle.case.stiffness)} N/m, "
            f"{angle.case.steps_per_contact:g} steps, {resolution.replace('-', ' ')}"
        ),
        family=(angle.case.contact.name,),
        **made_by(who),
    )


def extrapolated_case(found: ExtrapolatedAngle, rungs: list[CriticalAngle]) -> BaselineRecord:
    """Return an extrapolated critical angle as a record, with the rungs that it stands on."""
    first = rungs[0]
    contact = first.case.contact
    ladder = sorted((a.case.stiffness, a.case.steps_per_contact) for a in rungs)
    fixed = {*NOT_OF_AN_ANGLE, "stiffness", "steps_per_contact"}
    return BaselineRecord(
        name=f"{first.provenance.engine}/incline-extrapolated-{contact.name}-{len(rungs)}-rungs",
        parameters={
            **first.case.model_dump(mode="json", exclude=fixed),
            "stiffness_and_steps_per_contact": [list(rung) for rung in ladder],
        },
        quantities={
            "extrapolated_angle_deg": Quantity(found.value_deg, found.uncertainty_deg, "deg")
        },
        case=NAME,
        label=f"extrapolated, {contact.name}, {len(rungs)} rungs",
        family=(contact.name,),
        **made_by(first.provenance),
    )


def passage_name(case: Incline, engine: str) -> str:
    """Return the name of one passage at a fixed angle."""
    return f"{engine}/incline-path-{case.contact.name}-{case.angle:g}-deg"


def passage_case(run: InclineRun) -> BaselineRecord:
    """Return one passage as a case: margin, and the path as a series.

    ``step_s`` is taken from the run's own end, time over steps, not from what was asked.
    """
    path, case = run.trajectory, run.case
    columns = {} if path is None else {name: getattr(path, name) for name in COLUMNS[1:]}
    return BaselineRecord(
        name=passage_name(case, run.provenance.engine),
        parameters=case.model_dump(mode="json"),
        quantities={
            "margin_over_mgd": Quantity(run.margin, 0.0, ""),
            "step_s": Quantity(run.time_s / max(run.steps, 1), 0.0, "s"),
        },
        case=NAME,
        label=f"path, {case.contact.name}, {case.angle:g} deg",
        family=(case.contact.name,),
        series=None if path is None else Series(path.time_s, columns),
        **made_by(run.provenance),
    )
