"""Read what a descent left: angles, the flow before them, and the rest after."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from harness.cases.layers.parameters import Layers
from harness.engines.output import Output
from harness.errors import EngineLostAtomsError, EngineOutputError, EngineUndecidedError
from harness.observables.declared import numbers

if TYPE_CHECKING:
    from numpy.typing import NDArray

STOPPED = "stopped"

QUANTITIES = numbers(
    stop_angle_deg="[deg] at which the flow came to rest as it was lowered",
    start_angle_deg="[deg] at which the rest began to flow as it was raised",
    stop_angle_at_100_times_the_ratio_deg="[deg] by 100 times the ratio of energies",
    stop_angle_by_speed_deg="[deg] by the mean speed alone",
    mean_speed="[-] at the first angle, in sqrt(g d)",
    kinetic_over_elastic="[-] energies at the first angle",
    coordination="[-] contacts of a grain at the first angle",
    solid_fraction="[-] of the middle half of the grains at the first angle",
    mean_height="[-] of the grains at the first angle, in d above the base",
    rest_coordination="[-] contacts of a grain at rest",
    rest_mean_height="[-] of the grains at rest, in d above the base",
    lowering_time="[-] from the first angle to the rest, in sqrt(d/g)",
    steps="[-] time steps that were taken",
)
"""What a descent measures."""

OPTIONAL = ("start_angle_deg",)


@dataclass(frozen=True)
class Profile:
    """Means over horizontal slices of the flow at the first angle, each (slices,).

    Heights are in d above the mean height of the base, speeds in sqrt(g d); the solid fraction is
    that of whole grains whose centres lie in the slice.
    """

    height: NDArray[np.float64]
    solid_fraction: NDArray[np.float64]
    speed: NDArray[np.float64]

    @property
    def middle_fraction(self) -> float:
        """Return the mean solid fraction between the quartiles of the grains' heights."""
        below = np.cumsum(self.solid_fraction) / self.solid_fraction.sum()
        middle = (below >= 0.25) & (below - self.solid_fraction / self.solid_fraction.sum() <= 0.75)
        return float(self.solid_fraction[middle].mean())


def profile_in(output: Output) -> Profile:
    """Return the profile of the flow; raise EngineOutputError where there is none."""
    rows = output.rows("profile", 3)
    if not len(rows):
        raise EngineOutputError(f"{output.who} left no profile of the flow")
    return Profile(*rows.T)


def read(case: Layers, output: Output) -> Mapping[str, float]:
    """Return the declared quantities.

    Raise EngineLostAtomsError for a grain below the base, EngineUndecidedError, with what was
    measured, for a flow that never started or never stopped: it has no angle.
    """
    verdict = output.text("verdict")
    if verdict == "fell_through":
        raise EngineLostAtomsError(
            f"a grain fell through the base: roughness = {case.roughness:g} d is too much for "
            f"seed = {case.seed}"
        )
    declared = [one.name for one in QUANTITIES]
    found = {name: output.number(name) for name in declared if output.has(name)}
    if verdict != STOPPED:
        if output.has("profile"):
            found["solid_fraction"] = profile_in(output).middle_fraction
        raise EngineUndecidedError(f"undecided: {_why(case, verdict, output)}", found)
    missing = [name for name in declared if name not in (*found, *OPTIONAL, "solid_fraction")]
    if missing:
        raise EngineOutputError(f"{output.who} left an incomplete result ({missing[0]!r})")
    return {**found, "solid_fraction": profile_in(output).middle_fraction}


def _why(case: Layers, verdict: str, output: Output) -> str:
    if verdict == "never_started":
        return (
            f"the flow never started: at rest after flow_time = {case.flow_time:g} at first_angle "
            f"= {case.first_angle:g} deg"
        )
    if verdict != "never_stopped":
        raise EngineOutputError(f"{output.who} left an unknown verdict {verdict!r}")
    angle = output.number("last_angle_deg")
    if angle < case.lowest_angle:
        return f"the flow never stopped above lowest_angle = {case.lowest_angle:g} deg"
    return (
        f"the flow never stopped within time_limit = {case.time_limit:g}; it was at {angle:.4g} deg"
    )
