"""The energy argument of the source's discussion: alpha = 1/sqrt(n).

Under one force F, n equal springs in series store n times the energy of one,
``U_n = F^2 n / (2 k)``, and so take up a velocity ``v = sqrt(2 U_n / m)`` that grows
as sqrt(n) (source, eq. of the energy scaling). The velocity that the grain loses
to a row of n is taken to fall as its inverse. The springs are k each: k/n is
exact under the overlap law, not under the source's own.
"""

from __future__ import annotations

import math

from harness.errors import RequestError

LARGEST_HEIGHT = 10
"""Particles beyond which the source sees no longer contacts, and the scaling ends."""


def impulse_ratio(height: int) -> float:
    """Return alpha = 1/sqrt(n) of a tower of ``height`` n.

    Raise RequestError for a height below 1.
    """
    if height < 1:
        raise RequestError(f"height = {height!r} is not allowed: must be at least 1")
    return 1.0 / math.sqrt(height)
