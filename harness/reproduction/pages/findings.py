"""The page of findings: prose whose every number comes from the run."""

from __future__ import annotations

import math
from importlib import resources
from typing import Any

import numpy as np
import pandas as pd

from harness.observables.windows import WINDOWS
from harness.reproduction.run import Reproduction

TALLEST = 19
HEIGHTS = (2, 3, 4, 10, TALLEST)
LOST = "critical_angle_lost_deg"


def findings_text(found: Reproduction) -> str:
    """Return the findings as Markdown."""
    from jinja2 import Environment, StrictUndefined

    source = resources.files("harness.reproduction").joinpath("templates", "findings.md.j2")
    environment = Environment(undefined=StrictUndefined, trim_blocks=True, autoescape=False)
    environment.filters |= {"angle": _angle, "signed": _signed, "measured": _measured}
    template = environment.from_string(source.read_text(encoding="utf-8"))
    return template.render(
        closed=found.findings.closed_form_deg,
        engine=f"{found.provenance.engine.upper()}",
        **_restitution(found),
        **_heights(found),
        **_mfix(found),
    )


def _restitution(found: Reproduction) -> dict[str, Any]:
    frame = found.findings.restitution
    decided = frame[frame["reference_deg"].notna()]
    return {
        "restitution": list(frame.itertuples()),
        "first": next(decided.itertuples()),
        "last": list(decided.itertuples())[-1],
        "steps": float(frame["steps_per_contact"].iloc[0]),
    }


def _heights(found: Reproduction) -> dict[str, Any]:
    findings = found.findings
    pairs = [(n, law) for n in HEIGHTS for law in ("overlap", "deformable")]
    return {
        "tall": findings.at_height(TALLEST, "deformable"),
        "overlap": findings.at_height(TALLEST, "overlap"),
        "deformable2": findings.at_height(2, "deformable"),
        "overlap2": findings.at_height(2, "overlap"),
        "explained": findings.explained_by_overlap(TALLEST),
        "windows": [
            (n, law, [_window(findings.at_height(n, law, window)) for window in WINDOWS])
            for n, law in pairs
        ],
        "n2": {
            window: float(findings.at_height(2, "deformable", window)[LOST])
            for window in ("turnaround", "structure")
        },
    }


def _window(row: pd.Series) -> str:
    if math.isnan(row["impulse_ratio"]):
        return "-"
    return f"{row['impulse_ratio']:.3f}, {row[LOST]:.2f}"


def _mfix(found: Reproduction) -> dict[str, Any]:
    findings = found.findings
    rows = [
        {
            "k": _power(row["stiffness_N_per_m"]),
            "factor": f"{row['factor']:g}",
            "euler": _measured(row["euler_deg"], row["euler_uncertainty_deg"]),
            "recorded": _measured(row["recorded_deg"], math.nan),
            "adams": _measured(row["adams_bashforth_deg"], row["adams_bashforth_uncertainty_deg"]),
        }
        for _, row in findings.mfix.iterrows()
    ]
    limits = [
        {
            "k": _power(row["stiffness_N_per_m"]),
            "angle": _angle(row["critical_angle_deg"], 3),
            "value": float(row["critical_angle_deg"]),
        }
        for _, row in findings.limits.iterrows()
    ]
    at_1e6 = findings.mfix[findings.mfix["stiffness_N_per_m"] == 1e6]
    default = float(at_1e6[at_1e6["factor"] == 50]["euler_deg"].iloc[0])
    limit = findings.limits[findings.limits["stiffness_N_per_m"] == 1e6]
    return {
        "mfix": rows,
        "limits": limits,
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


def _power(stiffness: float) -> str:
    return f"{stiffness:.0e}".replace("e+0", "e")


def _angle(value: float, digits: int) -> str:
    return "-" if math.isnan(value) else f"{value:.{digits}f}"


def _signed(value: float, digits: int) -> str:
    return f"{value:+.{digits}f}"


def _measured(value: float, uncertainty: float) -> str:
    """Return a value with its uncertainty, to the digits that the uncertainty leaves."""
    if math.isnan(value):
        return "-"
    return f"{value:.3f}" if math.isnan(uncertainty) else f"{value:.3f} ± {uncertainty:.1g}"
