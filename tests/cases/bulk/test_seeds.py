"""Curves of bulk runs: their columns in a table."""

import math

import numpy as np
import pytest

from harness.cases import drum, penetration, silo
from harness.cases.registry import get_case
from harness.engines.output import Output
from harness.observables.provenance import Provenance


def profile(name, series):
    """Return the profile of a run that left a series."""
    case = get_case(name)
    return case.profile(case.default, Output((), Provenance("lammps", "1"), {"series": series}))


def test_curves_of_the_silo_and_of_the_sphere_are_columns_of_the_series():
    t = np.linspace(0.0, 1.0, 5)
    assert profile("silo", dict.fromkeys(silo.COLUMNS, t) | {"remaining": 9 * t}) == {
        "time_s": t.tolist(),
        "remaining": (9 * t).tolist(),
    }
    fall = dict.fromkeys(penetration.COLUMNS, t) | {"z_m": 0.1 - t**2, "vz_m_per_s": -2 * t}
    found = profile("penetration", fall)
    assert list(found) == ["time_s", "height_m", "velocity_m_per_s", "deceleration_m_per_s2"]
    assert found["height_m"] == (0.1 - t**2).tolist()
    # its velocity grows downward by 2 m/s in each second
    assert found["deceleration_m_per_s2"] == pytest.approx([-2.0] * 5)


def test_the_drum_has_both_kinds_in_both_quadrants_over_the_turn():
    p = drum.Drum()
    steps = p.settle_steps + p.every * np.arange(5)
    rise = np.linspace(0.0, 1.0, p.grains)[:, None] < np.arange(5) / 4  # more from row to row
    x, z = np.where(rise, -1e-3, 1e-3).T, np.where(rise, 1e-3, -1e-3).T
    found = profile("drum", {"step": steps, "x_m": x, "y_m": 0 * x, "z_m": z})
    assert {len(values) for values in found.values()} == {5}
    assert found["turned_deg"][0] == 0.0
    assert found["turned_deg"][-1] == pytest.approx(
        math.degrees(4 * p.every * p.step_size * p.speed)
    )
    large, small = p.large_grains, p.small_grains
    rising = [rise[:large, row].mean() for row in range(5)]
    assert found["large_rising_ratio"] == pytest.approx(rising)
    assert found["large_falling_ratio"] == pytest.approx([1 - share for share in rising])
    rising = [rise[large:, row].sum() / small for row in range(5)]
    assert found["small_rising_ratio"] == pytest.approx(rising)
    assert found["small_falling_ratio"] == pytest.approx([1 - share for share in rising])
