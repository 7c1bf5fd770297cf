"""The page of findings: prose whose every number comes from the run."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pandas as pd

from harness.observables.windows import WINDOWS
from harness.reproduction.findings.tables import Findings
from harness.reproduction.pages.templates import templates
from harness.reproduction.run import Reproduction

TALLEST = 19
HEIGHTS = (2, 3, 4, 10, TALLEST)
LOST = "critical_angle_lost_deg"


def findings_text(found: Reproduction) -> str:
    """Return the findings as Markdown."""
    findings = found.findings
    return (
        templates()
        .get_template("findings.md.j2")
        .render(
            closed=findings.closed_form_deg,
            engine=found.provenance.engine.upper(),
            **_restitution(findings.restitution),
            **_heights(findings),
            **_mfix(findings),
        )
    )


def _restitution(frame: pd.DataFrame) -> dict[str, Any]:
    decided = list(frame[frame["reference_deg"].notna()].itertuples())
    return {
        "restitution": list(frame.itertuples()),
        "first": decided[0],
        "last": decided[-1],
        "steps": float(frame["steps_per_contact"].iloc[0]),
    }


def _heights(findings: Findings) -> dict[str, Any]:
    at = findings.at_height
    return {
        "tall": at(TALLEST, "deformable"),
        "overlap": at(TALLEST, "overlap"),
        "deformable2": at(2, "deformable"),
        "overlap2": at(2, "overlap"),
        "explained": findings.explained_by_overlap(TALLEST),
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
    at_1e6 = findings.mfix[findings.mfix["stiffness_N_per_m"] == 1e6]
    default = float(at_1e6[at_1e6["factor"] == 50]["euler_deg"].iloc[0])
    limit = findings.limits[findings.limits["stiffness_N_per_m"] == 1e6]
    return {
        "mfix": list(findings.mfix.itertuples()),
        "limits": list(findings.limits.itertuples()),
        "default_off": default - findings.closed_form_deg,
        "crossing": _crossing(at_1e6, findings.closed_form_deg),
        "limit6": float(limit["critical_angle_deg"].iloc[0]),
    }


def _crossing(frame: pd.DataFrame, angle: float) -> float:
    """Return the factor at which the angle first rises through ``angle``, NaN where it does not.

    Straight between two factors on the logarithmic axis of the figure.
    """
    ordered = frame.sort_values("factor")
    value, log = ordered["euler_deg"].to_numpy() - angle, np.log(ordered["factor"].to_numpy())
    rises = np.flatnonzero((value[:-1] <= 0) & (value[1:] > 0))
    if rises.size == 0:
        return math.nan
    i = int(rises[0])
    return math.exp(log[i] - value[i] * (log[i + 1] - log[i]) / (value[i + 1] - value[i]))
