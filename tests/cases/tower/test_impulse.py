"""Windows, impulse ratios and critical angles of towers."""

import math

import numpy as np
import pytest

from harness.cases.tower import impulse as windows
from harness.cases.tower.impulse import (
    Runner,
    angle_from_impulse_ratio,
    impulse_angles,
    source_angles,
)
from harness.cases.tower.parameters import Tower
from harness.cases.tower.runs import solve
from harness.errors import RequestError
from tests.cases.tower.standin import Standin

KEYS = [
    "height", "stiffness_N_per_m", "speed_m_per_s", "law", "window", "impulse_ratio",
    "critical_angle_deg", "critical_angle_kept_deg", "critical_angle_lost_deg", "impulse_Ns",
    "window_s", "gamma",
]  # fmt: skip
ONE = {"stiffnesses": (1e6,), "speeds": (2.0,)}

# alpha(n) of version 1 at k = 1e6 N/m and 2 m/s: turnaround, structure, first contact
VERSION_1 = {
    ("overlap", 2): (0.626299, 0.784596, 0.580162),
    ("overlap", 3): (0.562078, 0.956873, 0.562078),
    ("deformable", 2): (0.947345, 0.613644, 0.425067),
    ("deformable", 4): (0.533780, 0.533780, 0.427748),
}


@pytest.fixture(scope="module")
def table():
    return impulse_angles(heights=(2, 3, 4, 10), windows=windows.WINDOWS, solver="exact", **ONE)


def test_the_table_has_the_columns_and_values_of_version_1(table):
    assert [*table] == KEYS
    for (law, height), ratios in VERSION_1.items():
        rows = table[(table["law"] == law) & (table["height"] == height)]
        assert rows["impulse_ratio"].tolist() == pytest.approx(ratios, abs=1e-6)


@pytest.mark.parametrize(
    ("option", "words"),
    [
        ({"reading": "both"}, "reading = 'both': must be one of kept, lost"),
        ({"windows": ("structure", "all")}, "window = 'all': must be one of turnaround"),
    ],
)
def test_a_reading_or_window_that_there_is_not_is_refused(option, words):
    with pytest.raises(RequestError, match=words):
        impulse_angles(heights=(1,), **ONE, **option)


def test_an_engine_without_one_of_the_laws_runs_nothing():
    class Overlapping(Standin):
        def refuses(self, job):
            return "" if job.values["law"] == "overlap" else "it has no such law"

    engine = Overlapping()
    with pytest.raises(RequestError, match="'standin' cannot run 'tower': it has no such law"):
        impulse_angles(heights=(1,), engine=engine, **ONE)
    assert engine.jobs == []


def test_rows_without_their_window_are_nan_not_missing(table):
    tall = table[(table["height"] == 10) & (table["window"] == "structure")]
    assert len(tall) == 2
    assert tall[["impulse_ratio", "window_s", "critical_angle_deg"]].isna().to_numpy().all()


def test_angles_fall_by_one_reading_and_rise_by_the_other(table):
    angles = source_angles(10, "deformable")
    assert angles["lost"] == pytest.approx(4.7398, abs=1e-4)
    assert angles["kept"] == pytest.approx(17.6016, abs=1e-4)
    one = source_angles(1, "overlap")
    assert one["lost"] == one["kept"] == pytest.approx(10.2078, abs=1e-4)
    turnaround = table[table["window"] == "turnaround"]
    assert (turnaround["critical_angle_deg"] == turnaround["critical_angle_lost_deg"]).all()


@pytest.mark.parametrize("alpha", [0.2, 0.626299, 1.0, 1.7])
def test_the_angle_of_a_ratio_in_closed_form(alpha):
    slope = math.tan(math.radians(15.0))
    lost = 2.0 * math.atan(slope * alpha / (4.0 - alpha))
    kept = 2.0 * math.atan(slope * (2.0 - alpha) / (2.0 + alpha))
    assert angle_from_impulse_ratio(alpha, "lost") == pytest.approx(math.degrees(lost))
    assert angle_from_impulse_ratio(alpha, "kept") == pytest.approx(math.degrees(kept))
    assert math.isnan(angle_from_impulse_ratio(2.0))


def test_solvers_and_engines_agree_on_a_table():
    engine = Standin()
    tables = [
        impulse_angles(heights=(1, 2), laws=("overlap",), **ONE, **how)
        for how in ({"solver": "exact"}, {"solver": "rk4"}, {"engine": engine})
    ]
    assert [job.values["height"] for job in engine.jobs] == [1, 2]
    ratios = [table["impulse_ratio"].tolist() for table in tables]
    assert ratios[0] == pytest.approx(ratios[1], rel=1e-7)
    assert ratios[0] == pytest.approx(ratios[2], rel=1e-5)
    assert ratios[0][0] == 1.0


# ---- windows


@pytest.fixture(scope="module")
def pair():
    return [solve(Tower(height=2, law="overlap"), solver) for solver in ("exact", "rk4")]


@pytest.mark.parametrize("window", windows.WINDOWS)
def test_a_solver_with_steps_finds_the_end_between_its_samples(pair, window):
    ends = [windows.window_end(run, window) for run in pair]
    assert ends[1] == pytest.approx(ends[0], rel=1e-8)


def test_the_impulse_is_the_integral_of_the_force(pair):
    run = pair[0]
    by_quadrature = np.trapezoid(run.grain_force, run.time)
    assert windows.impulse_until(run, float(run.time[-1])) == pytest.approx(by_quadrature, rel=1e-5)


def test_the_turnaround_of_a_free_pair_is_half_its_contact():
    case = Tower(height=1, base="free", gravity=0.0)
    run = solve(case, "exact")
    assert windows.turnaround(run) == pytest.approx(math.pi / math.sqrt(2.0) / case.omega / 2.0)
    assert windows.grain_alone(run)[0][0] == pytest.approx(1.0 / math.sqrt(2.0), rel=1e-9)


def test_a_gap_is_crossed_before_the_window_begins():
    case = Tower(height=1, start="gapped", gap=1e-2, gravity=0.0)
    run = solve(case, "exact", duration=6.0)
    assert windows.touch_time(run) == pytest.approx(5e-3, rel=1e-9)
    assert windows.impulse(run) == pytest.approx(4.0, rel=1e-9)
    assert windows.first_contact_end(run) - 5e-3 == pytest.approx(case.contact_time, rel=1e-6)


def test_runs_that_are_too_short_and_windows_that_are_not(pair):
    short = solve(Tower(), "exact", duration=0.5)
    for window in windows.WINDOWS:
        with pytest.raises(RequestError, match="duration"):
            windows.window_end(short, window)
    with pytest.raises(RequestError, match="turnaround"):
        windows.window_end(pair[0], "all")
    with pytest.raises(RequestError, match="must be at least"):
        windows.impulse_until(short, 1.0)
    covered = Runner("exact").covering(short, "turnaround")
    assert windows.impulse(covered) == pytest.approx(4.030915249, rel=1e-8)
