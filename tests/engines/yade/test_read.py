"""What the generated scripts left is read by the cases, and what is damaged is named."""

from dataclasses import replace

import numpy as np
import pytest

from harness.cases.drop import case as drops
from harness.cases.incline import runs as inclines
from harness.cases.incline.system import Motion, margin, start_of
from harness.cases.tower import run as towers
from harness.cases.tower.system import timing_of
from harness.engines.yade.engine import Yade
from harness.errors import EngineNaNError, EngineOutputError


def test_incline_with_its_path(incline, recorded):
    output = recorded("incline")
    run = inclines.read(incline, "passage", output, "linear", 200)
    assert run.motion is Motion.MOVES_ON
    assert run.touching
    assert (run.time_s, run.steps) == (pytest.approx(4600 * incline.step, rel=1e-15), 4600)
    assert run.crests.margin_J.tolist() == [run.margin_J]
    assert run.provenance is output.provenance
    path = run.trajectory
    assert path.time_s == pytest.approx(np.arange(24) * 200 * incline.step, rel=1e-15)
    last = (path.x_m[-1], path.y_m[-1], path.vx_m_per_s[-1], path.vy_m_per_s[-1])
    assert run.margin_J == pytest.approx(margin(incline, 1, *last), rel=1e-12)
    begin = start_of(incline, "passage")
    assert (path.x_m[0], path.y_m[0]) == pytest.approx((begin.x_m, begin.y_m), rel=1e-15)


def test_every_crest_of_a_steady_run_is_kept(incline, recorded):
    case = incline.replace(angle=20.0, wells=3)
    run = inclines.read(case, "steady", recorded("steady"), "linear")
    assert run.motion is Motion.MOVES_ON
    assert run.trajectory is None
    assert run.crests.time_s.shape == (3,)
    assert np.all(np.diff(run.crests.time_s) > 0.0)


def test_drop(drop, recorded):
    output = recorded("drop")
    run = drops.read(drop, output)
    assert run.path.y_m[0] == drop.diameter
    assert run.path.vy_m_per_s[0] == -drop.speed
    assert run.path.time_s[-1] == pytest.approx(drop.steps * drop.step, rel=1e-15)
    assert output.number("steps") == drop.steps
    assert output.number("seconds") > 0.0


def test_tower(tower, recorded):
    timing = timing_of(tower, 1.0, 100.0, 20)
    run = towers.read(tower, timing, recorded("tower"), Yade.traits, profiles=True)
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


def test_the_rounding_of_places_is_no_contact(tower, recorded, monkeypatch):
    """Forces of two roundings of a place count as none; one contact that presses is still there."""
    # spheres that rest in spite of gravity: these samples are not to be held against each other
    monkeypatch.setattr(towers, "FEWEST", 100)
    timing, tiny = timing_of(tower, 1.0, 100.0, 20), 1e5 * 2.0 * float(np.finfo(float).eps)

    def rounded(series, last="9,0"):
        head, *rows = series.splitlines()
        times = [row.partition(",")[0] for row in rows]
        rows = [f"{time},0,1,2,0,0,0,{tiny!r},{tiny!r}" for time in times]
        rows[-1] = f"{times[-1]},0,1,2,0,0,0,{last}"
        return "\n".join([head, *rows]) + "\n"

    run = towers.read(tower, timing, recorded("tower", lambda _: "", rounded), Yade.traits)
    assert run.contacts.tolist() == [0.0] * (len(run.time) - 1) + [1.0]
    open_all = recorded("tower", lambda _: "", lambda text: rounded(text, "0,0"))
    with pytest.raises(EngineOutputError, match="no contact of the tower ever presses"):
        towers.read(tower, timing, open_all, Yade.traits)


def test_a_stage_that_is_missing_leaves_the_run_undecided(incline, recorded):
    output = recorded("incline")
    stages = {name: column[:1] for name, column in output.tables["stages"].items()}
    cut = replace(output, tables={"stages": stages})
    with pytest.raises(EngineOutputError, match="undecided, before the time limit"):
        inclines.read(incline, "passage", cut, "linear")


@pytest.mark.parametrize("cut", [0, 1, 40, -1, -8, -30, -110])
def test_a_series_that_is_cut_is_named(drop, recorded, cut):
    with pytest.raises(EngineOutputError, match=r"series"):
        drops.read(drop, recorded("drop", series=lambda text: text[:cut]))


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
        inclines.read(incline, "passage", recorded("incline", series=lambda _: series), "linear", 1)
