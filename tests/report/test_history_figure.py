import numpy as np
import pandas as pd
import pytest

from harness.report.figures import quantity_history, release_order

RELEASES = ["22 Jul 2025 - Update 4", "29 Aug 2024 - Update 1", "2 Aug 2023 - Update 3"]


def _frame(**columns):
    usual = {
        "started": pd.date_range("2026-01-01", periods=3, tz="UTC"),
        "engine": "lammps",
        "engine_version": RELEASES,
        "how": ["in-process", "executable", "in-process"],
        "name": "angle",
        "unit": "deg",
        "value": [10.2, 10.3, 10.21],
        "uncertainty": [1e-3, np.nan, 2e-3],
        "expected": 10.2,
        "tolerance": 0.05,
        "verdict": ["pass", "fail", "pass"],
    }
    return pd.DataFrame({**usual, **columns})


def _labels(figure):
    return {text.get_text() for legend in figure.legends for text in legend.get_texts()}


@pytest.mark.parametrize("against", ["date", "version"])
def test_legend_and_axes_name_engines_band_and_unit(against):
    figure = quantity_history(_frame(), against)
    (axes,) = figure.axes
    assert axes.get_ylabel() == "value (deg)"
    assert axes.get_title() == "angle"
    assert _labels(figure) == {
        "expected", "tolerance", "fails", "lammps, in-process", "lammps, executable"
    }  # fmt: skip


def test_releases_stand_in_the_order_of_their_dates():
    (axes,) = quantity_history(_frame(), "version").axes
    shown = [tick.get_text().split("\n")[0] for tick in axes.get_xticklabels()]
    assert shown == ["2 Aug 2023", "29 Aug 2024", "22 Jul 2025"]


def test_the_order_of_releases():
    names = ["22 Jul 2025", "22 Jul 2025 - Update 1", "2 Aug 2023 - Update 3", "0.1.0"]
    assert sorted(names, key=release_order) == [names[3], names[2], names[0], names[1]]


def test_what_was_held_against_nothing_has_no_band():
    bare = _frame(expected=np.nan, tolerance=np.nan, verdict="", how="solver", engine="rk4")
    assert _labels(quantity_history(bare, "date")) == {"rk4, solver"}


@pytest.mark.parametrize("against", ["date", "version"])
def test_one_run_is_drawn_and_the_band_covers_the_axis(against):
    (axes,) = quantity_history(_frame().iloc[:1], against).axes
    low, high = axes.get_xlim()
    assert low < high
    (band,) = axes.collections[:1]
    extent = band.get_datalim(axes.transData)
    assert (extent.x0, extent.x1) == pytest.approx((low, high))
    assert (extent.y0, extent.y1) == pytest.approx((10.15, 10.25))
