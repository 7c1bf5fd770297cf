"""One passage of each contact at a fixed angle: the most sensitive runs that there are.

A critical angle is a root and forgives; the energy margin of one run is the same to
the last bit every time, and so is the path.
"""

from __future__ import annotations

from harness.cases.incline.evidence import Verifying
from harness.cases.incline.parameters import Incline
from harness.cases.incline.records import passage_case, passage_name
from harness.cases.incline.runs import run_inclines
from harness.comparison.verdicts import Check, Kind, failed_run
from harness.errors import EngineError
from harness.parameters.contact import CONTACTS, PLASTIC

ANGLE_DEG = 10.2
"""Just below the critical angle: the margin is small, and what moves it shows."""

EVERY = 10
"""Steps between the samples of the path."""

CASES = tuple(
    Incline(
        contact=contact,
        angle=ANGLE_DEG,
        stiffness=1e6,
        steps_per_contact=100.0 if contact is PLASTIC else 50.0,
    )
    for contact in CONTACTS.values()
)


def passages(verifying: Verifying) -> list[Check]:
    """Run the passages for the baseline; return a row for each that died or was refused."""
    engine, cases = verifying.engine, verifying.stated(CASES)
    rows = [row for case in CASES for row in verifying.untested(passage_row(case), case, unit="")]
    for case, run in zip(cases, run_inclines(engine, cases, "passage", every=EVERY), strict=True):
        if isinstance(run, EngineError):
            verifying.found.errors[passage_name(case, engine.name)] = run
            rows.append(failed_run(passage_row(case), Kind.CROSS_CODE, run))
        else:
            verifying.found.records.append(passage_case(run))
            verifying.evidence.passages.append(run)
    return rows


def passage_row(case: Incline) -> str:
    """Return what rows call the passage of a contact."""
    return f"incline: {case.contact.name} contact, passage at {case.angle:g} deg"
