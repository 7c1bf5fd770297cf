"""The shock in the well: the part of the kinetic energy that is left after it.

In the well the velocity must turn by 60 deg: cos 60 = 1/2 of it is tangential
to the new contact and survives, sin 60 = sqrt(3)/2 is normal to it and comes
back times the restitution e. The source prints two formulas that disagree;
both readings are kept, named for what they are:

``kept``
    the shock is the energy after over the energy before;
``lost``
    the shock is built from the velocity lost, ((v' - v)/v')^2, as the source's
    equations for the shock print it. It agrees with ``kept`` at v = v'/2 only.
"""

from __future__ import annotations

import math
from typing import Literal

from harness.errors import RequestError

Reading = Literal["kept", "lost"]

SHOCK_WITHOUT_REBOUND = 0.25
"""Energy ratio of the shock at e = 0: cos(60 deg)^2."""


def shock_from_restitution(restitution: float, reading: Reading = "kept") -> float:
    """Return the shock of a rebound with normal restitution e (source, eqs. of the shock).

    Raise RequestError unless 0 <= e <= 1.
    """
    if not 0.0 <= restitution <= 1.0:
        raise RequestError(f"restitution = {restitution!r} is not allowed: must be from 0 to 1")
    return _shock(math.sqrt(0.25 + 0.75 * restitution**2), reading)


def shock_from_impulse_ratio(ratio: float, reading: Reading = "lost") -> float:
    """Return the shock when the impulse is alpha times that of a rigid base (source, eq. of alpha).

    The post-shock velocity v'/2 is rescaled by alpha = J(n)/J(1). ``lost``
    puts it into the source's shock, (1 - alpha/2)^2; ``kept`` takes it at its
    word, (alpha/2)^2. Their critical angles move in opposite directions.

    Raise RequestError unless 0 < alpha < 2, where both are between 0 and 1.
    """
    if not 0.0 < ratio < 2.0:
        raise RequestError(
            f"impulse-ratio = {ratio!r} is not allowed: must be greater than 0 and less than 2"
        )
    return _shock(ratio / 2.0, reading)


def _shock(velocity_ratio: float, reading: Reading) -> float:
    """Return the shock from v/v' in one of the two readings."""
    if reading == "kept":
        return velocity_ratio**2
    if reading == "lost":
        return (1.0 - velocity_ratio) ** 2
    raise RequestError(f"reading = {reading!r} is not allowed: must be 'kept' or 'lost'")
