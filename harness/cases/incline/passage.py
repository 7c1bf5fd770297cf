"""Critical angle by *passage*: the root of the energy margin over one well.

A grain that came over the last crest at rest has, past the next shock, the
margin M(theta) over the next crest. The map of the energy from crest to crest
is increasing, so motion persists iff M >= 0: the root of M is the critical
angle. M is smooth and almost linear, so a secant needs few runs.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from itertools import pairwise

import numpy as np
from scipy.optimize import brentq, root_scalar

from harness.cases.incline.closed_forms import (
    ONE_SHOCK,
    PASSAGES,
    rebound,
    rebound_in_steps,
    theory_in_words,
)
from harness.cases.incline.critical_angle import CriticalAngle
from harness.cases.incline.parameters import Incline
from harness.cases.incline.result import InclineRun
from harness.cases.incline.routes import SPEED_AFTER_SHOCK, settled_before
from harness.errors import EngineOutputError, RequestError
from harness.theory.critical_angle import critical_angle

Measure = Callable[[Sequence[Incline]], Sequence[InclineRun]]

FIRST_ANGLES = (10.0, 10.5)
PHASES = 8

MOST_SECANTS = 12
"""A smooth margin takes three; more is a sign of a jump."""


def check_passage(*cases: Incline) -> None:
    """Raise RequestError for a contact whose rebounds go on where a passage is judged.

    What counts is the restitution that the contact has in the steps of the case.
    """
    for case in cases:
        e, steps = rebound(case.contact), case.steps_per_contact
        if e <= ONE_SHOCK:
            continue
        found = rebound_in_steps(case.contact, steps)
        if found > (most := most_restitution(case)):
            up_to = f", up to {found:.3g} at {steps:g} steps per contact" if e <= most else ""
            raise RequestError(
                "method = 'passage' needs a contact that ends the rebounds within one well, one of "
                f"restitution {most:.3g} at most at stiffness {case.stiffness:g} (here {e:.3g}"
                f"{up_to}): use method 'steady'; {theory_in_words(case.contact)}"
            )


def most_restitution(case: Incline) -> float:
    """Return the restitution up to which a passage of a contact so stiff is measured.

    The hops of rigid spheres end a contact time before the passage is judged: those of a
    spring end up to half a contact time later or earlier (found in the reference DEM at
    k d / m g of 1e4 to 1e6). In a DEM of k >= 1e5 N/m (k d / m g >= 1e4) it is judged 10 deg
    before the crest.
    """
    from harness.hard_sphere.critical_angle import hops_end

    upright = case.replace(angle=critical_angle())
    contact_way = SPEED_AFTER_SHOCK * case.contact_time * math.sqrt(case.gravity / case.diameter)
    judged = math.degrees(settled_before(upright) + contact_way)
    if hops_end(PASSAGES) >= judged:
        return PASSAGES
    return float(brentq(lambda e: hops_end(e) - judged, 0.0, PASSAGES, xtol=1e-4))


def critical_angle_by_passage(
    measure: Measure, case: Incline, *, tolerance_deg: float = 1e-3, phases: int = PHASES
) -> CriticalAngle:
    """Return the critical angle of ``case`` (whose own angle is ignored).

    ``measure`` runs inclines in the passage route. The root is found at phase
    0; then ``phases`` runs with the start shifted by fractions of a step tell
    how much the angle depends on where in a step a contact begins. The value
    is their mean, the uncertainty half their range plus the root's own.

    Raise EngineOutputError when there is no root between 0 and 30 deg, and
    RequestError when the grain was in flight: then a margin means nothing.
    """
    # both at once: an engine starts once for a batch
    runs = list(measure([case.replace(angle=angle) for angle in FIRST_ANGLES]))
    first = dict(zip(FIRST_ANGLES, (run.margin for run in runs), strict=True))
    if len(set(first.values())) == 1:
        raise EngineOutputError("the energy margin has no root: it is the same at every angle")

    def margin(angle: float) -> float:
        if angle in first:
            return first[angle]
        if not 0.0 <= angle <= 30.0:
            raise EngineOutputError(f"no critical angle between 0 and 30 deg (search at {angle:g})")
        runs.extend(measure([case.replace(angle=float(angle))]))
        return runs[-1].margin

    found = root_scalar(
        margin,
        method="secant",
        x0=FIRST_ANGLES[0],
        x1=FIRST_ANGLES[1],
        xtol=tolerance_deg / 4,
        maxiter=MOST_SECANTS,
    )
    root = float(found.root) if found.converged else _bisected(margin, runs, tolerance_deg / 4)
    slope = _slope(runs)
    shifts = np.arange(phases) / phases
    shifted = measure([case.replace(angle=root, phase=float(shift)) for shift in shifts])
    _refuse_flight(shifted)
    angles = root - np.array([run.margin for run in shifted]) / slope
    # the last correction uses a slope good to a few per cent: a tenth of it is uncertain
    root_error = 0.1 * abs(float(angles.mean()) - root)
    half_range = float(np.ptp(angles)) / 2
    return CriticalAngle.of(
        [*runs, *shifted],
        case,
        float(angles.mean()),
        uncertainty_deg=half_range + root_error,
        # the angle jumps once a step as the phase shifts: P even phases miss the mean of
        # such a sawtooth by at most its half range over P
        mean_error_deg=half_range / phases + root_error,
        method="passage",
    )


def _bisected(margin: Callable[[float], float], runs: Sequence[InclineRun], xtol: float) -> float:
    """Return where the margin changes sign between two angles that were run.

    The margin of a soft, rebounding contact jumps: a secant runs off there, a
    bracket does not. Raise EngineOutputError where no sign changes.
    """
    ordered = sorted(runs, key=lambda run: run.case.angle)
    for low, high in pairwise(ordered):
        if low.margin < 0.0 <= high.margin:
            return float(brentq(margin, low.case.angle, high.case.angle, xtol=xtol))
    raise EngineOutputError("the energy margin changes sign at no angle that was run")


def _slope(runs: Sequence[InclineRun]) -> float:
    """Return dM/dtheta [1/deg] from the two outermost angles: jitter weighs least there."""
    ordered = sorted(runs, key=lambda run: run.case.angle)
    low, high = ordered[0], ordered[-1]
    return (high.margin - low.margin) / (high.case.angle - low.case.angle)


def _refuse_flight(runs: Sequence[InclineRun]) -> None:
    if not all(run.touching for run in runs):
        raise RequestError(
            "method = 'passage' needs a contact that ends the rebounds within one well; "
            "here the grain was in flight at the crest: use method 'steady'; "
            + theory_in_words(runs[0].case.contact)
        )
