"""Figures of towers held against one another: the orders and the moments that they state."""

import numpy as np
import pytest

from harness.cases.tower import figures
from harness.cases.tower.comparison import compare, step_convergence
from harness.parameters.tower import Tower
from harness.solvers.chain import exact, rk4


def texts(figure):
    legends = [*figure.legends, *(axes.get_legend() for axes in figure.axes)]
    shown = [text.get_text() for legend in legends if legend for text in legend.get_texts()]
    titles = [axes.get_title() + axes.get_title(loc="left") for axes in figure.axes]
    return " | ".join(shown + titles)


def test_runs_of_one_law_stand_beside_the_exact_one_with_their_difference():
    tower = Tower(height=2)
    end = 2 * tower.contact_time
    reference = exact.run(tower, end, samples=300)
    found = [compare(rk4.run(tower, end, steps_per_contact=n), reference) for n in (50, 400)]
    figure = figures.same_law(found)
    assert figure.axes[1].get_yscale() == "log"
    for name in ("deformable law, exact", "rk4, 400 steps per contact"):
        assert name in texts(figure)
    same = compare(reference, reference)
    assert figures.same_law([same]).axes[0].get_ylabel()


def test_both_laws_part_where_forces_do():
    found = []
    for height in (1, 2, 9):
        case = Tower(height=height)
        other = case.model_copy(update={"law": "overlap"})
        runs = [exact.run(tower, 2 * case.contact_time, samples=300) for tower in (other, case)]
        found.append(compare(*runs, across_laws=True))
    figure = figures.different_law(found)
    assert len(figure.axes) == 6
    for name in ("both laws give", "forces part at"):
        assert name in texts(figure)


@pytest.mark.parametrize(
    ("end", "steps", "stated"),
    [
        (1.6, np.geomspace(100, 6400, 7), "overlap law, rk4, 2 particles: order 4.00"),
        (0.8, [12800, 25600, 51200], "no order"),  # round-off alone
    ],
)
def test_the_error_over_the_step_has_its_order_or_none(end, steps, stated):
    tower = Tower(height=1, law="overlap")
    end *= tower.contact_time
    found = step_convergence(
        lambda n: rk4.run(tower, end, steps_per_contact=n), exact.run(tower, end), steps
    )
    assert stated in texts(figures.error_against_step([found]))
