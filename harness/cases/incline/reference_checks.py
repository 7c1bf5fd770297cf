"""Hold an engine against the reference DEM, on the runs that were made for other checks.

Same stiffness, step, contact and integration: only round-off may tell them apart. What the
integration itself is worth, the adaptive integrator says.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from typing import TypeVar

from harness.cases.incline import tolerances
from harness.cases.incline.critical_angle import CriticalAngle
from harness.cases.incline.critical_angles import critical_angle
from harness.cases.incline.engine_angle import OWN, reference_for
from harness.cases.incline.evidence import InclineEvidence, Verifying
from harness.cases.incline.levels import SOURCE_CASE
from harness.cases.incline.parameters import Incline
from harness.cases.incline.passage import PHASES
from harness.cases.incline.reference_paths import crests_rows, motion_rows, passage_rows
from harness.cases.incline.result import InclineRun
from harness.cases.incline.single_runs import CASES, RECURSION_CASE, passage_row
from harness.cases.parts import Part, rows_of_parts
from harness.comparison.verdicts import Check, Kind, finding, judge, not_tested
from harness.engines.reference.engine import Reference
from harness.parameters.contact import CONTACTS, PLASTIC, SOURCE

Found = TypeVar("Found")

STIFFNESSES = (1e5, 1e6, 1e7)
STEPS = {SOURCE.name: 50.0, "clipped": 50.0, PLASTIC.name: 100.0}
"""Steps per contact time at which the contacts are compared."""

MOTIONS = tuple(SOURCE_CASE.replace(angle=angle, wells=20) for angle in (10.20, 10.22))
"""At the two angles of the source's velocity figure: trapped and moving."""

ENOUGH_DIGITS = 12
"""Digits of an output below which a path says no more than a critical angle does."""


def against_the_reference(verifying: Verifying) -> list[Check]:
    """Return the rows of an engine against the reference DEM in the scheme that it declares."""
    return rows_of_parts("incline", reference_parts(verifying))


def reference_parts(verifying: Verifying) -> list[Part]:
    """Return a part for each angle and path that is compared, where the digits tell enough."""
    engine, reference = verifying.engine, reference_for(verifying.engine.traits)
    if engine.name == OWN or reference is None:
        own = "this is the reference DEM"
        reason = (
            own if engine.name == OWN else "the reference DEM does not have the engine's scheme"
        )
        untested = not_tested("incline: against the reference DEM", Kind.CROSS_CODE, reason)
        return [Part(untested.name, lambda: [untested], 1)]
    parts = list(_angle_parts(verifying, reference))
    if engine.traits.digits >= ENOUGH_DIGITS:
        parts += _path_parts(verifying, reference)
    if verifying.level.name == "full":
        rows = any(is_compared(case, SOURCE.name, 1e6) for case in _asked(verifying))
        find = partial(_angle_at, verifying.evidence, SOURCE.name, 1e6)
        worth = partial(_worth_of_the_step, verifying.who)
        parts.append(_held("what the step is worth", int(rows), find, worth))
    return parts


def _asked(verifying: Verifying) -> list[Incline]:
    """Return the cases whose angles the engine measures over stiffness and step."""
    ladder = verifying.level.ladder.cases(Incline(contact=PLASTIC))
    return verifying.stated([*ladder, *verifying.level.beside()])


def _angle_parts(verifying: Verifying, reference: Reference) -> Iterator[Part]:
    asked, level = _asked(verifying), verifying.level
    for contact, stiffness in itertools.product(CONTACTS, STIFFNESSES):
        if any(is_compared(case, contact, stiffness) for case in asked):
            name = (
                f"incline: {verifying.who} against the reference DEM, {contact} contact, "
                f"k = {stiffness:.3g} N/m"
            )
            phases = PHASES if contact == PLASTIC.name else level.phases_beside
            find = partial(_angle_at, verifying.evidence, contact, stiffness)
            yield _held(name, 1, find, partial(_angle, name, reference, phases))


def _path_parts(verifying: Verifying, reference: Reference) -> Iterator[Part]:
    evidence, who = verifying.evidence, f"{verifying.who} against the reference DEM"
    if not verifying.refusal(SOURCE_CASE, "steady"):
        for case in MOTIONS:
            name = f"incline: path at {case.angle:.2f} deg, {who}"
            find = partial(_run_of, evidence.motions, case)
            yield _held(name, 6, find, partial(motion_rows, name, reference))
    for case in verifying.stated(CASES):
        name = f"{passage_row(case)}, {who}"
        find = partial(_run_of, evidence.passages, case)
        yield _held(name, 4, find, partial(passage_rows, name, reference))
    if not verifying.refusal(RECURSION_CASE, "steady"):
        name = f"incline: crests at {RECURSION_CASE.angle:g} deg, {who}"
        yield _held(name, 3, lambda: evidence.recursion, partial(crests_rows, name, reference))


def _held(
    name: str, rows: int, find: Callable[[], Found | None], hold: Callable[[Found], list[Check]]
) -> Part:
    """Return the part that holds what the engine left, nothing where its run died."""

    def run() -> list[Check]:
        found = find()
        return [] if found is None else hold(found)

    return Part(name, run, rows)


def _run_of(runs: Sequence[InclineRun], case: Incline) -> InclineRun | None:
    return next((run for run in runs if run.case == case), None)


def _angle_at(evidence: InclineEvidence, contact: str, stiffness: float) -> CriticalAngle | None:
    angles = evidence.by_contact.get(contact, [])
    return next((angle for angle in angles if is_compared(angle.case, contact, stiffness)), None)


def is_compared(case: Incline, contact: str, stiffness: float) -> bool:
    """Return whether a case is the one of a contact and stiffness that is compared."""
    same = math.isclose(case.stiffness, stiffness, rel_tol=1e-12)
    return same and case.contact.name == contact and case.steps_per_contact == STEPS[contact]


def _angle(name: str, reference: Reference, phases: int, found: CriticalAngle) -> list[Check]:
    own = critical_angle(found.case, engine=reference, phases=phases)
    values = found.value_deg, own.value_deg
    row = judge(name, Kind.CROSS_CODE, *values, tolerances.REFERENCE_ANGLE, note=found.phases_note)
    return [row]


def _worth_of_the_step(who: str, found: CriticalAngle) -> list[Check]:
    """Report what the source's step is worth: the same contact without a step."""
    name = f"incline: the source's contact at k = 1e6 N/m, {who} against no step at all"
    exact = critical_angle(found.case, engine=Reference("adaptive"), phases=1)
    note = "held against the adaptive reference: 50 steps per contact skip the attractive tail"
    return [finding(name, found.value_deg, exact.value_deg, "deg", note, found.uncertainty_deg)]
