"""Films and sections of bulk: circles in which a plane cuts particles, curves, means."""

import numpy as np
import pytest

from harness.cases.bench import Bench
from harness.cases.bulk.report import curve_figure, means_table, plane_section
from harness.report.film import write_film
from tests.cases.bulk.doubles import CASES, SMALL, StandIn, made


def frames():
    """Return eight grains on top of one another and a larger one beside them, which rises."""
    place = np.zeros((3, 9, 3))
    place[:, :8, 2] = np.arange(8) * 2e-3
    place[:, 8] = 5e-3, 0.6e-3, 1e-3
    place[2, 8, 2] = 3e-3
    radius = np.tile([1e-3] * 8 + [2e-3], (3, 1))
    columns = {f"{axis}_m": place[:, :, k] for k, axis in enumerate("xyz")}
    return made({"step": np.array([5.0, 10.0, 20.0]), "radius_m": radius, **columns})


def test_a_particle_is_the_circle_that_the_plane_cuts_from_it():
    lines = [((0.0, 1e-2, 1e-2), (0.0, 0.0, 1e-2))]
    discs = plane_section("grains", frames(), 10, 1e-3, 0.6e-3, lines)
    assert discs.time == pytest.approx([0.0, 0.01])  # from the release on
    # the plane is 0.6 mm from the grains' centres: sqrt(1 - 0.6^2) = 0.8
    assert discs.radius[0, :8] == pytest.approx(0.8e-3)
    assert discs.radius[0, 8] == pytest.approx(2e-3)
    assert (discs.x[1, 8], discs.y[1, 8]) == pytest.approx((5e-3, 3e-3))
    assert discs.value[1].tolist() == discs.value[0].tolist() == discs.y[0].tolist()
    assert discs.lines.tolist() == [[[0, 0], [1e-2, 0]], [[1e-2, 0], [1e-2, 1e-2]]]
    beside = plane_section("grains", frames(), 10, 1e-3, 1.5e-3, lines)
    assert beside.radius[0, :8] == pytest.approx(0.0)
    assert beside.radius[0, 8] == pytest.approx(1e-3 * np.sqrt(4 - 0.81))


@pytest.mark.parametrize("case", CASES)
def test_each_curve_and_mean_is_drawn_for_each_engine(case):
    case = CASES[case]
    setup, samples = case.setups()[0], {}
    for code in ("lammps", "liggghts"):
        samples[code] = case.sample(Bench(StandIn(case.name, code)), setup)
    for curve in case.curves:
        above, below = curve_figure(curve, samples).axes
        assert len(above.lines) == 2 * len(setup.runs)
        assert len(below.lines) == 2
    table = means_table(samples, case.quantities)
    assert list(table) == ["quantity", "lammps", "liggghts"]
    assert len(table) == len(case.quantities)


@pytest.mark.live
@pytest.mark.parametrize("case", CASES)
def test_each_case_has_a_film(case, lammps, tmp_path):
    p, case = SMALL[case], CASES[case]
    (output,) = lammps.run([case.film_job(p, 5)])
    discs = case.discs(p, output)
    assert len(discs.time) in (5, 6)
    assert not np.allclose(discs.y[0], discs.y[-1])
    write_film(discs, tmp_path / "film.gif", frames=5)
    assert (tmp_path / "film.gif").read_bytes().startswith(b"GIF")
