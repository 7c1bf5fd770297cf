import pytest
from hypothesis import given
from hypothesis import strategies as st

from harness.cases.incline.angle import (
    critical_angle,
    critical_angle_by_passage,
    critical_angle_by_steady_motion,
)
from harness.cases.incline.levels import COARSE_RUNS
from harness.cases.incline.system import Incline, Motion
from harness.engines.reference import Reference
from harness.errors import EngineOutputError
from harness.reproduction.mfix import case_at
from harness.theory.incline import critical_angle as closed_form

CASE = Incline()
COARSE = Incline(steps_per_contact=10.0)


def in_bands(*bands, otherwise):
    """Return a fate from (low, high, motion) bands of the angle; the first that fits counts."""

    def fate(angle):
        for low, high, motion in bands:
            if low <= angle < high:
                return motion
        return otherwise

    return fate


def test_bracket_of_the_theory_map_holds_the_closed_form_with_few_runs(synthetic):
    engine = synthetic()
    found = critical_angle_by_steady_motion(engine.steady, CASE, tolerance_deg=1e-3)
    assert abs(found.value_deg - closed_form()) <= found.uncertainty_deg
    assert found.uncertainty_deg <= 1e-3
    assert found.monotone
    assert found.note == ""
    assert found.method == "steady"
    assert len(engine.cases) == len(found.samples) <= 24


@given(st.floats(0.05, 29.95))
def test_any_angle_is_found_from_the_usual_window(synthetic, truth):
    engine = synthetic(fate=in_bands((0.0, truth, Motion.TRAPPED), otherwise=Motion.MOVES_ON))
    found = critical_angle_by_steady_motion(engine.steady, CASE)
    assert abs(found.value_deg - truth) <= found.uncertainty_deg <= 5e-3
    assert len(engine.cases) <= 60
    assert all(0.0 <= case.angle <= 30.0 for case in engine.cases)


def test_both_routes_agree_on_the_same_jittery_engine(synthetic):
    def shift(case):
        return 0.002 * ((case.phase + 37.3 * case.angle) % 1.0 - 0.5)

    passage = critical_angle_by_passage(synthetic(shift=shift).passage, CASE)
    steady = critical_angle_by_steady_motion(synthetic(shift=shift).steady, CASE)
    apart = abs(passage.value_deg - steady.value_deg)
    assert apart <= passage.uncertainty_deg + steady.uncertainty_deg


def test_moving_band_below_a_trapped_one_is_told_and_widens_the_uncertainty(synthetic):
    fate = in_bands(
        (0.0, 10.05, Motion.TRAPPED),
        (10.05, 10.3, Motion.MOVES_ON),
        (10.3, 10.5, Motion.TRAPPED),
        otherwise=Motion.MOVES_ON,
    )
    found = critical_angle_by_steady_motion(synthetic(fate=fate).steady, CASE)
    assert found.value_deg == pytest.approx(10.05, abs=5e-3)
    assert not found.monotone
    assert found.note.startswith("not monotone: trapped again up to 10.")
    assert 10.5 <= found.value_deg + found.uncertainty_deg <= 10.51


def test_undecided_band_is_part_of_the_uncertainty_and_never_counts_as_trapped(synthetic):
    engine = synthetic(
        fate=in_bands(
            (0.0, 10.15, Motion.TRAPPED),
            (10.15, 10.25, Motion.UNDECIDED),
            otherwise=Motion.MOVES_ON,
        )
    )
    found = critical_angle_by_steady_motion(engine.steady, CASE)
    assert found.value_deg - found.uncertainty_deg <= 10.15
    assert found.value_deg + found.uncertainty_deg >= 10.25
    assert found.uncertainty_deg < 0.2
    assert "undecided within the time limit" in found.note
    assert found.monotone
    assert len(engine.cases) <= 30


@pytest.mark.parametrize(
    ("motion", "message"),
    [
        (Motion.MOVES_ON, "no angle from 0 to 30 deg was trapped"),
        (Motion.TRAPPED, "no angle from 0 to 30 deg kept moving"),
        (Motion.UNDECIDED, "no angle from 0 to 30 deg was trapped"),
    ],
)
def test_same_fate_at_every_angle_is_an_error(synthetic, motion, message):
    engine = synthetic(fate=lambda _: motion)
    with pytest.raises(EngineOutputError, match=message):
        critical_angle_by_steady_motion(engine.steady, CASE)
    assert {0.0, 30.0} & {case.angle for case in engine.cases}


def test_fate_that_only_turns_from_moving_to_trapped_is_an_error(synthetic):
    fate = in_bands((0.0, 10.2, Motion.MOVES_ON), otherwise=Motion.TRAPPED)
    with pytest.raises(EngineOutputError, match="trapped"):
        critical_angle_by_steady_motion(synthetic(fate=fate).steady, CASE)


def test_probes_of_coarse_steps_find_what_the_scan_missed(synthetic):
    fate = in_bands(
        (0.0, 10.152, Motion.TRAPPED),
        (10.152, 10.154, Motion.MOVES_ON),
        (10.154, 10.159, Motion.TRAPPED),
        (10.159, 10.161, Motion.MOVES_ON),
        (10.161, 10.165, Motion.TRAPPED),
        otherwise=Motion.MOVES_ON,
    )
    fine = critical_angle_by_steady_motion(synthetic(fate=fate).steady, CASE, tolerance_deg=1e-3)
    assert fine.monotone  # missed: the scan and the bisection never fall into the bands
    engine = synthetic(fate=fate)
    found = critical_angle_by_steady_motion(engine.steady, COARSE, tolerance_deg=1e-3)
    assert not found.monotone
    assert found.value_deg == pytest.approx(10.152, abs=5e-4)
    assert 10.165 <= found.value_deg + found.uncertainty_deg <= 10.166
    assert len(engine.cases) <= 100


def test_fates_without_order_come_to_an_end(synthetic):
    engine = synthetic(
        fate=lambda a: Motion.MOVES_ON if a * 1e4 % 1.7 > 0.8 and a > 3.0 else Motion.TRAPPED
    )
    found = critical_angle_by_steady_motion(engine.steady, COARSE)
    assert not found.monotone
    assert len(engine.cases) <= 2000


@pytest.mark.parametrize(
    ("stiffness", "recorded_deg"), [(1e5, 10.168), (1e6, 10.196), (1e7, 10.204)]
)
def test_coarse_steps_as_mfix_takes_them_give_what_mfix_gave(stiffness, recorded_deg):
    """Ten wells and the scan alone gave 10.1523 +- 0.0008 deg for 10.168 deg at 1e5 N/m."""
    case = case_at(10.2, stiffness, 50)
    with Reference("mfix-euler") as engine:
        found = critical_angle(case, method="steady", tolerance_deg=1e-3, engine=engine)
        few = critical_angle(case, method="steady", tolerance_deg=1e-3, wells=10, engine=engine)
    assert found.case.wells == 100
    assert found.to_json()["wells"] == 100
    assert 0.5 * COARSE_RUNS < len(found.samples) < 2 * COARSE_RUNS  # what it costs is told
    assert abs(found.value_deg - recorded_deg) <= found.uncertainty_deg + 0.002
    assert found.uncertainty_deg <= 0.008
    assert few.case.wells == 10
    assert not few.monotone
    assert few.uncertainty_deg > found.uncertainty_deg
