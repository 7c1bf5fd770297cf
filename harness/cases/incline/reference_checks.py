"""The third opinion: an engine against the reference DEM, on the runs that are there already.

Same stiffness, step, contact and integration: only round-off may tell them apart. What the
integration itself is worth, the adaptive integrator says.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from functools import partial

import numpy as np

from harness.cases.contract import Part, rows_of_parts
from harness.cases.incline.critical_angle import CriticalAngle
from harness.cases.incline.critical_angles import critical_angle
from harness.cases.incline.engine_angle import OWN
from harness.cases.incline.evidence import InclineEvidence, Verifying
from harness.cases.incline.given_start import follow
from harness.cases.incline.judge import COLUMNS
from harness.cases.incline.parameters import Incline
from harness.cases.incline.passage import PHASES
from harness.cases.incline.passages import EVERY, passage_row
from harness.cases.incline.result import InclineRun, Motion
from harness.cases.incline.routes import Start, margin
from harness.cases.incline.rules import reference_for
from harness.cases.incline.runs import measured, run_inclines
from harness.cases.incline.template import Route
from harness.cases.incline.tolerances import (
    ADAPTIVE_RESTITUTION,
    REFERENCE_ANGLE,
    REFERENCE_CRESTS,
    REFERENCE_FIRST_CRESTS,
    REFERENCE_PASSAGE,
    REFERENCE_PATH,
    REFERENCE_SPEED,
    TOLD_ENERGY,
)
from harness.comparison.tolerances import Tolerance
from harness.comparison.verdicts import Check, Kind, failed_run, finding, judge, not_tested
from harness.engines.reference.engine import Reference
from harness.engines.scene import LOOK
from harness.errors import EngineError, EngineOutputError
from harness.observables.trajectory import Trajectory
from harness.parameters.contact import CONTACTS, PLASTIC, SOURCE, Contact, Spring
from harness.theory.dashpot import restitution_unclipped

STIFFNESSES = (1e5, 1e6, 1e7)
STEPS = {SOURCE.name: 50.0, "clipped": 50.0, PLASTIC.name: 100.0}
"""Steps per contact time at which the contacts are compared."""

HEAD_ON = Contact(name="head-on", restitution=0.5, damping_ratio=None, tail="attractive")

PATH_TIME = 20.0
"""[sqrt(d/g)] over which paths are compared: rounding grows on every slow crest, by e a unit."""

MOTION_EVERY = 100
"""Steps between the samples of the motions that are compared."""

FIRST_CRESTS = 5
"""Crests over which round-off has not grown yet."""

ENOUGH_DIGITS = 12
"""Digits of an output below which a path says no more than a critical angle does."""


def against_the_reference(verifying: Verifying) -> list[Check]:
    """Return the rows of an engine against the reference DEM in the scheme that it declares."""
    name, traits = "incline: against the reference DEM", verifying.engine.traits
    reference = reference_for(traits)
    if reference is None or verifying.engine.name == OWN:
        reason = (
            "this is the reference DEM"
            if verifying.engine.name == OWN
            else "the reference DEM does not have the engine's scheme"
        )
        return [not_tested(name, Kind.CROSS_CODE, reason)]
    return rows_of_parts("incline", list(_parts(verifying, reference)))


def _parts(verifying: Verifying, reference: Reference) -> Iterator[Part]:
    evidence, who, level = verifying.evidence, verifying.who, verifying.level
    for contact in CONTACTS:
        for stiffness in STIFFNESSES:
            found = _angle_at(evidence, contact, stiffness)
            if found is not None:
                phases = PHASES if contact == PLASTIC.name else level.phases_beside
                name = (
                    f"incline: {who} against the reference DEM, {contact} contact, "
                    f"k = {stiffness:.3g} N/m"
                )
                yield name, partial(_angle, name, found, reference, phases)
    if verifying.engine.traits.digits >= ENOUGH_DIGITS:
        for run in evidence.motions:
            name = f"incline: path at {run.case.angle:.2f} deg, {who} against the reference DEM"
            yield name, partial(_path, name, run, reference, "steady", MOTION_EVERY)
        for run in evidence.passages:
            name = f"{passage_row(run.case)}, {who} against the reference DEM"
            yield name, partial(_path, name, run, reference, "passage", EVERY)
        if evidence.recursion is not None:
            run = evidence.recursion.run
            name = f"incline: crests at {run.case.angle:g} deg, {who} against the reference DEM"
            yield name, partial(_crests, name, run, reference)
    if level.name == "full":
        yield "what the step is worth", partial(_worth_of_the_step, evidence)


def _angle_at(evidence: InclineEvidence, contact: str, stiffness: float) -> CriticalAngle | None:
    angles = evidence.by_contact.get(contact, [])
    return next((angle for angle in angles if is_compared(angle.case, contact, stiffness)), None)


def is_compared(case: Incline, contact: str, stiffness: float) -> bool:
    """Return whether a case is the one of a contact and stiffness that is compared."""
    same = math.isclose(case.stiffness, stiffness, rel_tol=1e-12)
    return same and case.contact.name == contact and case.steps_per_contact == STEPS[contact]


def _angle(name: str, found: CriticalAngle, reference: Reference, phases: int) -> list[Check]:
    own = critical_angle(found.case, engine=reference, phases=phases)
    return [judge(name, Kind.CROSS_CODE, found.value_deg, own.value_deg, REFERENCE_ANGLE)]


def _path(
    name: str, run: InclineRun, reference: Reference, route: Route, every: int
) -> list[Check]:
    """Hold a path against the reference's at every sample of the plan, and the energy told of it.

    A steady run is followed over its first wells.
    """
    case, path = run.case, run.trajectory
    if path is None:
        raise EngineOutputError("it kept no path")
    short = case if route == "passage" else case.replace(time_limit=PATH_TIME)
    (own,) = run_inclines(reference, [short], route, every=every)
    if isinstance(own, EngineError):
        raise own
    assert own.trajectory is not None
    # a code that is judged by its samples may end between two looks
    rows = own.trajectory.time_s.size - LOOK // every
    if own.motion is not Motion.UNDECIDED and own.motion is not run.motion:
        raise EngineOutputError(f"it is {run.motion} where the reference DEM is {own.motion}")
    late = path.time_s[:rows].size < rows or not np.allclose(
        path.time_s[:rows], own.trajectory.time_s[:rows], rtol=0.0, atol=0.5 * case.step
    )
    if late:
        raise EngineOutputError(
            f"its path of {path.time_s.size} samples does not have the {rows} times of the plan"
        )
    x, y, vx, vy = (
        getattr(path, column)[:rows] - getattr(own.trajectory, column)[:rows]
        for column in ("x_m", "y_m", "vx_m_per_s", "vy_m_per_s")
    )
    apart = float(np.hypot(x, y).max()) / case.diameter
    faster = float(np.hypot(vx, vy).max()) / math.sqrt(case.gravity * case.diameter)
    near, slow = REFERENCE_PATH, REFERENCE_SPEED
    if route == "passage":
        near = slow = REFERENCE_PASSAGE
    rows_of_path = [
        judge(f"{name}, largest distance", Kind.CROSS_CODE, apart, 0.0, near),
        judge(f"{name}, largest velocity apart", Kind.CROSS_CODE, faster, 0.0, slow),
        _told_energy(name, run, path, reference.traits.spring),
    ]
    if route == "steady":
        first = min(FIRST_CRESTS, own.crests.time_s.size)
        return [*rows_of_path, *_at_crests(name, run, own, [(first, REFERENCE_FIRST_CRESTS)])]
    return rows_of_path


def _told_energy(name: str, run: InclineRun, path: Trajectory, spring: Spring) -> Check:
    """Hold the energy that a run tells of against that of the last sample of its path."""
    case = run.case
    well = max(1, run.crests.time_s.size + (run.motion is not Motion.MOVES_ON))
    x, y, vx, vy = (float(getattr(path, column)[-1]) for column in COLUMNS[1:])
    return judge(
        f"{name}, energy told and of its path",
        Kind.CROSS_CODE,
        run.margin_J / case.weight_energy,
        margin(case, well, x, y, vx, vy, spring) / case.weight_energy,
        TOLD_ENERGY,
    )


def _crests(name: str, run: InclineRun, reference: Reference) -> list[Check]:
    """Hold energy and time at every crest against the reference's."""
    (own,) = measured(reference, [run.case], "steady")
    count = own.crests.time_s.size
    if run.crests.time_s.size != count:
        raise EngineOutputError(
            f"it passed {run.crests.time_s.size} crests, the reference DEM {count}"
        )
    held = [(FIRST_CRESTS, REFERENCE_FIRST_CRESTS), (count, REFERENCE_CRESTS)]
    return _at_crests(name, run, own, held)


def _at_crests(
    name: str, run: InclineRun, own: InclineRun, held: Sequence[tuple[int, Tolerance]]
) -> list[Check]:
    """Return the rows of the energy at so many crests as are held, and of the time at the most."""
    count = held[-1][0]
    if run.crests.time_s.size < count:
        raise EngineOutputError(f"it passed {run.crests.time_s.size} crests of {count}")
    ours, theirs = run.crests, own.crests
    energy = np.abs(ours.margin_J[:count] - theirs.margin_J[:count]) / run.case.weight_energy
    time = np.abs(ours.time_s[:count] - theirs.time_s[:count]) / run.case.step
    step = Tolerance("steps", 0.5, 0.0, "the same steps in two codes, counted")
    rows = [(f"energy, the worst of {some}", energy[:some], width) for some, width in held]
    return [
        judge(f"{name}, {what}", Kind.CROSS_CODE, float(apart.max(initial=0.0)), 0.0, width)
        for what, apart, width in [*rows, (f"time, the worst of {count}", time, step)]
    ]


def _worth_of_the_step(evidence: InclineEvidence) -> list[Check]:
    """Report what the source's step is worth: the same contact without a step."""
    found = _angle_at(evidence, SOURCE.name, 1e6)
    if found is None:
        return []
    name = f"incline: the source's contact at k = 1e6 N/m, {evidence.who} against no step at all"
    exact = critical_angle(found.case, engine=Reference("adaptive"), phases=1)
    note = "held against the adaptive reference: 50 steps per contact skip the attractive tail"
    return [finding(name, found.value_deg, exact.value_deg, "deg", note, found.uncertainty_deg)]


def restitution_checks() -> list[Check]:
    """Hold a head-on collision of the adaptive reference against the closed form."""
    name = "reference DEM: restitution head-on, adaptive"
    case = Incline(angle=0.0, contact=HEAD_ON, gravity=1e-12)
    start = Start(0.0, case.diameter * (1.0 + 1e-6), 0.0, -1.0)
    try:
        path = follow(Reference("adaptive"), case, start, 3.0 * case.contact_time, every=150)
    except EngineError as error:
        return [failed_run(name, Kind.ANALYTIC, error)]
    return [
        judge(
            name,
            Kind.ANALYTIC,
            float(path.vy_m_per_s[-1]),
            restitution_unclipped(HEAD_ON.zeta),
            ADAPTIVE_RESTITUTION,
        )
    ]
