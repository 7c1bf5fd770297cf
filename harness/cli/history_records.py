"""What a single command measured, as quantities of the history.

A name says which case it is: runs of the same name can be drawn over one
another. Parameters are named where they are not the default.
"""

from __future__ import annotations

import math
from collections.abc import Hashable, Iterable, Mapping
from typing import Any

from harness.comparison.baseline_record import BaselineRecord
from harness.store.history import Quantity

MEASURED = "measured"
"""Kind of a quantity that was held against nothing."""

_INCLINE_DEFAULTS = {
    "diameter_m": 1.0,
    "density_kg_per_m3": 6.0 / math.pi,
    "gravity_m_per_s2": 9.81,
}
_TOWER_DEFAULTS = {"mass_kg": 1.0, "gravity_m_per_s2": 9.81, "base": "fixed"}
_TOWER = (
    ("impulse_Ns", "impulse, {window} window", "N s"),
    ("peak_force_N", "peak force", "N"),
    ("turnaround_s", "turnaround", "s"),
    ("energy_drift", "energy drift", ""),
)
"""Key, name and unit of what ``tower`` measures."""


def angle_quantities(record: Mapping[str, Any]) -> list[Quantity]:
    """Return the critical angle of ``critical-angle`` beside the closed form."""
    if record.get("extrapolated"):
        where = "extrapolated"
    else:
        where = (
            f"k = {record['stiffness_N_per_m']:.12g} N/m, "
            f"{record['steps_per_contact']:.12g} steps per contact"
        )
    if record.get("wells", 10) != 10:
        where += f", {record['wells']} wells"
    name = f"critical angle: {record['method']}, {_contact(record)}, {where}"
    return [
        Quantity(
            name + _others(record, _INCLINE_DEFAULTS),
            MEASURED,
            "deg",
            record["critical_angle_deg"],
            record["uncertainty_deg"],
            record.get("closed_form_deg", math.nan),
        )
    ]


def case_quantities(cases: Iterable[BaselineRecord]) -> list[Quantity]:
    """Return what cases of the baseline measured, named as their rows are."""
    return [
        Quantity(f"{case.name}: {name}", MEASURED, own.unit, own.value, own.uncertainty)
        for case in cases
        for name, own in case.quantities.items()
    ]


def tower_quantities(record: Mapping[str, Any]) -> list[Quantity]:
    """Return impulse, peak force, turnaround and energy drift of ``tower``."""
    case = (
        (
            f"{record['solver']}, {record['law']} law, n = {record['height']}, "
            f"k = {record['stiffness_N_per_m']:.12g} N/m, v0 = {record['speed_m_per_s']:.12g} m/s, "
            f"{record['duration_s'] / record['contact_time_s']:.6g} t0"
        )
        + _step(record)
        + _others(record, _TOWER_DEFAULTS)
    )
    window = record["window"]
    return [
        Quantity(f"tower: {name.format(window=window)}: {case}", MEASURED, unit, float(record[key]))
        for key, name, unit in _TOWER
    ]


def run_quantities(record: Mapping[str, Any], given: Mapping[str, Any]) -> list[Quantity]:
    """Return the quantities of ``run`` beside their references; ``given`` are values set."""
    values = "".join(f", {name} = {value}" for name, value in sorted(given.items()))
    return [
        Quantity(
            f"{record['case']}: {name}: {record['engine']}{values}",
            MEASURED,
            quantity["unit"],
            quantity["value"],
            expected=math.nan if quantity["reference"] is None else quantity["reference"],
        )
        for name, quantity in record["quantities"].items()
    ]


def impulse_quantities(
    rows: Iterable[Mapping[Hashable, Any]], solver: str, others: Mapping[str, float]
) -> list[Quantity]:
    """Return the impulse ratio of each row of ``impulse``; ``others`` are mass and gravity."""
    rest = _others(others, _TOWER_DEFAULTS)
    return [
        Quantity(
            f"impulse ratio alpha({row['height']}): {solver}, {row['law']} law, "
            f"{row['window']} window, k = {row['stiffness_N_per_m']:.12g} N/m, "
            f"v0 = {row['speed_m_per_s']:.12g} m/s{rest}",
            MEASURED,
            "",
            row["impulse_ratio"],
        )
        for row in rows
    ]


def _contact(record: Mapping[str, Any]) -> str:
    if record["contact"] != "custom":
        return f"{record['contact']} contact"
    mass = "" if record["effective_mass"] == "full" else ", half mass"
    return f"damping ratio {record['damping_ratio']:.12g}, tail {record['tail']}{mass}"


def _step(record: Mapping[str, Any]) -> str:
    return "" if record["step_s"] is None else f", step {record['step_s']:.6g} s"


def _others(record: Mapping[str, Any], defaults: Mapping[str, Any]) -> str:
    """Return what is not the default, as ``, gravity_m_per_s2 = 1.62``."""
    changed = {
        key: record[key] for key, usual in defaults.items() if record.get(key, usual) != usual
    }
    return "".join(f", {key} = {value}" for key, value in changed.items())
