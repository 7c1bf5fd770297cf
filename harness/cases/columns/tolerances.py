"""How close results of columns must be: as of ``case.toml``, which says why."""

from __future__ import annotations

from harness.cases.case_text import tolerances_of

_TOLD = tolerances_of(__file__)

ONE = _TOLD["ONE"]
TWO_CODES = _TOLD["TWO_CODES"]
RIGID = _TOLD["RIGID"]
FIRST_ORDER = _TOLD["FIRST_ORDER"]
