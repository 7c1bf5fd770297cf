from __future__ import annotations

import io

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
    """Draw the figure; return all that its titles and legends say."""
    target = io.BytesIO()
    figure.savefig(target, format="png", dpi=40)
    assert target.tell() > 1000
    legends = [t.get_text() for legend in figure.legends for t in legend.get_texts()]
    return "\n".join([*legends, *(axes.get_title() for axes in figure.axes)])


def labelled(figure):
    """Return the names of all axes of the outer panels."""
    return {axes.get_xlabel() for axes in figure.axes} | {a.get_ylabel() for a in figure.axes}


def test_ratio_against_height(frame):
    figure = figures.ratio_against_height(frame, "exact")
    said = texts(figure)
    for law in ("overlap", "deformable"):
        for window in ("turnaround", "structure", "first-contact"):
            assert f"{law} law, {window} window, exact" in said
    assert said.count("v0 = ") == 6
    assert "k = 1e5 N/m, v0 = 2 m/s, Gamma = 0.016" in said
    assert {"height n (contacts)", "impulse ratio alpha = J(n) / J(1)"} <= labelled(figure)
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
    assert "critical angle (deg)" in labelled(figure)


def test_one_reading_alone_without_what_others_found(frame):
    said = texts(figures.critical_angle_against_height(frame, readings=("kept",), solver="rk4"))
    assert "velocity kept" in said
    assert "velocity lost" not in said
    assert "Peyneau" not in said


def test_collapse_on_gamma(by_gamma):
    figure = figures.collapse_on_gamma(by_gamma, "rk4", (2, 3))
    said = texts(figure)
    assert "n = 2\nn = 3\n" in said
    assert said.count(" kg, g = ") == 3
    assert "Gamma = m g / (v0 sqrt(k m))" in labelled(figure)


def test_map_over_gamma(by_gamma):
    figure = figures.map_over_gamma(by_gamma[by_gamma["mass_kg"] == 1.0], "rk4", [2e-3, 5e-3])
    assert "Gamma of the source's runs" in texts(figure)
    (mesh,) = (m for m in figure.axes[0].collections if m.get_array() is not None)
    assert mesh.get_array().shape == (3, 3)
    assert mesh.get_cmap().name == "cividis"
    assert "impulse ratio alpha = J(n) / J(1)" in labelled(figure)


def test_lightness_of_the_map_rises_all_the_way():
    """So the map reads in grey."""
    import matplotlib as mpl

    red, green, blue, _ = mpl.colormaps["cividis"](np.linspace(0, 1, 64)).T
    assert (np.diff(0.2126 * red + 0.7152 * green + 0.0722 * blue) > 0).all()


def test_map_without_marks_or_with_gaps(by_gamma):
    gaps = by_gamma[by_gamma["mass_kg"] == 1.0].copy()
    gaps.loc[gaps["height"] == 2, "impulse_ratio"] = np.nan
    assert "source" not in texts(figures.map_over_gamma(gaps, "rk4"))


@pytest.mark.parametrize("reference", [None, REFERENCE])
def test_energy_scaling(reference):
    figure = figures.energy_scaling(
        energy_scaling_angles(range(1, 20)), PEYNEAU_ROUX, reference=reference
    )
    said = texts(figure)
    assert "its angle at 10 particles, 2.64 deg" in said
    assert "5.76 ± 0.22 deg" in said
    assert ("reference: made-up.csv" in said) == (reference is not None)
    assert {"height n (contacts)", "critical angle (deg)"} == labelled(figure)


def test_energy_scaling_that_ends_before_ten():
    figure = figures.energy_scaling(energy_scaling_angles(range(1, 5)), PEYNEAU_ROUX)
    assert "its angle" not in texts(figure)


def test_a_file_name_is_no_formula(frame):
    odd = ReferencePoints("a$x_$b.csv", (2.0,), (9.0,))
    said = texts(figures.critical_angle_against_height(frame, solver="exact", reference=odd))
    assert r"a\$x_\$b.csv" in said


def inside(figure):
    """Return whether every legend lies within the figure."""
    figure.canvas.draw()
    return all(
        figure.bbox.x0 <= box.x0 and box.x1 <= figure.bbox.x1
        for box in (legend.get_window_extent() for legend in figure.legends)
    )


def test_legends_are_not_cut_off(frame):
    from harness.report.style import house_style

    one = frame[(frame["law"] == "overlap") & (frame["window"] == "turnaround")]
    with house_style():
        assert inside(
            figures.critical_angle_against_height(
                one, solver="exact", published=PEYNEAU_ROUX, reference=REFERENCE
            )
        )
        assert inside(figures.ratio_against_height(one, "exact"))
        assert inside(figures.energy_scaling(energy_scaling_angles(), PEYNEAU_ROUX))


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
