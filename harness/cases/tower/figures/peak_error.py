"""Error of the largest deformation of two particles: against the step, and against stiffness."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import ArrayLike, NDArray

from harness.comparison.convergence import slope_order
from harness.report.figures.style import COLOURS, MARKERS, STYLES, label, legend_below, panels


def measured_order(sizes: ArrayLike, errors: ArrayLike) -> tuple[float, float]:
    """Return the slope of log error against log size, and half its 95 % interval."""
    slope, (low, high) = slope_order(sizes, errors)
    return slope, (high - low) / 2


def sampled_peak_error(omega_step: ArrayLike) -> NDArray[np.float64]:
    """Return the largest relative error of a peak read off samples [1], ``(omega h)^2 / 4``.

    The largest sample is up to half a step off the top of the wave, whose
    frequency is sqrt(2) omega for two free particles.
    """
    return np.asarray(1 - np.cos(np.sqrt(0.5) * np.asarray(omega_step, dtype=float)))


def peak_error(
    by_step: Mapping[str, tuple[Sequence[float], Sequence[float]]],
    by_stiffness: Mapping[str, tuple[Sequence[float], Sequence[float]]],
) -> Figure:
    """Draw relative errors of the peak deformation of two particles under RK4.

    ``by_step`` maps a name to (steps in units of 1/omega, errors), and its
    legend tells the measured order; ``by_stiffness`` maps a name to (stiffness
    [N/m], errors). With the step in units of the contact time stiffness does not
    matter at all, and with one step in seconds the error of the largest sample
    grows as k h^2. The source reports one that falls with k: that is not the
    error of RK4, but would take steps that shrink faster than k^(-1/2).
    """
    figure = panels(1, 2, width=5.2, height=3.8)
    left, right = figure.axes
    for i, (name, (steps, errors)) in enumerate(by_step.items()):
        slope, half = measured_order(steps, errors)
        left.loglog(
            steps, errors, color=COLOURS[i % 7], marker=MARKERS[i % 6], linestyle="none",
            markersize=4, label=f"{name}: order {slope:.2f} ± {half:.2f}",
        )  # fmt: skip
    span = np.sort(np.concatenate([np.asarray(steps) for steps, _ in by_step.values()]))
    left.loglog(
        span, sampled_peak_error(span), color="0.4", linewidth=1, label="bound of a sample, (ωh)²/4"
    )
    label(left, "step (1/omega)", "relative error of peak deformation", "two particles, RK4")
    draw_against_stiffness(right, by_stiffness)
    label(right, "stiffness (N/m)", "relative error of peak deformation", "two particles, RK4")
    legend_below(figure)
    return figure


def draw_against_stiffness(
    axes: Axes, by_stiffness: Mapping[str, tuple[Sequence[float], Sequence[float]]]
) -> None:
    """Draw named errors against stiffness [N/m], both axes logarithmic."""
    for i, (name, (stiffness, errors)) in enumerate(by_stiffness.items()):
        axes.loglog(
            stiffness, errors, color=COLOURS[i % 7], marker=MARKERS[i % 6],
            linestyle=STYLES[i % 6], markersize=4, label=name,
        )  # fmt: skip
