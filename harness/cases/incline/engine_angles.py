"""Measure a critical angle, and what a step costs, in an engine or in the reference DEM."""

from __future__ import annotations

import math
from typing import Any

from harness.cases.incline.critical_angle import CriticalAngle
from harness.cases.incline.parameters import Incline
from harness.cases.incline.passage import critical_angle_by_passage
from harness.cases.incline.rules import reference_for
from harness.cases.incline.runs import measured
from harness.cases.incline.tolerances import REFERENCE_ANGLE
from harness.comparison.tolerances import Tolerance
from harness.engines.contract import Engine
from harness.engines.traits import Traits
from harness.errors import EngineError, EngineOutputError, RequestError
from harness.theory.energy_map import passage_margin_slope
from harness.theory.shock import SHOCK_WITHOUT_REBOUND

MARGIN_DIGITS = 1.25
"""Of the last digit, in m g d: half of one in the height and in the spring, less in the motion."""


LONGER = 10.0
"""How many times the steps of a critical angle a run takes that is to tell what a step costs."""


def measured_angle(case: Incline, engine: Engine, phases: int) -> CriticalAngle | EngineError:
    """Return the critical angle by passage, or what became of it."""
    try:
        return critical_angle_by_passage(
            lambda cases: measured(engine, cases, "passage"), case, phases=phases
        )
    except EngineError as error:
        return error
    except RequestError as error:
        # the case is ours: a grain that flies where it should slide is the engine's doing
        return EngineOutputError(str(error))


def microseconds_per_step(angle: CriticalAngle, engine: Engine) -> float:
    """Return what a step costs [us], without what starting a run costs; NaN if it died.

    From two runs at the critical angle that differ in their steps alone, one after the other.
    """
    short = angle.case.replace(angle=angle.value_deg)
    long = short.replace(steps_per_contact=LONGER * short.steps_per_contact)
    try:
        few, many = (measured(engine, [case], "passage")[0] for case in (short, long))
    except EngineError:
        return math.nan
    steps, seconds = many.steps - few.steps, many.seconds - few.seconds
    if steps <= 0 or seconds <= 0.0:
        return math.nan
    return 1e6 * seconds / steps


def same_rules(traits: Traits, off: CriticalAngle, closed_form: float) -> Tolerance:
    """Return how close an engine and the reference DEM under its rules must be [deg].

    Round-off that moves a contact's end to another step moves one phase of the mean by its
    whole range; the digits of an output are an error of the margin.
    """
    known = REFERENCE_ANGLE
    phases = max(1, len({sample.phase for sample in off.samples}))
    jitter = max(known.absolute, 2.0 * off.uncertainty_deg / phases)
    slope = passage_margin_slope(closed_form, SHOCK_WITHOUT_REBOUND)
    digits = MARGIN_DIGITS * 10.0 ** (1 - traits.digits) / slope
    why = f"{known.reason}; {traits.digits} digits of its output are worth {digits:.1g} deg"
    return Tolerance("deg", jitter + digits, 0.0, why)


def reference_angle(
    traits: Traits, case: Incline, phases: int, memo: dict[Any, Any]
) -> CriticalAngle | EngineError | None:
    """Return the reference DEM's angle under an engine's rules; None where it has no such scheme.

    Each set of rules is run once in a study, whose ``memo`` keeps it.
    """
    key = ("incline", traits.integrator, traits.spring, case, phases)
    if key not in memo:
        engine = reference_for(traits)
        memo[key] = None if engine is None else measured_angle(case, engine, phases)
    found: CriticalAngle | EngineError | None = memo[key]
    return found
