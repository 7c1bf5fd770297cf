import pytest
from hypothesis import given
from hypothesis import strategies as st

from harness.cases.incline.angle import critical_angle_by_passage
from harness.cases.incline.system import Incline
from harness.errors import EngineCrashError, EngineOutputError, RequestError
from harness.theory.incline import critical_angle

CASE = Incline()


def sawtooth(height_deg, at=0.0):
    """Return a shift [deg] that jumps once a step as the start moves through it."""
    return lambda case: height_deg * ((case.phase + at + 37.3 * case.angle) % 1.0 - 0.5)


def test_root_of_the_exact_map_is_the_closed_form(synthetic):
    engine = synthetic()
    found = critical_angle_by_passage(engine.passage, CASE)
    assert found.value_deg == pytest.approx(critical_angle(), abs=1e-5)
    assert found.uncertainty_deg < 1e-4
    assert abs(found.value_deg - critical_angle()) <= found.uncertainty_deg + 1e-9
    assert found.method == "passage"


@given(st.floats(0.1, 0.5))
def test_root_is_found_far_from_the_first_angles(synthetic, shock):
    found = critical_angle_by_passage(synthetic(shock).passage, CASE)
    assert found.value_deg == pytest.approx(critical_angle(shock), abs=1e-4)


@given(st.floats(1e-5, 0.02), st.floats(0.0, 1.0))
def test_uncertainty_contains_the_truth_under_jitter(synthetic, height, at):
    engine = synthetic(shift=sawtooth(height, at))
    found = critical_angle_by_passage(engine.passage, CASE, tolerance_deg=max(1e-3, height))
    assert abs(found.value_deg - critical_angle()) <= found.uncertainty_deg + 1e-6
    assert found.uncertainty_deg <= height


def test_jitter_is_averaged_over_the_phases(synthetic):
    height = 0.004
    found = critical_angle_by_passage(synthetic(shift=sawtooth(height)).passage, CASE)
    assert found.value_deg == pytest.approx(critical_angle(), abs=height / 16 + 1e-5)


def test_result_does_not_depend_on_the_angle_or_units_of_the_case(synthetic):
    small = Incline(angle=25.0, diameter=0.003, density=2500.0, stiffness=1e4, gravity=1.62)
    one = critical_angle_by_passage(synthetic().passage, CASE)
    other = critical_angle_by_passage(synthetic().passage, small)
    assert other.value_deg == pytest.approx(one.value_deg, abs=1e-12)
    assert other.case is small


@pytest.mark.parametrize("sign", [1.0, -1.0], ids=["always over", "never over"])
@pytest.mark.parametrize("slope", [1e-3, 0.0], ids=["rising", "flat"])
def test_no_root_between_0_and_30_degrees_is_an_error(synthetic, sign, slope):
    engine = synthetic(margin=lambda angle: sign + slope * angle)
    with pytest.raises(EngineOutputError, match=r"no critical angle between 0 and 30|no root"):
        critical_angle_by_passage(engine.passage, CASE)


def test_flight_at_the_crest_is_refused_with_the_other_method_named(synthetic):
    with pytest.raises(RequestError, match=r"'passage' needs .* use method 'steady'"):
        critical_angle_by_passage(synthetic(touching=False).passage, CASE)


def test_error_of_the_engine_comes_through():
    def measure(_):
        raise EngineCrashError("LAMMPS died")

    with pytest.raises(EngineCrashError):
        critical_angle_by_passage(measure, CASE)


def test_a_margin_that_jumps_is_bracketed_where_a_secant_runs_off(synthetic):
    engine = synthetic(shift=lambda case: 0.03 * (1.0 - 2.0 * (20.0 * case.angle % 1.0)))
    found = critical_angle_by_passage(engine.passage, CASE)
    assert found.value_deg == pytest.approx(critical_angle(), abs=0.05)
    assert len(found.samples) > 12 + 8
