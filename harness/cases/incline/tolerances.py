"""How close results of the incline must be, of checks and of the baseline: as of ``case.toml``."""

from __future__ import annotations

from harness.cases.case_text import tolerances_of

_TOLD = tolerances_of(__file__)

CLOSED_FORM = _TOLD["CLOSED_FORM"]
EXTRAPOLATED = _TOLD["EXTRAPOLATED"]
ALL_WELLS = _TOLD["ALL_WELLS"]
TWO_WAYS = _TOLD["TWO_WAYS"]
SCALES = _TOLD["SCALES"]
REFERENCE_ANGLE = _TOLD["REFERENCE_ANGLE"]
REFERENCE_PATH = _TOLD["REFERENCE_PATH"]
REFERENCE_SPEED = _TOLD["REFERENCE_SPEED"]
REFERENCE_PASSAGE = _TOLD["REFERENCE_PASSAGE"]
REFERENCE_FIRST_CRESTS = _TOLD["REFERENCE_FIRST_CRESTS"]
REFERENCE_CRESTS = _TOLD["REFERENCE_CRESTS"]
TOLD_ENERGY = _TOLD["TOLD_ENERGY"]
ENERGY_RISE = _TOLD["ENERGY_RISE"]
ADAPTIVE_RESTITUTION = _TOLD["ADAPTIVE_RESTITUTION"]
ENGINES_PLASTIC = _TOLD["ENGINES_PLASTIC"]
ENGINES_OF_ONE_CLASS = _TOLD["ENGINES_OF_ONE_CLASS"]
RECORDED = _TOLD["RECORDED"]
RIGID = _TOLD["RIGID"]

MOST_ROUTE_JITTER = 2e-3
"""[deg] a stated uncertainty may add to the resolution of a search: where in a step a contact
begins moves the angle of the source's contact by 1e-3 deg at 50 steps in the reference DEM."""

REGRESSION = tolerances_of(__file__, "regression")
"""Of the baseline's records, by quantity; ``series`` is the band about every series."""
