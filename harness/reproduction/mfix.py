"""The incline as the source ran it in MFiX-DEM, by the reference DEM in MFiX's schemes.

The schemes and their step are those of MFiX 21.3.2, whose recorded paths and angles the reference
DEM is held against (``tests/engines/reference``).
"""

from __future__ import annotations

import math
from functools import cache

from harness.cases.incline.angle import (
    CriticalAngle,
    critical_angle,
    critical_angle_by_steady_motion,
)
from harness.cases.incline.levels import COARSE_WELLS
from harness.cases.incline.runs import follow, steady_runs
from harness.cases.incline.system import Incline, start_in_well
from harness.engines.reference import Reference
from harness.errors import RequestError
from harness.observables.reference import Trajectory
from harness.parameters.law import Contact

EULER, ADAMS_BASHFORTH = "mfix-euler", "mfix-adams-bashforth"

CONTACT = Contact(
    name="MFiX", restitution=1e-20, damping_ratio=None, tail="attractive", effective_mass="half"
)
"""The source's contact as MFiX has it: m_eff = m/2 also against a fixed sphere, not clipped."""

STIFFNESSES = (1e5, 1e6, 1e7)
"""[N/m]"""

COARSE, FINE = 50, 5000
"""``DTSOLID_FACTOR``: MFiX's default, of 4.8 steps per pi sqrt(m/k), and a hundred times it."""

PATHS = ((50, 10.20), (500, 10.20), (500, 10.22))
"""``DTSOLID_FACTOR`` and angle [deg] of the paths near the critical angle, at 1e6 N/m."""

PATH_SECONDS = 45.0
START_SPEED = 1.5  # [m/s] in a well, along the tangent of the sphere ahead
WELLS = 20  # of steady motion; more at the coarse step, where fates depend on how long one waits
BY_PASSAGE = 1000  # factor from which a passage gives the same angle, for a tenth of the steps
RESOLUTION_DEG = 1e-3


def case_at(angle: float, stiffness: float, factor: float) -> Incline:
    """Return the incline (1 m, 1 kg) at an angle [deg], k [N/m] and ``DTSOLID_FACTOR``.

    The factor divides the duration of the damped contact of m/2, which is
    pi sqrt(m/k) / sqrt(2 (1 - zeta^2)).
    """
    return Incline(
        angle=angle,
        stiffness=stiffness,
        contact=CONTACT,
        steps_per_contact=factor * math.sqrt(2.0 * (1.0 - CONTACT.zeta**2)),
        spheres=10,
    )


@cache
def angle_in_scheme(stiffness: float, factor: int, scheme: str = EULER) -> CriticalAngle | None:
    """Return the critical angle at a stiffness [N/m] and factor; None for an unstable step.

    Coarse steps by steady motion from the source's start, fine ones by passage.
    """
    wells = COARSE_WELLS if factor <= COARSE else WELLS
    case = case_at(10.2, stiffness, factor).replace(wells=wells, time_limit=100.0 * wells)
    with Reference(scheme) as engine:
        try:
            if factor >= BY_PASSAGE:
                return critical_angle(case, engine=engine)
            return critical_angle_by_steady_motion(
                lambda cases: steady_runs(engine, cases, start_in_well(case, START_SPEED)),
                case,
                tolerance_deg=RESOLUTION_DEG,
            )
        except RequestError:
            return None


@cache
def scheme_paths() -> dict[tuple[int, float], Trajectory]:
    """Return the grain's path by factor and angle [deg] of ``PATHS``, 20 steps of f = 50 a sample.

    It starts in a well, as the source's.
    """
    with Reference(EULER) as engine:
        return {
            (factor, angle): follow(
                engine,
                case := case_at(angle, 1e6, factor),
                start_in_well(case, START_SPEED),
                PATH_SECONDS,
                every=20 * factor // COARSE,
            )
            for factor, angle in PATHS
        }
