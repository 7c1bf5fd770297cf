import pytest

from harness.observables.reference import ReferencePoints
from harness.report.gallery import picture
from harness.reproduction.claims import FIGURES
from harness.reproduction.page import source_pictures
from harness.reproduction.run import source_figures

pytestmark = pytest.mark.slow


def drawings(figures):
    return {row.source.key: draw for row, draw in figures if draw is not None}


@pytest.fixture(scope="module")
def shown(figures):
    return source_pictures(figures)


def test_every_figure_is_drawn_with_its_sentence(shown, figures):
    assert [p.name for p in shown] == [figure.picture for figure in FIGURES.values()]
    assert [p.caption for p in shown] == [row.computed for row, _ in figures]
    assert all(p.svg.startswith("<svg") for p in shown)


@pytest.mark.parametrize("key", ["fig-3", "fig-4", "fig-16"])
def test_the_same_bytes_twice(shown, figures, key):
    (first,) = (p for p in shown if p.name == FIGURES[key].picture)
    again = picture(first.name, first.title, first.caption, drawings(figures)[key])
    assert again == first


def test_points_of_the_user_are_drawn():
    points = ReferencePoints("made-up.csv", (2.0, 25.0), (14.0, 6.5))
    drawn = drawings(source_figures(None, paths={}, reference=points))
    axes = drawn["fig-1"]().axes[0]
    assert axes.get_xlim()[1] > 25
    assert axes.get_ylim()[1] > 14
