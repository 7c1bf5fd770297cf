"""Materials that several cases share."""

from __future__ import annotations

import math

UNIT_MASS_DENSITY = 6.0 / math.pi
"""[kg/m3] gives a sphere of 1 m the mass of 1 kg, as in the source."""
