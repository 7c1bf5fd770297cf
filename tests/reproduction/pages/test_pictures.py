import pytest

from harness.observables.reference import ReferencePoints
from harness.report.gallery import picture
from harness.report.style import house_style
from harness.reproduction.claims import FIGURES
from harness.reproduction.page import source_pictures
from harness.reproduction.run import source_figures

pytestmark = pytest.mark.slow

MOST_BYTES = 5_000_000

AXES = {
    "fig-1": {"height h/d", "critical angle (deg)"},
    "fig-2": {"across (diameters)", "up (diameters)"},
    "fig-3": {"across (diameters)", "up (diameters)"},
    "fig-4": {"time (s)", "speed (m/s)"},
    "fig-5": {"across (diameters)", "up (diameters)"},
    "fig-6": {"time (t0)", "velocity (m/s)", "deformation (mm)"},
    "fig-7": {"stiffness k (N/m)", "error of peak deformation (%)"},
    "fig-8": {"time (t0)", "force over\nthe largest of all 19", "contacts of the grain"},
    "fig-9": {"time (t0)", "force on the grain (v0 sqrt(k m))", "contacts of the grain"},
    "fig-10": {"height n (contacts)", "impulse ratio alpha = J(n) / J(1)"},
    "fig-11": {"height n (contacts)", "critical angle (deg)"},
    "fig-13": {"height n (contacts)", "critical angle (deg)"},
    "fig-14": {"time (t0)", "force over\nthe largest of all 19", "contacts of the grain"},
    "fig-15": {"height n (contacts)", "critical angle (deg)"},
    "fig-16": {"time (t0)", "force, compression\nover the largest", "contacts of the grain"},
}

SAID = {
    "fig-1": "Peyneau and Roux",
    "fig-2": "contacts in the well",
    "fig-3": "contact force",
    "fig-4": "10.22 deg: moves on",
    "fig-5": "chain of its contact",
    "fig-6": "deformable law, exact",
    "fig-7": "RK4, 50 steps per contact time",
    "fig-8": "force, deformable law, exact",
    "fig-9": "k = 1e6 N/m, v0 = 2 m/s",
    "fig-10": "deformable law, turnaround window, exact",
    "fig-11": "Peyneau and Roux",
    "fig-13": "its angle at 10 particles",
    "fig-14": "base felt at",
    "fig-15": "overlap law, exact: two contacts or more held",
    "fig-16": "largest compression",
}


def drawings(figures):
    return {row.source.key: draw for row, draw in figures if draw is not None}


def texts(figure):
    """Return all that titles and legends say."""
    legends = [*figure.legends, *(a.get_legend() for a in figure.axes if a.get_legend())]
    said = [t.get_text() for legend in legends for t in legend.get_texts()]
    return "\n".join([*said, *(axes.get_title(loc="left") for axes in figure.axes)])


@pytest.mark.parametrize("key", AXES)
def test_axes_and_legends(figures, key):
    with house_style():
        figure = drawings(figures)[key]()
        names = {text for a in figure.axes for text in (a.get_xlabel(), a.get_ylabel()) if text}
        assert names == AXES[key]
        assert SAID[key] in texts(figure)
        figure.draw_without_rendering()
        for legend in figure.legends:
            box = legend.get_window_extent()
            assert figure.bbox.x0 <= box.x0
            assert box.x1 <= figure.bbox.x1
            assert figure.bbox.y0 <= box.y0


def test_lines_of_a_panel_differ_without_colour(figures):
    """In grey, line style, marker or width must tell lines with a name apart."""
    for key, draw in drawings(figures).items():
        for axes in draw().axes:
            looks = [
                (str(line.get_linestyle()), line.get_marker(), line.get_linewidth(),
                 line.get_markersize(), line.get_fillstyle())
                for line in axes.get_lines()
                if not line.get_label().startswith("_") and len(line.get_xdata()) > 1
            ]  # fmt: skip
            assert len(looks) == len(set(looks)), key


@pytest.fixture(scope="module")
def shown(figures):
    return source_pictures(figures)


def test_every_figure_but_the_one_of_others_is_drawn(shown, figures):
    told = {row.source.key: row.computed for row, _ in figures}
    expected = [figure for key, figure in FIGURES.items() if key != "fig-12"]
    assert [p.name for p in shown] == [figure.picture for figure in expected]
    for drawn, figure in zip(shown, expected, strict=True):
        assert drawn.title == f"{figure.where.capitalize()} of the source: {figure.title}"
        assert drawn.caption == told[figure.key]
        assert drawn.svg.startswith("<svg")
    assert shown[3].name == "fig-04-velocity-series"


def test_all_figures_together_are_small(shown):
    assert sum(len(p.svg) for p in shown) < MOST_BYTES


@pytest.mark.parametrize("key", ["fig-3", "fig-4", "fig-16"])
def test_the_same_bytes_twice(shown, figures, key):
    (first,) = (p for p in shown if p.name == FIGURES[key].picture)
    again = picture(first.name, first.title, first.caption, drawings(figures)[key])
    assert again == first


def test_points_of_the_user_are_drawn():
    points = ReferencePoints("made-up.csv", (2.0, 25.0), (14.0, 6.5))
    drawn = drawings(source_figures(None, paths={}, reference=points))
    for key in ("fig-1", "fig-11", "fig-13", "fig-15"):
        figure = drawn[key]()
        assert "reference: made-up.csv" in texts(figure), key
    axes = drawn["fig-1"]().axes[0]
    assert axes.get_xlim()[1] > 25
    assert axes.get_ylim()[1] > 14
