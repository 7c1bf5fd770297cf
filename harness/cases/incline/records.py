"""Critical angles, and passages at a fixed angle, as records of the baseline."""

from __future__ import annotations

from harness.cases.grain import COLUMNS
from harness.cases.incline.critical_angle import CriticalAngle
from harness.cases.incline.extrapolation import ExtrapolatedAngle
from harness.cases.incline.parameters import Incline
from harness.cases.incline.result import InclineRun
from harness.cases.incline.template import NAME
from harness.comparison.baseline_record import BaselineRecord, Quantity, made_by
from harness.comparison.divergence import Series

NOT_OF_AN_ANGLE = {"angle", "phase"}
"""What a search for the critical angle sets itself."""


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
