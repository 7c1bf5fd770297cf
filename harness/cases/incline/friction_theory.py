"""The critical angle of the incline with friction, or of a grain of another size: what is shown."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from harness.errors import RequestError
from harness.shown import Result
from harness.theory.incline_coulomb import (
    LARGEST_FRICTION,
    Grain,
    LeavesRow,
    integrated_critical_angle,
    integrated_no_flight_bound,
    kept_energy,
    largest_half_angle,
)
from harness.theory.incline_friction import (
    INERTIA,
    Shape,
    critical_angle,
    kept_speed,
    no_flight_bound,
    rolling_friction,
    size_ratio,
    sticking_friction,
    well_half_angle,
)

if TYPE_CHECKING:
    from harness.shown.figure import Figure

FRICTIONLESS = "closed form, no friction"
ROLLING = "closed form, rolls without slip"
INTEGRATED = "integrated: rigid grain, Coulomb friction in shock and on arcs"
HIGHEST_FRICTION = 1e9
LARGEST_SIZE_RATIO = 100.0  # its critical angle is 5.6e-5 deg


@dataclass(frozen=True, repr=False, kw_only=True)
class FrictionTheory(Result):
    """Critical angle of a grain of any size with friction; angles in degrees.

    ``model`` says whether the angle is a closed form. Energies are in m g (R + r), kinetic and at
    the critical angle; ``shock`` is energy after over energy before. From ``sticking_friction`` on
    a shock of a rolling grain sticks, from ``rolling_friction`` on the grain rolls all along.
    Smaller grains than ``smallest_grain_diameter_m`` leave the row below their critical angle.
    ``no_flight_bound_deg`` is None where steady motion is not found within 180 wells.
    """

    critical_angle_deg: float
    model: str
    friction: float
    shape: Shape
    diameter_m: float
    grain_diameter_m: float
    smallest_grain_diameter_m: float
    sticking_friction: float
    rolling_friction: float
    shock: float
    static_angle_deg: float
    no_flight_bound_deg: float | None
    well_depth: float
    gain_per_crest: float
    steady_energy: float

    def summary(self) -> dict[str, str]:
        """Return the angle, its model and its bounds."""
        return {
            "critical angle": f"{self.critical_angle_deg:.7g} deg ({self.model})",
            "shock": f"{self.shock:.7g} of the energy is left",
            "friction that sticks": f"{self.sticking_friction:.7g} in the shock, "
            f"{self.rolling_friction:.7g} all along",
            "smallest grain": f"{self.smallest_grain_diameter_m:.7g} m",
            "case": f"incline, {self.shape} of {self.grain_diameter_m:g} m on "
            f"{self.diameter_m:g} m, friction {self.friction:g}",
        }

    def draw(self) -> Figure:
        """Draw the critical angle against friction, this one marked."""
        import numpy as np

        from harness.shown.figure import Figure, label

        inertia, half = INERTIA[self.shape], self.static_angle_deg
        most = 1.3 * max(self.friction, min(1.0, self.sticking_friction * 2.0))
        frictions = np.linspace(0.0, most, 81)
        angles = [_angle_or_nan(float(friction), inertia, half) for friction in frictions]
        figure = Figure(figsize=(6.4, 3.9), layout="constrained")
        axes = figure.add_subplot()
        axes.plot(frictions, angles)
        axes.plot(self.friction, self.critical_angle_deg, "o")
        label(axes, "friction coefficient", "critical angle (deg)")
        return figure


def _angle_or_nan(friction: float, inertia: float, half_angle_deg: float) -> float:
    try:
        return _angle(friction, inertia, half_angle_deg)[0]
    except LeavesRow:
        return math.nan


def _angle(friction: float, inertia: float, half_angle_deg: float) -> tuple[float, str]:
    """Return the critical angle [deg] and its model."""
    if friction == 0.0:
        angle = critical_angle(half_angle_deg, 0.0)
        if half_angle_deg > largest_half_angle(Grain(0.0, inertia)):
            raise LeavesRow("the grain leaves the row below its critical angle")
        return angle, FRICTIONLESS
    if friction >= rolling_friction(half_angle_deg, inertia):
        return critical_angle(half_angle_deg, inertia), ROLLING
    return integrated_critical_angle(half_angle_deg, _grain(friction, inertia)), INTEGRATED


def _grain(friction: float, inertia: float) -> Grain:
    return Grain(min(friction, LARGEST_FRICTION), inertia)


def friction_theory(
    friction: float = 0.0,
    grain_diameter: float | None = None,
    shape: Shape = "sphere",
    diameter: float = 1.0,
) -> FrictionTheory:
    """Return the critical angle with friction mu, of a grain and a row of these diameters [m].

    Raise RequestError for values out of range, and for a grain so small that it leaves the row,
    with the bound.
    """
    grain_diameter = diameter if grain_diameter is None else grain_diameter
    _check(friction, grain_diameter, shape, diameter)
    half, inertia = well_half_angle(grain_diameter / diameter), INERTIA[shape]
    smallest = diameter * size_ratio(largest_half_angle(_grain(friction, inertia)))
    try:
        angle, model = _angle(friction, inertia, half)
    except LeavesRow:
        raise RequestError(
            f"grain-diameter = {grain_diameter!r} is not allowed: must be at least "
            f"{math.ceil(1e6 * smallest / diameter) * 1e-6 * diameter:.7g} m at friction "
            f"{friction:g}, a smaller grain leaves the row below its critical angle"
        ) from None
    coupled = inertia if model == ROLLING else 0.0
    tilt, phi = math.radians(angle), math.radians(half)
    depth, gain = 1.0 - math.cos(phi - tilt), 2.0 * math.sin(phi) * math.sin(tilt)
    if model == INTEGRATED:
        before, after = kept_energy(angle, half, _grain(friction, inertia))
    else:
        before, after = depth + gain, depth
    flight = (
        no_flight_bound(half, 0.0)
        if model == FRICTIONLESS
        else integrated_no_flight_bound(half, _grain(friction, inertia))
    )
    return FrictionTheory(
        critical_angle_deg=angle,
        model=model,
        friction=friction,
        shape=shape,
        diameter_m=diameter,
        grain_diameter_m=grain_diameter,
        smallest_grain_diameter_m=smallest,
        sticking_friction=sticking_friction(half, inertia),
        rolling_friction=rolling_friction(half, inertia),
        shock=after / before if model == INTEGRATED else kept_speed(half, coupled) ** 2,
        static_angle_deg=half,
        no_flight_bound_deg=flight,
        well_depth=depth,
        gain_per_crest=gain,
        steady_energy=after,
    )


def _check(friction: float, grain_diameter: float, shape: str, diameter: float) -> None:
    if not 0.0 <= friction <= HIGHEST_FRICTION:
        raise RequestError(f"friction = {friction!r} is not allowed: must be from 0 to 1e9")
    if shape not in INERTIA:
        raise RequestError(f"shape = {shape!r} is not allowed: must be 'sphere' or 'disc'")
    for name, value in (("diameter", diameter), ("grain-diameter", grain_diameter)):
        if not 1e-30 <= value <= 1e30:
            raise RequestError(f"{name} = {value!r} is not allowed: must be from 1e-30 to 1e30 m")
    if grain_diameter > LARGEST_SIZE_RATIO * diameter:
        raise RequestError(
            f"grain-diameter = {grain_diameter!r} is not allowed: must be at most "
            f"{LARGEST_SIZE_RATIO * diameter:g} m, 100 times that of the row"
        )
