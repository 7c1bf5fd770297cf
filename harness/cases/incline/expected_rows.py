"""How many rows a verification of the incline leaves: completeness is a verdict."""

from __future__ import annotations

from harness.cases.contract import LevelName
from harness.cases.incline.checks import NEAR_CRITICAL_DEG
from harness.cases.incline.engine_angle import OWN
from harness.cases.incline.levels import LEVELS, SOURCE_CASE, SOURCE_CLIPPED, Level
from harness.cases.incline.parameters import Incline
from harness.cases.incline.passages import CASES
from harness.cases.incline.recursion import RECURSION_CASE
from harness.cases.incline.reference_checks import ENOUGH_DIGITS, STEPS, STIFFNESSES, is_compared
from harness.cases.incline.rules import reference_for
from harness.cases.incline.template import Route, job_of
from harness.engines.contract import Engine
from harness.parameters.contact import PLASTIC

OF_A_PASSAGE, OF_A_MOTION, OF_A_RECURSION = 3, 5, 3
"""Rows of one such run beside the reference DEM."""


def expected_rows(name: LevelName, engine: Engine) -> int:
    """Return how many rows a level leaves for an engine; one for each run that it refuses."""
    level = LEVELS[name]

    def stated(case: Incline, route: Route = "passage") -> bool:
        return not engine.refuses(job_of(case, route))

    source = stated(SOURCE_CASE)
    return sum(
        (
            1 + stated(Incline(contact=PLASTIC)),
            sum(not stated(case) for case in level.beside()),
            2 if source and stated(SOURCE_CASE.replace(contact=SOURCE_CLIPPED)) else 1,
            len(level.routes),
            1 + stated(RECURSION_CASE, "steady"),
            not stated(SOURCE_CASE, "steady"),
            2,  # scales
            1,  # ways to run it
            sum(not stated(case) for case in CASES),
            _beside_the_reference(level, engine, [case for case in CASES if stated(case)]),
        )
    )


def _beside_the_reference(level: Level, engine: Engine, passages: list[Incline]) -> int:
    """Return the rows beside the reference DEM: angles, and paths where the digits tell enough."""
    if reference_for(engine.traits) is None or engine.name == OWN:
        return 1
    asked = [*level.ladder.cases(Incline(contact=PLASTIC)), *level.beside()]
    run = [case for case in asked if not engine.refuses(job_of(case, "passage"))]
    rows = sum(
        any(is_compared(case, contact, stiffness) for case in run)
        for contact in STEPS
        for stiffness in STIFFNESSES
    )
    if level.name == "full":
        rows += any(is_compared(case, SOURCE_CASE.contact.name, 1e6) for case in run)
    if engine.traits.digits < ENOUGH_DIGITS:
        return rows
    if not engine.refuses(job_of(SOURCE_CASE, "steady")):
        rows += OF_A_MOTION * len(NEAR_CRITICAL_DEG)
    if not engine.refuses(job_of(RECURSION_CASE, "steady")):
        rows += OF_A_RECURSION
    return rows + OF_A_PASSAGE * len(passages)
