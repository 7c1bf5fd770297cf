"""The numbers of the page of findings, whose prose is ``findings.md.j2``: all from the run."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pandas as pd

from harness.observables.windows import WINDOWS
from harness.reproduction.findings import Findings
from harness.reproduction.run import Reproduction

TALLEST = 19
HEIGHTS = (2, 3, 4, 10, TALLEST)
LOST = "critical_angle_lost_deg"


def findings_context(found: Reproduction) -> dict[str, Any]:
    """Return what the template of the findings is filled with."""
    findings = found.findings
    decided = findings.restitution[findings.restitution["reference_deg"].notna()]
    first, *_, last = decided.itertuples()
    return {
        "closed": findings.closed_form_deg,
        "engine": found.provenance.engine.upper(),
        "restitution": list(findings.restitution.itertuples()),
        "first": first,
        "last": last,
        "steps": first.steps_per_contact,
        **_heights(findings),
        **_mfix(findings),
    }


def _heights(findings: Findings) -> dict[str, Any]:
    at, closed = findings.at_height, findings.closed_form_deg
    tall, overlap = at(TALLEST, "deformable"), at(TALLEST, "overlap")
    return {
        "tall": tall,
        "overlap": overlap,
        "deformable2": at(2, "deformable"),
        "overlap2": at(2, "overlap"),
        "explained": (closed - float(overlap[LOST])) / (closed - float(tall[LOST])),
        "windows": [
            (n, law, [_window(at(n, law, window)) for window in WINDOWS])
            for n in HEIGHTS
            for law in ("overlap", "deformable")
        ],
        "n2": {w: float(at(2, "deformable", w)[LOST]) for w in ("turnaround", "structure")},
    }


def _window(row: pd.Series) -> str:
    if math.isnan(row["impulse_ratio"]):
        return "-"
    return f"{row['impulse_ratio']:.3f}, {row[LOST]:.2f}"


def _mfix(findings: Findings) -> dict[str, Any]:
    closed = findings.closed_form_deg
    at_1e6 = findings.mfix[findings.mfix["stiffness_N_per_m"] == 1e6].set_index("factor")
    limits = findings.limits.set_index("stiffness_N_per_m")["critical_angle_deg"]
    return {
        "mfix": list(findings.mfix.itertuples()),
        "limits": list(findings.limits.itertuples()),
        "default_off": float(at_1e6["euler_deg"][50]) - closed,
        "crossing": _crossing(at_1e6["euler_deg"].sort_index() - closed),
        "limit6": float(limits[1e6]),
    }


def _crossing(off: pd.Series) -> float:
    """Return the factor, the index, at which ``off`` first rises through 0, NaN where it does not.

    Straight between two factors on the logarithmic axis of the figure.
    """
    value, log = off.to_numpy(), np.log(off.index.to_numpy())
    rises = np.flatnonzero((value[:-1] <= 0) & (value[1:] > 0))
    if rises.size == 0:
        return math.nan
    i = int(rises[0])
    return math.exp(log[i] - value[i] * (log[i + 1] - log[i]) / (value[i + 1] - value[i]))
