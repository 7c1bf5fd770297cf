from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from harness.errors import RequestError
from harness.observables import tower as windows
from harness.observables.tower import (
    COLUMNS,
    SERIES,
    contact_changes,
    grain_alone,
    grain_velocity_at,
    impulse,
    impulse_until,
    peak_force,
    summary,
)
from harness.parameters.tower import Tower
from harness.solvers.chain import exact, rk4


@pytest.fixture(scope="module")
def three():
    """The source's case of three particles."""
    case = Tower(height=2)
    return exact.run(case, 3 * case.contact_time)


def test_series_are_declared_once(three):
    assert len(set(COLUMNS)) == len(SERIES)
    for observable in SERIES:
        assert observable.unit
        assert getattr(three, observable.name).shape == three.time.shape


def test_frame(three):
    frame = three.to_frame()
    assert list(frame)[:3] == ["t_over_t0", "time_s", "grain_displacement_m"]
    assert "momentum_kg_m_per_s" in frame
    assert frame["contacts"].dtype.kind == "i"
    assert len(frame) == three.time.size


def test_story_of_the_source(three):
    """The third particle joins, the grain is alone, contact returns, the grain leaves."""
    changes = contact_changes(three)
    assert [count for _, count in changes] == [1, 2, 0, 2, 1, 2, 0]
    times = [time for time, _ in changes]
    assert times[0] == 0
    assert times[1:4] == pytest.approx([0.42, 0.61, 0.99], abs=0.005)
    assert times[-1] == pytest.approx(1.57, abs=0.005)


@pytest.mark.parametrize(
    ("law", "height", "ratio"),
    [
        ("deformable", 2, 0.947),
        ("deformable", 6, 0.535),
        ("deformable", 19, 0.535),
        ("overlap", 2, 0.626),
        ("overlap", 19, 0.562),
    ],
)
def test_impulse_ratio_is_of_the_known_size(law, height, ratio):
    def of(n):
        case = Tower(height=n, law=law)
        return impulse(exact.run(case, 3 * case.contact_time))

    assert of(height) / of(1) == pytest.approx(ratio, abs=1e-3)


@pytest.mark.parametrize("window", windows.WINDOWS)
@pytest.mark.parametrize("law", ["overlap", "deformable"])
def test_windows_do_not_depend_on_the_solver(law, window):
    case = Tower(height=2, law=law)
    duration = 3 * case.contact_time
    runs = exact.run(case, duration), rk4.run(case, duration)
    ends = [windows.window_end(run, window) for run in runs]
    assert ends[0] == pytest.approx(ends[1], abs=5e-4 * case.contact_time)
    assert impulse(runs[0], window) == pytest.approx(impulse(runs[1], window), rel=1e-4)


def test_sampling_does_not_matter():
    case = Tower(height=5)
    few, many = (exact.run(case, 3 * case.contact_time, samples=n) for n in (1500, 6000))
    assert impulse(few) == pytest.approx(impulse(many), rel=1e-9)
    assert peak_force(few) == pytest.approx(peak_force(many), rel=1e-6)


def test_windows_that_the_run_does_not_reach():
    case = Tower(height=5)
    short = exact.run(case, 0.3 * case.contact_time)
    for window in windows.WINDOWS:
        with pytest.raises(RequestError, match=r"duration = 0\.3 t0: too short"):
            windows.window_end(short, window)
    with pytest.raises(RequestError, match="must be at least 2 t0"):
        impulse_until(short, 2 * case.contact_time)
    with pytest.raises(RequestError, match="window = 'half'"):
        windows.window_end(short, "half")


def test_a_sinking_tower_turns_at_the_bound():
    case = Tower(height=12, gravity=9.81, speed=0.01, law="overlap")
    run = exact.run(case, 3 * case.contact_time)
    assert windows.turnaround(run) == pytest.approx(3 * case.contact_time)


@pytest.mark.parametrize("samples", [3000, 2999, 1777])
@pytest.mark.parametrize("solver", [exact, rk4])
def test_a_tower_that_sinks_at_the_bound_turns_there_whatever_the_samples(solver, samples):
    case = Tower(height=9, stiffness=1e5)
    run = solver.run(case, 3.1 * case.contact_time, samples=samples)
    assert windows.turnaround(run) == pytest.approx(3 * case.contact_time, rel=1e-12)


@pytest.mark.parametrize("height", [1, 2, 4, 10])
@pytest.mark.parametrize("law", ["overlap", "deformable"])
def test_positions_in_single_precision_turn_where_the_rate_does(height, law):
    """The highest sample of a rounded peak lies some samples beside it."""
    case = Tower(height=height, law=law, stiffness=1e7)
    run = exact.run(case, 3 * case.contact_time, samples=3000)
    place = height + 2.0 - run.compression
    rounded = height + 2.0 - place.astype(np.float32).astype(float)
    assert np.argmax(rounded) != np.argmax(run.compression)
    again = windows.turnaround(replace(run, compression=rounded))
    assert again == windows.turnaround(run)


@pytest.mark.parametrize("samples", range(2990, 3010, 4))
@pytest.mark.parametrize("solver", [exact, rk4])
def test_of_equal_peaks_the_first_counts(solver, samples):
    """Under strong gravity a grain on a rigid base is back within 3 t0, just as deep."""
    case = Tower(height=1, speed=0.02, stiffness=1e6)  # Gamma about 0.5
    run = solver.run(case, 3 * case.contact_time, samples=samples)
    assert windows.turnaround(run) == pytest.approx(0.5 * case.contact_time, rel=1e-6)


@pytest.mark.parametrize("law", ["overlap", "deformable"])
def test_structure_window_between_samples_needs_profiles(law):
    case = Tower(height=3, law=law)
    duration = 3 * case.contact_time
    end = windows.structure_end(exact.run(case, duration))
    drawn_on = windows.structure_end(rk4.run(case, duration, profiles=True))
    sampled = windows.structure_end(rk4.run(case, duration))
    assert drawn_on == pytest.approx(end, abs=1e-6 * case.contact_time)
    assert 0 <= sampled - end < 1.1e-3 * case.contact_time


def test_interpolation_is_of_fourth_order():
    case = Tower(gravity=0.0)
    end = case.contact_time
    errors = []
    for samples in (10, 20, 40, 80):
        run = exact.run(case, end, samples=samples)
        at = (np.arange(samples) + 0.37) / samples * end
        errors.append(max(abs(grain_velocity_at(run, t) - 2 * np.cos(case.omega * t)) for t in at))
    slope = np.polyfit(np.log([10, 20, 40, 80]), np.log(errors), 1)[0]
    assert slope == pytest.approx(-4, abs=0.3)


def test_summary_has_the_agreed_keys(three):
    record = summary(three)
    agreed = {
        "law", "solver", "height", "impulse_Ns", "peak_force_N", "contact_time_s",
        "turnaround_s", "energy_drift", "contacts", "final_velocity_m_per_s",
    }  # fmt: skip
    assert agreed <= set(record)
    assert record["window_s"] == pytest.approx(2 * record["turnaround_s"])


def test_deformations_need_profiles(three):
    with pytest.raises(ValueError, match="profiles"):
        _ = three.deformations
    run = exact.run(three.tower, 0.3 * three.tower.contact_time, samples=5, profiles=True)
    # until the third joins, the first two are deformed alike
    assert run.deformations[:, 0] == pytest.approx(run.deformations[:, 1], abs=1e-12)
    assert np.abs(run.deformations[:, 2]).max() < 1e-12


def test_the_grain_is_alone_once_and_then_for_good(three):
    (first, back), (left, end) = grain_alone(three)
    assert (first, back) == pytest.approx((0.607, 0.990), abs=0.001)
    assert left == pytest.approx(1.573, abs=0.001)
    assert end == three.time_over_t0[-1]
    alone = (three.time_over_t0 > first + 1e-3) & (three.time_over_t0 < back - 1e-3)
    assert (three.grain_force[alone] == 0).all()


@pytest.mark.parametrize("height", [2, 3, 4])
def test_looser_structure_window_is_the_same_where_the_chain_reaches_the_base(height):
    case = Tower(height=height)
    run = exact.run(case, 3 * case.contact_time)
    assert windows.structure_end(run, least=2) == windows.structure_end(run)


def test_looser_structure_window_of_a_chain_that_never_reaches_the_base():
    case = Tower(height=6)
    run = exact.run(case, 3 * case.contact_time)
    assert run.contacts.max() < 6
    with pytest.raises(RequestError, match="all contacts to one"):
        windows.structure_end(run)
    end = windows.structure_end(run, least=2)
    after = run.contacts[run.time >= end]
    assert end > case.contact_time
    assert after[0] <= 1
    with pytest.raises(RequestError, match="5 contacts to one"):
        windows.structure_end(run, least=5)
