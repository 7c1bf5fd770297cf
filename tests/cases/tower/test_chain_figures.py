from __future__ import annotations

import io

import numpy as np
import pytest

from harness.cases.tower import figures as chain_peak_error
from harness.cases.tower import figures as chain_runs
from harness.cases.tower.run import tower
from harness.parameters.tower import Tower


def drawn(figure):
    """Return whether the figure can be drawn and its axes are named."""
    target = io.BytesIO()
    figure.savefig(target, format="png", dpi=40)
    return target.tell() > 1000 and all(axes.get_ylabel() for axes in figure.axes)


@pytest.fixture(scope="module")
def runs():
    return [
        tower(Tower(height=n), solver=solver, samples=200, profiles=True)
        for n in (1, 2)
        for solver in ("exact", "rk4")
    ]


@pytest.mark.parametrize(
    "draw",
    [
        chain_runs.velocity_and_deformation,
        chain_runs.force_and_contacts,
        chain_runs.collapse,
        chain_runs.energy_drift_in_time,
    ],
)
def test_runs(draw, runs):
    figure = draw(runs)
    assert drawn(figure)
    (legend,) = figure.legends
    titles = [axes.get_title() + axes.get_title(loc="left") for axes in figure.axes]
    names = " ".join([*titles, *(text.get_text() for text in legend.get_texts())])
    assert "deformable law, exact" in names


def test_peak_error():
    steps = np.geomspace(0.01, 0.3, 8)
    figure = chain_peak_error.peak_error({"RK4": (steps, steps**5)}, {"RK4": (1 / steps, steps)})
    assert drawn(figure)
    assert "order 5.00" in figure.legends[0].get_texts()[0].get_text()
    slope, half = chain_peak_error.measured_order(steps, 3 * steps**2)
    assert slope == pytest.approx(2)
    assert half < 1e-6
