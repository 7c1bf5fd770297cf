import pytest

from harness.observables.reference import ReferencePoints
from harness.reproduction.claims import FIGURES
from harness.reproduction.page import source_pictures
from harness.reproduction.run import source_figures

pytestmark = pytest.mark.slow


def test_every_figure_is_drawn_with_its_sentence(figures):
    shown = source_pictures(figures)
    assert [p.name for p in shown] == [figure.picture for figure in FIGURES.values()]
    assert [p.caption for p in shown] == [row.computed for row, _ in figures]
    assert all(p.svg.startswith("<svg") for p in shown)


def test_points_of_the_user_are_drawn():
    points = ReferencePoints("made-up.csv", (2.0, 25.0), (14.0, 6.5))
    first, *_ = source_figures(None, paths={}, reference=points)
    axes = first.draw().axes[0]
    assert axes.get_xlim()[1] > 25
    assert axes.get_ylim()[1] > 14
