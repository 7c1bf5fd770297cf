"""How close results of the tower must be, of checks and of the baseline: as of ``case.toml``."""

from __future__ import annotations

from harness.cases.case_text import tolerances_of
from harness.comparison.tolerances import Tolerance
from harness.parameters.tower import LAWS, Law

_TOLD = tolerances_of(__file__)

FINAL_VELOCITY = _TOLD["FINAL_VELOCITY"]
CLOSED_FORM = _TOLD["CLOSED_FORM"]
CONTACT_CHANGES = _TOLD["CONTACT_CHANGES"]
IMPULSE = _TOLD["IMPULSE"]
IMPULSE_RATIO = _TOLD["IMPULSE_RATIO"]
TALL_TOWER = _TOLD["TALL_TOWER"]
ORDER = _TOLD["ORDER"]
FINEST = _TOLD["FINEST"]
FORCE: dict[Law, Tolerance] = {law: _TOLD[f"FORCE_{law}"] for law in LAWS}

REGRESSION = tolerances_of(__file__, "regression")
"""Of the baseline's records, by quantity; ``series`` is the band about every series."""
