from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from harness.cases.tower.comparison import ContactEvent, compare, match_events
from harness.errors import RequestError
from harness.observables.tower import COLUMNS, TowerRun
from harness.parameters.tower import Tower
from harness.solvers.chain import exact, rk4

TOWER = Tower(height=3, law="overlap")
PEAK = 1000.0  # [N]
END = 0.01  # [s]


def synthetic(time=None, force=None, velocity=None, contacts=None, solver="synthetic", tower=TOWER):
    """Return a run with a half wave of force, or with what is given as functions of time."""
    time = np.linspace(0, END, 201) if time is None else time
    series = {name: np.zeros(time.size) for name in COLUMNS}
    series["time"] = time
    series["grain_force"] = (force or wave)(time)
    series["grain_velocity"] = (velocity or (lambda t: 2 * np.cos(np.pi * t / END)))(time)
    series["contacts"] = np.asarray((contacts or np.ones_like)(time), dtype=float)
    state = np.zeros(tower.particles)
    return TowerRun(
        tower=tower, solver=solver, step=None, **series, final_displacement=state,
        final_velocity=state,
    )  # fmt: skip


def wave(time):
    return PEAK * np.sin(np.pi * time / END)


def switches(*times, first=1):
    """Return contacts that go from ``first`` to one more and back at each of the times."""
    return lambda t: first + np.searchsorted(times, t, side="right") % 2


def test_known_differences_at_shared_times():
    run = synthetic(
        force=lambda t: wave(t) + 5.0, velocity=lambda t: 2 * np.cos(np.pi * t / END) - 0.01
    )
    found = compare(run, synthetic())
    assert found.force.scale == pytest.approx(PEAK, rel=1e-6)
    assert found.force.peak == pytest.approx(5e-3, rel=1e-6)
    assert found.force.l2 == pytest.approx(5e-3, rel=1e-6)
    assert found.velocity.peak == pytest.approx(5e-3)
    assert found.force.interpolation_error == 0


def test_l2_is_the_mean_over_time_not_over_samples():
    time = np.concatenate([np.linspace(0, END / 2, 11), np.linspace(END / 2, END, 1001)[1:]])
    run = synthetic(time, force=lambda t: wave(t) + 10.0 * (t < END / 2))
    assert compare(run, synthetic(time)).force.l2 == pytest.approx(0.01 * np.sqrt(0.5), rel=0.05)


def test_time_of_divergence():
    run = synthetic(force=lambda t: wave(t) + np.where(t > 0.3 * END, 1.3e4 * (t - 0.3 * END), 0))
    found = compare(run, synthetic())
    assert found.divergence_time == pytest.approx(0.3 * END + 1.0 / 1.3e4, abs=END / 200)
    close = synthetic(force=lambda t: wave(t) + 0.9)
    assert compare(close, synthetic()).divergence_time is None


def test_times_equal_to_round_off_are_not_interpolated():
    time = np.linspace(0, END, 201)
    found = compare(synthetic(time * (1 + 3e-16)), synthetic(time))
    assert found.time.size == time.size
    assert found.force.interpolation_error == 0


def test_the_finer_run_is_interpolated_within_the_stated_error():
    coarse, fine = synthetic(np.linspace(0, END, 61)), synthetic(np.linspace(0, END, 1009))
    for found in (compare(coarse, fine), compare(fine, coarse)):
        assert found.time.size == 61
        assert 0 < found.force.peak < found.force.interpolation_error < 1e-8
        assert found.velocity.peak < found.velocity.interpolation_error < 1e-8


def test_kinks_at_changes_of_contacts_are_not_interpolated_across():
    def kinked(t):
        return wave(t) * np.where(t > 0.6 * END, 1 - 50 * (t - 0.6 * END) / END, 1)

    def contacts(t):
        return 1 + (t > 0.6 * END)

    coarse = synthetic(np.linspace(0, END, 147), kinked, contacts=contacts)
    fine = synthetic(np.linspace(0, END, 1009), kinked, contacts=contacts)
    found = compare(coarse, fine)
    assert found.force.peak < found.force.interpolation_error < 1e-6
    # without the contacts the spline would ring
    blind = compare(coarse, synthetic(np.linspace(0, END, 1009), kinked))
    assert blind.force.peak > 1e-4


def test_samples_in_an_interval_with_a_change_are_left_out():
    fine = np.linspace(0, END, 1001)
    at = 0.5 * (fine[600] + fine[601])
    coarse = np.sort(np.append(np.linspace(0, END, 98), at))
    found = compare(
        synthetic(coarse, contacts=switches(at)), synthetic(fine, contacts=switches(at))
    )
    assert at not in found.time


FULL = np.linspace(0, END, 201)


@pytest.mark.parametrize(
    ("time", "said"),
    [
        (FULL[:6], "from 0 to 0.00025 s"),
        (FULL[:121], "from 0 to 0.006 s"),
        (FULL[:-1], "from 0 to 0.00995 s"),
        (FULL[1:], "from 5e-05 to 0.01 s"),
        (np.delete(FULL, slice(80, 120)), "no sample between 0.00395 and 0.006 s"),
        (np.delete(FULL, 100), "no sample between 0.00495 and 0.00505 s"),
    ],
)
def test_a_run_that_lacks_a_part_of_its_reference_is_refused(time, said):
    with pytest.raises(RequestError, match=f"series incomplete: {said}"):
        compare(synthetic(time), synthetic())


def test_a_run_that_goes_on_after_its_reference_is_compared_over_all_of_that():
    found = compare(synthetic(), synthetic(FULL[:121]))
    assert found.time[-1] == pytest.approx(0.6 * END)
    assert found.force.peak < 1e-12


def test_shifted_events_are_matched_one_by_one():
    reference = synthetic(contacts=switches(0.002, 0.004, 0.006, 0.008))
    found = compare(synthetic(contacts=switches(0.0021, 0.0041, 0.0061, 0.0081)), reference)
    assert not found.unmatched
    assert [pair.either.kind for pair in found.events] == ["onset", "break"] * 2
    np.testing.assert_allclose([p.difference for p in found.events], 1e-4, atol=1e-12)
    assert found.largest_event_difference == pytest.approx(1e-4)


def test_a_dropped_contact_is_listed():
    reference = synthetic(contacts=switches(0.002, 0.003, 0.006, 0.009))
    found = compare(synthetic(contacts=switches(0.002, 0.003)), reference)
    assert [(p.either.time, p.event) for p in found.unmatched] == [
        (pytest.approx(0.006), None),
        (pytest.approx(0.009), None),
    ]


def test_a_grazing_contact_moves_no_other_pair():
    times = (0.002, 0.005, 0.0077, 0.009)
    time = np.linspace(0, END, 201)
    graze = np.sort(np.append(time, [0.00502, 0.00503]))
    run = synthetic(graze, contacts=switches(0.002, 0.005, 0.00502, 0.00503, 0.0077, 0.009))
    found = compare(run, synthetic(time, contacts=switches(*times)))
    assert len(found.events) == 6
    assert len(found.unmatched) == 2
    assert found.largest_event_difference <= 0.00003


def test_events_after_the_end_of_the_reference_are_not_missed():
    run = synthetic(contacts=switches(0.002, 0.008))
    reference = synthetic(FULL[:121], contacts=switches(0.002))
    assert not compare(run, reference).unmatched


@given(st.lists(st.floats(0, 1), max_size=12), st.lists(st.floats(0, 1), max_size=12))
@settings(max_examples=200, deadline=None)
def test_any_two_lists_of_events_are_matched_at_the_least_cost(ours, theirs):
    """Each event once, in order, none farther than ``near``; no single pair left that would fit."""
    near = 0.3
    events, references = (
        [ContactEvent(1, "onset", time, 0.0) for time in sorted(times)] for times in (ours, theirs)
    )
    pairs = match_events(events, references, near)
    in_order = sorted(pairs, key=lambda pair: pair.either.time)
    for side, listed in (("event", events), ("reference", references)):
        found = [getattr(pair, side) for pair in pairs if getattr(pair, side) is not None]
        assert sorted(event.time for event in found) == [event.time for event in listed]
    matched = [pair for pair in in_order if pair.matched]
    assert all(abs(pair.difference) <= near for pair in matched)
    by_run = sorted(matched, key=lambda pair: pair.event.time)
    assert [pair.reference.time for pair in by_run] == sorted(p.reference.time for p in matched)
    cost = sum(abs(pair.difference) if pair.matched else near / 2 for pair in pairs)
    assert cost == pytest.approx(least_cost(tuple(sorted(ours)), tuple(sorted(theirs)), near))


def least_cost(ours, theirs, near):
    """Return the least cost of any matching in order, by trying how the first events go."""

    @cache
    def rest(i, j):
        if i == len(ours) or j == len(theirs):
            return near / 2 * (len(ours) - i + len(theirs) - j)
        apart = abs(ours[i] - theirs[j])
        return min(
            near / 2 + rest(i + 1, j),
            near / 2 + rest(i, j + 1),
            *([apart + rest(i + 1, j + 1)] if apart <= near else []),
        )

    return rest(0, 0)


@pytest.mark.parametrize("name", ["time", "grain_force", "grain_velocity", "contacts"])
@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_what_is_not_finite_is_refused(name, value):
    series = getattr(synthetic(), name).copy()
    series[7] = value
    bad = replace(synthetic(), **{name: series})
    for pair in ((bad, synthetic()), (synthetic(), bad)):
        with pytest.raises(RequestError, match=f"{name} = {value} in row 7"):
            compare(*pair)


@pytest.mark.parametrize(
    "change", [{"height": 4}, {"stiffness": 1e5}, {"gravity": 0.0}, {"law": "deformable"}]
)
def test_other_cases_are_refused(change):
    other = synthetic(tower=Tower(**{"height": 3, "law": "overlap", **change}))
    with pytest.raises(RequestError, match=next(iter(change))):
        compare(other, synthetic())


@pytest.mark.parametrize(
    ("pair", "options", "why"),
    [
        ((synthetic(), synthetic(force=np.zeros_like)), {}, "grain_force"),
        ((synthetic(np.linspace(1, 2, 50)), synthetic()), {}, "series incomplete"),
        ((synthetic(np.linspace(END, 0, 50)), synthetic()), {}, "must rise"),
        ((synthetic(np.linspace(1e-3, 9e-3, 3)), synthetic(np.linspace(0, END, 4))), {}, "too few"),
        ((synthetic(), synthetic()), {"least_force": -1.0}, "least_force = -1.0"),
        ((synthetic(), synthetic()), {"least_force": 1e-6}, "needs profiles"),
    ],
)
def test_what_cannot_be_compared_is_refused(pair, options, why):
    with pytest.raises(RequestError, match=why):
        compare(*pair, **options)


@pytest.mark.parametrize(
    ("law", "height", "largest"),
    [  # RK4 at 4000 steps: fourth order until a contact changes, second across
        ("overlap", 1, 1e-11),
        ("overlap", 2, 1e-7),
        ("overlap", 9, 1e-10),
        ("deformable", 1, 1e-11),
        ("deformable", 2, 1e-6),
        ("deformable", 9, 5e-6),
    ],
)
def test_exact_and_rk4_agree(law, height, largest):
    tower = Tower(height=height, law=law)
    duration = 1.6 * tower.contact_time
    found = compare(
        rk4.run(tower, duration, profiles=True),
        exact.run(tower, duration, profiles=True),
        least_force=1e-6,
    )
    assert found.force.peak < largest
    assert found.force.interpolation_error < 1e-6
    assert found.divergence_time is None
    assert not found.unmatched
    for pair in found.events:
        assert abs(pair.difference) <= 1.01 * pair.resolution


def test_the_laws_part():
    deformable, overlap = (Tower(height=2, law=law) for law in ("deformable", "overlap"))
    t0 = overlap.contact_time
    found = compare(
        exact.run(overlap, 2 * t0), exact.run(deformable, 2 * t0), across_laws=True
    )  # fmt: skip
    assert found.force.peak > 0.5
    assert 0.1 < found.divergence_time / t0 < 0.3
    assert found.unmatched
    # two particles alone are the same spring
    alone = [exact.run(Tower(height=1, law=law), t0) for law in ("deformable", "overlap")]
    assert compare(*alone, across_laws=True).force.peak < 1e-12
