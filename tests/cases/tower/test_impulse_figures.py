"""Figures of impulses and angles: what they draw is the table that they are given."""

import numpy as np
import pytest

from harness.cases.tower import figures
from harness.cases.tower.impulse import (
    STATE_POINTS,
    energy_scaling_angles,
    impulse_angles,
    impulse_by_gamma,
)
from harness.observables.reference import PEYNEAU_ROUX, ReferencePoints

REFERENCE = ReferencePoints("made-up.csv", (2.0, 9.5), (9.0, 6.5))


@pytest.fixture(scope="module")
def frame():
    return impulse_angles(
        heights=range(1, 5), windows=("turnaround", "structure", "first-contact"), solver="exact"
    )


@pytest.fixture(scope="module")
def by_gamma():
    return impulse_by_gamma(np.geomspace(1e-3, 1e-2, 3), heights=(1, 2, 3), ways=STATE_POINTS)


def texts(figure):
    """Return all that titles and legends say."""
    legends = [t.get_text() for legend in figure.legends for t in legend.get_texts()]
    return "\n".join([*legends, *(axes.get_title() for axes in figure.axes)])


def test_ratio_against_height(frame):
    figure = figures.ratio_against_height(frame, "exact")
    said = texts(figure)
    for law in ("overlap", "deformable"):
        for window in ("turnaround", "structure", "first-contact"):
            assert f"{law} law, {window} window, exact" in said
    assert said.count("v0 = ") == 6
    assert "k = 1e5 N/m, v0 = 2 m/s, Gamma = 0.016" in said
    drawn = [line for line in figure.axes[0].get_lines() if len(line.get_xdata()) == 4]
    assert len(drawn) == 6


def test_critical_angle_against_height_names_every_choice(frame):
    figure = figures.critical_angle_against_height(
        frame, solver="exact", published=PEYNEAU_ROUX, reference=REFERENCE
    )
    said = texts(figure)
    for words in (
        "reading: velocity lost, sqrt(shock) = 1 - alpha/2",
        "reading: velocity kept, sqrt(shock) = alpha/2",
        "5.76 ± 0.22 deg\n(Peyneau and Roux, Phys. Rev. E 78, 011307 (2008))",
        "reference: made-up.csv",
    ):
        assert words in said


def test_collapse_on_gamma(by_gamma):
    figure = figures.collapse_on_gamma(by_gamma, "rk4", (2, 3))
    said = texts(figure)
    assert "n = 2\nn = 3\n" in said
    assert said.count(" kg, g = ") == 3


def test_map_over_gamma(by_gamma):
    figure = figures.map_over_gamma(by_gamma[by_gamma["mass_kg"] == 1.0], "rk4", [2e-3, 5e-3])
    assert "Gamma of the source's runs" in texts(figure)
    (mesh,) = (m for m in figure.axes[0].collections if m.get_array() is not None)
    assert mesh.get_array().shape == (3, 3)


def test_energy_scaling():
    figure = figures.energy_scaling(energy_scaling_angles(range(1, 20)), PEYNEAU_ROUX)
    said = texts(figure)
    assert "its angle at 10 particles, 2.64 deg" in said
    assert "5.76 ± 0.22 deg" in said


@pytest.mark.parametrize("law", ["overlap", "deformable"])
def test_every_point_of_every_panel_lies_within_the_axes(law):
    """Whichever law has the largest angles: a limit set before the last panel hid two of them."""
    table = impulse_angles(heights=(1, 2, 3), stiffnesses=(1e6,), speeds=(2.0,), solver="exact")
    table.loc[table["law"] == law, "critical_angle_lost_deg"] *= 1.5
    figure = figures.critical_angle_against_height(table, readings=("lost",), solver="exact")
    for axes in figure.axes:
        low, high = axes.get_ylim()
        assert low == 0
        for line in axes.get_lines():
            points = np.asarray(line.get_ydata(), dtype=float)
            assert np.nanmax(points, initial=0.0) <= high
