import dataclasses

import numpy as np
import pytest

from harness.cases.incline.system import Motion
from harness.errors import EngineCrashError
from harness.reproduction.claims import ClaimStatus
from harness.reproduction.figure_data import (
    ANGLES_DEG,
    as_series,
    judged,
    turns_back,
    velocity_series,
)
from harness.reproduction.mfix import scheme_paths
from tests.reproduction.doubles import FateEngine

PATHS = scheme_paths()


def test_paths_in_mfix_s_scheme_start_in_a_well_and_stay_on_the_row():
    assert sorted(PATHS) == [(50, 10.2), (500, 10.2), (500, 10.22)]
    for path in PATHS.values():
        for sphere in (0.0, 1.0):
            assert np.hypot(path.x_m[0] - sphere, path.y_m[0]) == pytest.approx(1, abs=1e-6)
        nearest = np.hypot(path.x_m - np.round(path.x_m), path.y_m)
        # the rebound in a well lifts the grain by a few thousandths
        assert nearest == pytest.approx(1, abs=0.01)
        assert path.speed_m_per_s[0] == pytest.approx(1.5, abs=1e-5)  # six digits


@pytest.mark.parametrize(("key", "path"), PATHS.items())
def test_a_grain_that_turns_back_passes_no_more_wells(key, path):
    """The fate by another route: the way gone in the second half."""
    gone = np.ptp(path.x_m[path.time_s > 22.5])
    assert turns_back(path) == (gone < 1) == (key == (500, 10.2))


@pytest.mark.parametrize(
    ("fates", "keys", "status"),
    [
        ((Motion.TRAPPED, Motion.MOVES_ON), [(500, 10.2), (500, 10.22)], ClaimStatus.REPRODUCED),
        ((Motion.TRAPPED, Motion.MOVES_ON), list(PATHS), ClaimStatus.CORRECTED),
        ((Motion.MOVES_ON, Motion.MOVES_ON), list(PATHS), ClaimStatus.NOT_REPRODUCED),
        ((Motion.TRAPPED, Motion.TRAPPED), [(500, 10.22)], ClaimStatus.NOT_REPRODUCED),
        ((Motion.TRAPPED, Motion.MOVES_ON), [], ClaimStatus.REPRODUCED),
    ],
)
def test_the_status_follows_from_the_fates(fates, keys, status):
    engine = FateEngine(fates)
    motions, statement = velocity_series(engine, {key: PATHS[key] for key in keys})
    assert statement.status is status
    assert [job.values["angle"] for job in engine.jobs] == list(ANGLES_DEG)
    assert len(motions) == 2 + len(keys)
    if keys == list(PATHS):
        assert {job.values["wells"] for job in engine.jobs} == {20}


def test_a_fine_step_that_disagrees_is_no_matter_of_the_step():
    series = as_series(PATHS)
    own = [dataclasses.replace(s, code="LAMMPS", steps=50.0) for s in series[:2]]
    series[1] = dataclasses.replace(series[1], moving=False)
    assert judged(own, series).status is ClaimStatus.NOT_REPRODUCED


@pytest.mark.parametrize(
    ("engine", "why"),
    [(None, "no engine"), (FateEngine([EngineCrashError("it died")] * 2), "it died")],
)
def test_without_an_engine_the_paths_in_mfix_s_scheme_stand_alone(engine, why):
    motions, statement = velocity_series(engine, PATHS)
    assert statement.status is ClaimStatus.UNTESTABLE
    assert why in statement.why
    assert len(motions) == len(PATHS)


@pytest.mark.live
@pytest.mark.usefixtures("lammps_here")
def test_lammps_changes_its_fate_between_the_two_angles():
    from harness.engines.registry import open_engine

    with open_engine() as engine:
        motions, statement = velocity_series(engine, PATHS)
    assert [s.moving for s in motions[:2]] == [False, True]
    assert statement.status is ClaimStatus.CORRECTED
