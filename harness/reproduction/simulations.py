"""The incline as the source simulated it: MFiX's schemes in the reference, and an engine."""

from __future__ import annotations

import math
from functools import cache

from harness.cases.bench import Bench
from harness.cases.incline.angle import angle_on, reference_measure
from harness.cases.incline.search import CriticalAngle, prepared, search
from harness.cases.incline.system import Incline, Route
from harness.errors import RequestError
from harness.model.contact import Contact
from harness.model.conventions import Rules
from harness.model.scene import Scene
from harness.reproduction.statements import Outcome, holds, statement
from harness.theory.chain import shock_from_restitution
from harness.theory.incline import critical_angle

CONTACT = Contact(name="MFiX", restitution=1e-20, effective_mass="half")  # m/2 on a fixed sphere
STIFFNESSES = (1e5, 1e6, 1e7)  # [N/m]
COARSE, FINE = 50, 5000  # ``DTSOLID_FACTOR``: MFiX's default, and a hundred times it
FROM_PASSAGE = 1000  # factor from which a passage gives the same angle for a tenth of the steps
RESOLUTION_DEG = 1e-3
WITHIN = 0.01  # [deg] "to one-hundredth of a degree"
STEPS = (50.0, 100.0, 200.0, 400.0)  # per contact time, in the engine
REBOUND = 0.1


class MfixConventions(Bench):
    """A bench without a program whose reference takes the steps of MFiX's Euler scheme."""

    def rules(self, scene: Scene) -> Rules:  # noqa: ARG002 - of every scene
        """Return the conventions of MFiX 21.3.2."""
        # spheres that just touch, as at the start, are apart
        return Rules(scheme="mfix_euler", frozen_mass="own", least_overlap=1e-15)


def mfix_case(stiffness: float, factor: int) -> Incline:
    """Return the source's incline (1 m, 1 kg) at k [N/m] and ``DTSOLID_FACTOR``.

    The factor divides the duration of the damped contact of m/2, pi sqrt(m/k) /
    sqrt(2 (1 - zeta^2)).
    """
    steps = factor * math.sqrt(2.0 * (1.0 - CONTACT.zeta**2))
    return Incline(stiffness=stiffness, contact=CONTACT, steps_per_contact=steps)


@cache
def mfix_angle(stiffness: float, factor: int) -> CriticalAngle | None:
    """Return the critical angle in MFiX's scheme, None where its step is unstable.

    Coarse steps are searched by steady motion, fine ones by passage. The source starts a grain at
    1.5 m/s, a case here at 1.503 m/s: that moves the angle of a coarse step by 1.5e-3 deg at most.
    """
    method: Route = "passage" if factor >= FROM_PASSAGE else "steady"
    try:
        case = prepared(mfix_case(stiffness, factor), method)
        return search(
            reference_measure(MfixConventions(None), method), case, method, RESOLUTION_DEG
        )
    except RequestError:
        return None


@statement("mfix-angle", "Background, on the MFiX runs, and Fig. 4",
           "the smallest angle of steady motion in MFiX is 10.21 deg to a hundredth of a degree",
           WITHIN, "deg", reason="the agreement that the source states")  # fmt: skip
def _mfix_angle() -> Outcome:
    angle = mfix_angle(1e7, COARSE)
    value, uncertainty = (angle.value, angle.uncertainty) if angle else (math.nan, 0.0)
    note = "reference in MFiX's scheme at its default step, 1e7 N/m; the source names no stiffness"
    return Outcome(value, 10.21, note=note, uncertainty=uncertainty)


@statement("mfix-validation", "Background, on the MFiX runs, and Fig. 4",
           "the agreement validates the analysis",
           reason="a refined step must not be further from the closed form",
           correction="take the step to zero first, then the stiffness to infinity")  # fmt: skip
def _mfix_validation() -> Outcome:
    def errors(factor: int) -> list[float]:
        angles = [mfix_angle(stiffness, factor) for stiffness in STIFFNESSES]
        return [math.nan if a is None else a.value - critical_angle() for a in angles]

    coarse, fine = errors(COARSE), errors(FINE)
    shown = [", ".join(f"{error:+.4f}" for error in some) for some in (coarse, fine)]
    note = f"{shown[0]} deg at the default step, {shown[1]} deg at a hundredth (1e5 to 1e7 N/m)"
    return holds(all(abs(b) <= abs(a) for a, b in zip(coarse, fine, strict=True)), note)


# ---- an engine in MFiX's place


@statement("engine-angle", "Background, on the MFiX runs; an engine in its place",
           "theta_c is 10.21 deg to a hundredth of a degree, 1e6 N/m", WITHIN, "deg",
           reason="the agreement that the source states", engine=True)  # fmt: skip
def _engine_angle(bench: Bench) -> Outcome:
    angle = angle_on(bench, Incline(steps_per_contact=STEPS[0]))
    note = "the source's contact, tail kept, 50 steps per contact, passage"
    return Outcome(angle.value, 10.21, note=note, uncertainty=angle.uncertainty)


@statement(
    "engine-step",
    "Background, on the MFiX runs; an engine in its place",
    "the angle does not depend on the step",
    WITHIN,
    "deg",
    reason="the agreement that the source states",
    engine=True,
    correction="extrapolate step and stiffness, of a contact without tail and rebound",
)
def _engine_step(bench: Bench) -> Outcome:
    angles = [angle_on(bench, Incline(steps_per_contact=steps)).value for steps in STEPS]
    note = ", ".join(f"{a:.4f} deg at {n:g}" for a, n in zip(angles, STEPS, strict=True))
    return Outcome(angles[-1], angles[0], note=f"{note} steps per contact")


@statement("engine-restitution", "Background, eqs. (6) and (9); an engine in MFiX's place",
           "at e_n = 0.1 theta_c follows from the shock of eq. (9)", 0.05, "deg",
           reason="effect of step and stiffness at 1e6 N/m", engine=True,
           correction="neither reading: rebounds end within a well, and theta_c stays")  # fmt: skip
def _engine_restitution(bench: Bench) -> Outcome:
    angle = angle_on(bench, Incline(contact=Contact(restitution=REBOUND)))
    kept, lost = (critical_angle(shock_from_restitution(REBOUND, r)) for r in ("kept", "lost"))
    note = f"{lost:.3f} deg by eq. (9), {kept:.3f} deg by 1/4 + 3/4 e^2"
    return Outcome(angle.value, lost, note=note, uncertainty=angle.uncertainty)
