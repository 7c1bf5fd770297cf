import numpy as np
import pytest

from harness.cases.incline.result import Motion
from harness.cases.incline.routes import margin, start_of
from harness.cases.tower.timing import plan
from harness.engines.yade.read import read_drop, read_incline, read_tower
from harness.errors import EngineNaNError, EngineOutputError
from harness.observables.provenance import Provenance

WHO = Provenance("yade", "1970.01a")


def test_incline_with_its_path(incline, recorded):
    run = read_incline(incline, recorded("incline.txt"), WHO, recorded("incline.csv"), 200)
    assert run.motion is Motion.MOVES_ON
    assert run.touching
    assert (run.time_s, run.steps) == (pytest.approx(4600 * incline.step, rel=1e-15), 4600)
    assert run.crests.margin_J.tolist() == [run.margin_J]
    assert run.provenance is WHO
    path = run.trajectory
    assert path.time_s == pytest.approx(np.arange(24) * 200 * incline.step, rel=1e-15)
    last = (path.x_m[-1], path.y_m[-1], path.vx_m_per_s[-1], path.vy_m_per_s[-1])
    assert run.margin_J == pytest.approx(margin(incline, 1, *last), rel=1e-12)
    begin = start_of(incline, "passage")
    assert (path.x_m[0], path.y_m[0]) == pytest.approx((begin.x_m, begin.y_m), rel=1e-15)


def test_every_crest_of_a_steady_run_is_kept(incline, recorded):
    run = read_incline(incline.replace(angle=20.0, wells=3), recorded("steady.txt"), WHO)
    assert run.motion is Motion.MOVES_ON
    assert run.trajectory is None
    assert run.crests.time_s.shape == (3,)
    assert np.all(np.diff(run.crests.time_s) > 0.0)


def test_drop(drop, recorded):
    run = read_drop(drop, recorded("drop.txt"), recorded("drop.csv"), WHO)
    assert run.path.y_m[0] == drop.diameter
    assert run.path.vy_m_per_s[0] == -drop.speed
    assert run.path.time_s[-1] == pytest.approx(drop.steps * drop.step, rel=1e-15)
    assert f"{run.path.vy_m_per_s[-1]:.17g}" in recorded("drop.txt")
    assert run.seconds > 0.0


def test_tower(tower, recorded):
    timing = plan(tower, 1.0, 100.0, 20)
    run = read_tower(tower, timing, recorded("tower.csv"), WHO, profiles=True)
    assert run.time[-1] == pytest.approx(tower.contact_time, rel=1e-12)
    overlap = run.profiles.displacements[:, :-1] - run.profiles.displacements[:, 1:]
    spring = 1e5 * np.maximum(overlap, 0.0)
    # the last digit of a place is 4e-16 m
    assert run.profiles.forces == pytest.approx(spring, abs=1e5 * 1e-15, rel=1e-12)
    assert run.contacts[0] == 0
    assert run.contacts.max() == 2
    assert (run.grain_velocity[0], run.solver) == (2.0, "yade")
    # the leapfrog's energy swings by (omega_max h)^2 / 4 and does not drift
    assert np.ptp(run.energy) / run.energy[0] < tower.omega**2 * timing.step**2


def test_the_rounding_of_places_is_no_contact(tower, recorded):
    lines = recorded("tower.csv").splitlines()
    timing, tiny = plan(tower, 1.0, 100.0, 20), 1e5 * 2.0 * float(np.finfo(float).eps)
    rows = [f"{time},0,1,2,0,0,0,{tiny!r},{tiny!r}" for time in range(len(lines) - 1)]
    series = "\n".join([lines[0], *rows]) + "\n"
    assert not read_tower(tower, timing, series, WHO).contacts.any()


@pytest.mark.parametrize("missing", ["margin_J", "touching", "time_s", "steps", "seconds"])
def test_a_result_without_a_line_is_named(incline, recorded, missing):
    lines = recorded("incline.txt").splitlines(keepends=True)
    text = "".join(line for line in lines if f" {missing} =" not in line)
    with pytest.raises(EngineOutputError, match=missing):
        read_incline(incline, text, WHO)


def test_a_grain_that_is_nowhere_is_named(incline, recorded):
    text = recorded("incline.txt").replace("verdict = moves_on", "verdict = not_a_number")
    lines = ["RESULT margin_J = nan" if "margin_J" in x else x for x in text.splitlines()]
    with pytest.raises(EngineNaNError, match="margin_J = nan"):
        read_incline(incline, "\n".join(lines), WHO)


@pytest.mark.parametrize("cut", [0, 1, 40, -1, -8, -30, -110])
def test_a_series_that_is_cut_is_named(drop, recorded, cut):
    with pytest.raises(EngineOutputError, match="Yade wrote"):
        read_drop(drop, recorded("drop.txt"), recorded("drop.csv")[:cut], WHO)


@pytest.mark.parametrize(
    ("row", "error"),
    [
        ("1,2,3,nan,5", EngineNaNError),
        ("1,2,3,4", EngineOutputError),
        ("1,2,3,4,five", EngineOutputError),
        ("-1,2,3,4,5", EngineOutputError),
    ],
)
def test_rows_that_are_wrong_are_named(incline, recorded, row, error):
    series = "time_s,x_m,y_m,vx_m_per_s,vy_m_per_s\n0,1,1,1,1\n" + row + "\n"
    with pytest.raises(error):
        read_incline(
            incline, recorded("incline.txt").replace("steps = 4600", "steps = 1"), WHO, series, 1
        )
