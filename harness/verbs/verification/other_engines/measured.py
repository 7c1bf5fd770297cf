"""Measure a critical angle with what its steps cost, in an engine or in the reference DEM."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from harness.comparison.tolerances import TOLERANCES, Tolerance
from harness.engines.contract import Engine
from harness.engines.traits import Traits
from harness.errors import EngineError, EngineOutputError, RequestError
from harness.observables.critical_angle import CriticalAngle
from harness.observables.incline import InclineRun
from harness.observables.passage import critical_angle_by_passage
from harness.parameters.incline import Incline
from harness.theory.energy_map import passage_margin_slope
from harness.theory.shock import SHOCK_WITHOUT_REBOUND
from harness.verbs.verification.other_engines.rules import reference_for

MARGIN_DIGITS = 1.25
"""Of the last digit, in m g d: half of one in the height and in the spring, less in the motion."""


@dataclass(frozen=True)
class Timed:
    """A critical angle and what a step of its runs cost [us].

    The least of them: starting a run and others on the machine only add to it.
    """

    angle: CriticalAngle
    microseconds: float


def timed_angle(case: Incline, engine: Engine, phases: int) -> Timed | EngineError:
    """Return the critical angle by passage with its cost, or what became of it."""
    runs: list[InclineRun] = []

    def measure(cases: Sequence[Incline]) -> list[InclineRun]:
        done = engine.measured(cases, "passage")
        runs.extend(done)
        return done

    try:
        angle = critical_angle_by_passage(measure, case, phases=phases)
    except EngineError as error:
        return error
    except RequestError as error:
        # the case is ours: a grain that flies where it should slide is the engine's doing
        return EngineOutputError(str(error))
    costs = [1e6 * run.seconds / run.steps for run in runs if run.steps > 0]
    return Timed(angle, min(costs, default=math.nan))


def same_rules(traits: Traits, off: CriticalAngle, closed_form: float) -> Tolerance:
    """Return how close an engine and the reference DEM under its rules must be [deg].

    Round-off that moves a contact's end to another step moves one phase of the mean by its
    whole range; the digits of an output are an error of the margin.
    """
    known = TOLERANCES["critical angle, reference DEM"]
    phases = max(1, len({sample.phase for sample in off.samples}))
    jitter = max(known.absolute, 2.0 * off.uncertainty_deg / phases)
    slope = passage_margin_slope(closed_form, SHOCK_WITHOUT_REBOUND)
    digits = MARGIN_DIGITS * 10.0 ** (1 - traits.digits) / slope
    why = f"{known.reason}; {traits.digits} digits of its output are worth {digits:.1g} deg"
    return Tolerance("deg", jitter + digits, 0.0, why)


class References:
    """The critical angles of the reference DEM, each set of rules run once."""

    def __init__(self, phases: int) -> None:
        self._phases = phases
        self._known: dict[tuple[str, str, Incline], CriticalAngle | EngineError | None] = {}

    def angle(self, traits: Traits, case: Incline) -> CriticalAngle | EngineError | None:
        """Return the angle under an engine's rules; None where it has no such scheme."""
        key = (traits.integrator, traits.spring, case)
        if key not in self._known:
            engine = reference_for(traits)
            found = None if engine is None else timed_angle(case, engine, self._phases)
            self._known[key] = found.angle if isinstance(found, Timed) else found
        return self._known[key]
