"""One passage of each contact at a fixed angle: the most sensitive runs that there are.

A critical angle is a root and forgives; the energy margin of one run is the same to
the last bit every time, and so is the path.
"""

from __future__ import annotations

from harness.cases.incline.parameters import Incline
from harness.cases.incline.records import passage_case, passage_name
from harness.comparison.evidence import InclineEvidence
from harness.comparison.verdicts import Check, Kind, failed_run
from harness.engines.contract import Engine
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


def passages(engine: Engine, evidence: InclineEvidence) -> list[Check]:
    """Run the passages for the baseline; return a row for each whose run died."""
    rows = []
    for case, run in zip(CASES, engine.inclines(CASES, "passage", every=EVERY), strict=True):
        name = passage_name(case, engine.name)
        if isinstance(run, EngineError):
            evidence.errors[name] = run
            what = f"incline: {case.contact.name} contact, passage at {case.angle:g} deg"
            rows.append(failed_run(what, Kind.CROSS_CODE, run))
        else:
            evidence.measured.append(passage_case(run))
    return rows
