"""Impulse and critical angle against height, by routes that share no code with them."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import brentq
from scipy.special import jv

from harness.cases.tower.impulse import (
    angle_from_impulse_ratio,
    energy_scaling_angles,
    impulse_angles,
    impulse_by_gamma,
    impulse_table,
)
from harness.parameters.tower import Tower
from harness.theory.incline import passage_margin

WINDOWS = ("turnaround", "structure", "first-contact")
KNOWN_BESSEL_RATIO = 0.5661397  # (1 + 0.1322795) / 2


def ratios(law, heights, window="turnaround", **values):
    """Return alpha of each height at k = 1e6 N/m, v0 = 2 m/s."""
    rows = impulse_table(
        heights=heights, stiffnesses=(1e6,), speeds=(2.0,), laws=(law,), windows=(window,), **values
    )
    return [row.ratio for row in rows]


@pytest.mark.parametrize("reading", ["lost", "kept"])
@pytest.mark.parametrize("ratio", [0.05, 0.53, 0.947, 1.0, 1.4, 1.9])
def test_angle_is_the_root_of_the_energy_margin(ratio, reading):
    kept = {"lost": 1 - ratio / 2, "kept": ratio / 2}[reading]
    root = brentq(lambda angle: passage_margin(angle, kept**2), 0.0, 30.0, xtol=1e-12)
    assert angle_from_impulse_ratio(ratio, reading) == pytest.approx(root, abs=1e-9)


@pytest.mark.parametrize("ratio", [-0.3, 0.0, 2.0, 5.4, math.nan, math.inf, -math.inf])
def test_a_ratio_without_an_angle_does_not_stop_the_table(ratio):
    assert math.isnan(angle_from_impulse_ratio(ratio, "lost"))
    assert math.isnan(angle_from_impulse_ratio(ratio, "kept"))


def test_strong_gravity_makes_ratios_beyond_two_and_no_angle():
    frame = impulse_by_gamma([1.0], heights=(1, 6), laws=("deformable",), solver="exact")
    assert frame["impulse_ratio"].tolist() == pytest.approx([1.0, 5.35], abs=0.01)
    assert frame["critical_angle_deg"].isna().tolist() == [False, True]
    assert frame["gamma"].tolist() == pytest.approx([1.0, 1.0])


def test_orders_of_magnitude():
    deformable = ratios("deformable", (2, 5, 10, 19))
    overlap = ratios("overlap", (2, 5, 10, 19))
    assert deformable[0] == pytest.approx(0.947, abs=5e-4)
    assert all(0.53 < ratio < 0.54 for ratio in deformable[1:])
    assert overlap[0] == pytest.approx(0.626, abs=5e-4)
    assert all(0.555 < ratio < 0.565 for ratio in overlap[1:])


def test_the_plateau_in_degrees():
    frame = impulse_angles(heights=(1, 19), stiffnesses=(1e6,), speeds=(2.0,))
    angles = frame.set_index(["law", "height"])["critical_angle_deg"]
    assert angles["deformable", 1] == pytest.approx(10.2078, abs=1e-4)
    assert angles["deformable", 19] == pytest.approx(4.74, abs=0.01)
    assert angles["overlap", 19] == pytest.approx(5.01, abs=0.01)


@pytest.mark.parametrize("law", ["overlap", "deformable"])
def test_the_two_readings_go_opposite_ways(law):
    common = {"heights": range(1, 7), "stiffnesses": (1e7,), "speeds": (4.0,), "laws": (law,)}
    frame = impulse_angles(windows=("first-contact",), reading="kept", **common)
    lost, kept = (frame[f"critical_angle_{name}_deg"].to_numpy() for name in ("lost", "kept"))
    assert lost[0] == pytest.approx(kept[0])
    assert (lost[1:] < lost[0] - 1).all()
    assert (kept[1:] > kept[0] + 1).all()
    slopes = np.diff(lost) * np.diff(kept)
    assert (slopes[np.abs(np.diff(lost)) > 1e-9] < 0).all()
    assert frame["critical_angle_deg"].tolist() == kept.tolist()


ONE = {"stiffnesses": (1e6,), "speeds": (2.0,)}


@pytest.mark.parametrize(
    ("chosen", "runs"),
    [
        pytest.param(ONE, 1, id="one run"),
        pytest.param({}, 6, id="six runs", marks=pytest.mark.slow),
    ],
)
def test_the_runs_of_the_source_by_both_solvers(chosen, runs):
    """RK4 with its default step against the propagator without a step, every window."""
    tables = [impulse_table(windows=WINDOWS, solver=name, **chosen) for name in ("rk4", "exact")]
    assert len(tables[0]) == 19 * runs * 2 * 3
    for stepped, exact in zip(*tables, strict=True):
        assert math.isnan(stepped.ratio) == math.isnan(exact.ratio)
        assert stepped.ratio == pytest.approx(exact.ratio, abs=1e-5, nan_ok=True)


@settings(max_examples=15, deadline=None)
@given(
    st.floats(3, 8), st.floats(-3, 3), st.floats(-1, 2), st.floats(-4, -2.2),
    st.sampled_from(["overlap", "deformable"]), st.integers(1, 6),
)  # fmt: skip
def test_only_gamma_counts(stiffness, mass, gravity, gamma, law, height):
    k, m, g = 10**stiffness, 10**mass, 10**gravity
    speed = g / (10**gamma * math.sqrt(k / m))
    same = impulse_table(
        heights=(height,), stiffnesses=(k,), speeds=(speed,), laws=(law,),
        windows=("turnaround", "first-contact"), case=Tower(mass=m, gravity=g),
    )  # fmt: skip
    unit = impulse_table(
        heights=(height,), stiffnesses=(1.0,), speeds=(1.0,), laws=(law,),
        windows=("turnaround", "first-contact"), case=Tower(mass=1.0, gravity=10**gamma),
    )  # fmt: skip
    for one, other in zip(same, unit, strict=True):
        assert one.ratio == pytest.approx(other.ratio, abs=1e-6)


def grain_velocity(tau, height):
    """Return v/v0 of the grain on a closed overlap row of n = ``height`` contacts, g = 0.

    An unbounded row struck at one site moves as J_2r(tau) at distance r. A free
    end is a mirror between sites, a fixed one a mirror with a change of sign at
    its site, 2n + 1 apart between images: site 1 and its image 0, moved by p (2n + 1),
    with sign (-1)^p.
    """
    period = 2 * height + 1
    return sum(
        (-1) ** p * (jv(2 * abs(p * period), tau) + jv(2 * abs(1 - p * period), tau))
        for p in range(-4, 5)
    )


def first_contact_ratio(height):
    """Return alpha where the force on the grain, -dv/dt, first vanishes."""

    def force(tau):
        return (grain_velocity(tau - 1e-4, height) - grain_velocity(tau + 1e-4, height)) / 2e-4

    leaves = brentq(force, 3.5, 6.5, xtol=1e-12)
    return (1 - grain_velocity(leaves, height)) / 2


@pytest.mark.parametrize("height", [40, 60])
def test_tall_towers_without_gravity_meet_the_bessel_limit(height):
    ratio = ratios("overlap", (height,), "first-contact", solver="exact", case=Tower(gravity=0.0))[
        0
    ]
    assert ratio == pytest.approx(KNOWN_BESSEL_RATIO, abs=1e-7)


@pytest.mark.parametrize("height", [3, 4, 5, 8])
def test_first_contact_by_images(height):
    """The echo adds J_4n(tau) and beyond, tiny at tau = 5.14 from n = 5 on: no n in the limit."""
    ratio = ratios("overlap", (height,), "first-contact", solver="exact", case=Tower(gravity=0.0))[
        0
    ]
    assert ratio == pytest.approx(first_contact_ratio(height), abs=1e-8)
    echo = jv(4 * height, 5.135622)
    assert abs(ratio - KNOWN_BESSEL_RATIO) < echo + 1e-7


def test_energy_scaling():
    frame = energy_scaling_angles(range(1, 11))
    assert frame["impulse_ratio"].iloc[3] == 0.5
    assert frame["critical_angle_lost_deg"].iloc[0] == pytest.approx(10.2078, abs=1e-4)
    assert frame["critical_angle_lost_deg"].iloc[-1] == pytest.approx(2.64, abs=0.01)
    assert frame["critical_angle_lost_deg"].is_monotonic_decreasing
    assert frame["critical_angle_kept_deg"].is_monotonic_increasing


def test_a_window_that_does_not_exist_leaves_nan():
    frame = impulse_angles(
        heights=(2, 9), stiffnesses=(1e6,), speeds=(2.0,), laws=("overlap",),
        windows=("structure",), solver="exact",
    )  # fmt: skip
    gone = frame.set_index("height").loc[9]
    assert all(math.isnan(gone[name]) for name in ("impulse_ratio", "critical_angle_deg"))
    assert frame["impulse_ratio"].iloc[0] == pytest.approx(0.7846, abs=1e-4)
