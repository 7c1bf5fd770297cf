import pytest

from harness.reproduction.claims import FIGURES
from harness.reproduction.page import source_pictures

pytestmark = pytest.mark.slow


def test_every_figure_is_drawn_with_its_sentence(figures):
    shown = source_pictures(figures)
    assert [p.name for p in shown] == [figure.picture for figure in FIGURES.values()]
    assert [p.caption for p in shown] == [row.computed for row, _ in figures]
    assert all(p.svg.startswith("<svg") for p in shown)
