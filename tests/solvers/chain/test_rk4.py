"""RK4: its order, its samples, and what it refuses."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.stats import linregress
from scipy.stats import t as student

from harness.comparison.convergence import slope_order
from harness.errors import RequestError
from harness.observables.tower import energy_drift
from harness.parameters.tower import Tower
from harness.solvers.chain import exact, rk4

LAWS = ("overlap", "deformable")


def order(sizes, errors):
    """Return the slope of log error against log size, and half its 95 % interval."""
    fit = linregress(np.log(sizes), np.log(errors))
    return fit.slope, fit.stderr * student.ppf(0.975, len(sizes) - 2)


@pytest.mark.parametrize("law", LAWS)
def test_order_four_while_contacts_stay(law):
    """A tower at rest under a grain that starts to press: no contact changes."""
    case = Tower(height=5, law=law, start="preloaded", speed=0.005)
    duration = 0.4 * case.contact_time
    reference = exact.run(case, duration, samples=1)
    assert len(reference.time) <= 4
    counts = np.array([40, 60, 90, 135, 200, 300])
    errors = [
        np.abs(
            rk4.run(case, duration, step=duration / n).final_velocity - reference.final_velocity
        ).max()
        for n in counts
    ]
    slope, half = order(1 / counts, errors)
    print(f"\n{law}: order {slope:.3f} +- {half:.3f} (95 %)")
    assert abs(slope - 4) < max(half, 0.1)


@pytest.mark.parametrize("law", LAWS)
def test_order_across_an_onset(law):
    """A kink of the force inside a step costs two orders; where in the step makes it scatter."""
    case = Tower(height=3, law=law)
    duration = 3 * case.contact_time
    reference = exact.run(case, duration, samples=1)
    counts = np.unique(np.geomspace(600, 20_000, 60).astype(int))
    errors = [
        np.abs(
            rk4.run(case, duration, step=duration / n, samples=10).final_velocity
            - reference.final_velocity
        ).max()
        for n in counts
    ]
    slope, half = order(1 / counts, errors)
    print(f"\n{law}: order {slope:.2f} +- {half:.2f} (95 %)")
    assert slope - half > 1.6
    assert slope + half < 2.8


def test_order_of_the_energy_drift_while_contacts_stay():
    """Fifth: RK4 damps a mode by (omega h)^6/144 a step."""
    case = Tower(height=1, law="overlap", gravity=0.0)
    counts = np.array([20, 28, 40, 56, 80])
    drifts = [
        energy_drift(rk4.run(case, 0.9 * case.contact_time, step=0.9 * case.contact_time / n))
        for n in counts
    ]
    slope, half = order(1 / counts, drifts)
    print(f"\nenergy drift, contacts stay: order {slope:.2f} +- {half:.2f} (95 %)")
    assert abs(slope - 5) < max(half, 0.3)


@pytest.mark.parametrize("law", LAWS)
def test_order_of_the_energy_drift_across_onsets(law):
    """Second: an onset at a fraction q of a step, closing at speed s, misses energy.

    The step weighs the force k s (t - q h) by Simpson's rule, 1/6, 2/3 and 1/6 at its
    start, middle and end, instead of integrating it to k s h^2 (1 - q)^2/2: the
    impulse is off by k s h^2 (q/6 - q^2/2) for q < 1/2, (1 - q)/6 - (1 - q)^2/2 beyond,
    and the energy by s times that. Where in its step each onset falls makes it scatter.
    """
    case = Tower(height=3, law=law)
    duration = 3 * case.contact_time
    counts = np.unique(np.geomspace(600, 20_000, 60).astype(int))
    drifts = [energy_drift(rk4.run(case, duration, step=duration / n)) for n in counts]
    slope, (low, high) = slope_order(1 / counts, drifts)
    print(f"\n{law}: energy drift across onsets: order {slope:.2f} [{low:.2f}, {high:.2f}]")
    assert low < 2 < high
    assert high - low < 0.5


def test_longest_chain_is_watched():
    case = Tower(height=30)
    with pytest.raises(RequestError, match="longest_chain = 1: 2 contacts touch"):
        rk4.run(case, case.contact_time, longest_chain=1)


def test_a_preloaded_row_is_held_to_its_longest_chain():
    case = Tower(height=9, start="preloaded")
    with pytest.raises(RequestError, match="longest_chain = 3"):
        rk4.run(case, case.contact_time, longest_chain=3)


def test_samples_are_not_all_steps():
    case = Tower(height=3)
    run = rk4.run(case, 3 * case.contact_time, steps_per_contact=50_000, samples=30)
    assert run.time.size < 60
    assert run.time[-1] == pytest.approx(3 * case.contact_time)
    assert (np.diff(run.time) >= 0).all()


@pytest.mark.parametrize(
    "values",
    [
        {"step": 0.0},
        {"step": -1e-6},
        {"step": math.nan},
        {"step": 1.0},
        {"steps_per_contact": 0.0},
        {"steps_per_contact": -5.0},
        {"steps_per_contact": 2.0},
        {"steps_per_contact": math.nan},
        {"step": 1e-6, "steps_per_contact": 100.0},
        {"samples": 0},
        {"longest_chain": 0},
    ],
)
def test_bad_steps(values):
    with pytest.raises(RequestError, match=next(iter(values))):
        rk4.run(Tower(height=19), 0.01, **values)
