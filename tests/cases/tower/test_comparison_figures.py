from __future__ import annotations

import io

import matplotlib as mpl
import numpy as np
import pytest

from harness.cases.tower import figures as tower_comparison
from harness.cases.tower.comparison import compare, step_convergence
from harness.parameters.tower import Tower
from harness.report.style import house_style
from harness.solvers.chain import exact, rk4


@pytest.fixture(autouse=True)
def _style():
    mpl.use("agg")
    with house_style():
        yield


def drawn(figure):
    """Return whether the figure can be drawn and all its axes are named."""
    target = io.BytesIO()
    figure.savefig(target, format="png", dpi=40)
    return target.tell() > 1000 and all(axes.get_ylabel() for axes in figure.axes)


def texts(figure):
    legends = [*figure.legends, *(axes.get_legend() for axes in figure.axes)]
    shown = [text.get_text() for legend in legends if legend for text in legend.get_texts()]
    return " | ".join(shown + [axes.get_title(loc="left") for axes in figure.axes])


def test_same_law():
    tower = Tower(height=2)
    end = 2 * tower.contact_time
    reference = exact.run(tower, end, samples=300)
    found = [compare(rk4.run(tower, end, steps_per_contact=n), reference) for n in (50, 400)]
    figure = tower_comparison.same_law(found)
    assert drawn(figure)
    assert figure.axes[1].get_yscale() == "log"
    for name in ("deformable law, exact", "rk4, 400 steps per contact", "bound of what interp"):
        assert name in texts(figure)


def test_same_law_without_any_difference():
    tower = Tower(height=1)
    run = exact.run(tower, tower.contact_time, samples=100)
    assert drawn(tower_comparison.same_law([compare(run, run)]))


def test_different_law():
    found = []
    for height in (1, 2, 9):
        case = Tower(height=height)
        other = case.model_copy(update={"law": "overlap"})
        runs = [exact.run(tower, 2 * case.contact_time, samples=300) for tower in (other, case)]
        found.append(compare(*runs, across_laws=True))
    figure = tower_comparison.different_law(found)
    assert drawn(figure)
    assert len(figure.axes) == 6
    for name in ("overlap law, exact", "10 particles", "both laws give", "forces part at"):
        assert name in texts(figure)


def test_error_against_step():
    studies = []
    for height in (1, 2):
        tower = Tower(height=height, law="overlap")
        end = 1.6 * tower.contact_time
        studies.append(
            step_convergence(
                lambda n, tower=tower, end=end: rk4.run(tower, end, steps_per_contact=n),
                exact.run(tower, end),
                np.geomspace(100, 6400, 7),
            )
        )
    figure = tower_comparison.error_against_step(studies)
    assert drawn(figure)
    assert "overlap law, rk4, 2 particles: order 4.00" in texts(figure)


def test_error_against_step_without_an_order():
    tower = Tower(height=1, law="overlap")
    end = 0.8 * tower.contact_time
    found = step_convergence(
        lambda n: rk4.run(tower, end, steps_per_contact=n),
        exact.run(tower, end),
        [12800, 25600, 51200],
    )
    figure = tower_comparison.error_against_step([found])
    assert drawn(figure)
    assert "no order" in texts(figure)
