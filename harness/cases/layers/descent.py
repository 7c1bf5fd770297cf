"""Frictionless spheres in layers on a tilted rough base: the angle at which their flow stops.

A single grain on an ordered row is the incline: it stops at the incline's critical angle, and
starts where a grain at rest leaves its well.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Self

import numpy as np
from pydantic import Field, model_validator

from harness.cases.base import Check, Level, Quantity
from harness.cases.layers import PREPARED, Floats, Packing, PackingCase, check_base, middle_half
from harness.engines.base import Engine
from harness.engines.output import Output
from harness.errors import EngineOutputError, EngineUndecidedError
from harness.model.law import PLASTIC
from harness.results.rows import Kind, Tolerance
from harness.theory.incline import critical_angle

STATIC_ANGLE_DEG = 30.0  # a grain at rest touches two spheres 30 deg either side of the normal
RISE_DEG = 2.5  # from the stop to the start, of raised runs of 1 to 8 layers
LEAST_SPEED = 0.01  # [sqrt(g d)] of a flow that is not at rest
# time [sqrt(d/g)] for each d of length from the first angle to the stop at 0.1 deg for each d, by
# layers: means over the runs of reports/layers; it goes as the inverse of the rate
LOWERING = {1: 18.5, 2: 29.3, 4: 50.7, 8: 54.3}
LOWERING_RATE = 0.1


class Layers(Packing):
    """One descent of the angle until the layers stop, and a rise until they start again."""

    # fmt: off
    first_angle: float = Field(20.0, gt=0.0, le=45.0, description="[deg] of the first flow")
    lowest_angle: float = Field(1.0, ge=0.0, le=45.0, description="[deg] at which lowering ends")
    flow_time: float = Field(
        40.0, gt=1.0, le=1e5, description="[-] at the first angle, in sqrt(d/g)")
    rate: float = Field(
        0.1, gt=0.0, le=10.0, description="[deg] lower for each diameter of mean displacement")
    rise: float = Field(
        0.0, ge=0.0, le=1.0, description="[deg] of raising in each sqrt(d/g); 0: no angle of start")
    arrest_speed: float = Field(
        0.01, gt=0.0, le=0.1, description="[-] mean speed of an arrest at most, in sqrt(g d)")
    arrest_ratio: float = Field(
        1e-5, gt=0.0, le=1e-2,
        description="[-] kinetic over elastic energy of an arrest at most")
    time_limit: float = Field(
        5000.0, gt=0.0, le=1e6, description="[-] of lowering and of raising, in sqrt(d/g)")
    # fmt: on

    @model_validator(mode="after")
    def _check_angles(self) -> Self:
        if self.lowest_angle >= self.first_angle:
            raise ValueError(
                f"lowest_angle = {self.lowest_angle:g} deg: must be less than first_angle = "
                f"{self.first_angle:g} deg"
            )
        return self

    @property
    def is_single_grain(self) -> bool:
        """Return whether this is one grain on the ordered row of the incline."""
        return self.grains == 1 and self.base == "ordered" and self.width == 1

    @property
    def time(self) -> float:
        """Return the time that a descent is expected to take [sqrt(d/g)]."""
        slowness = float(np.interp(self.layers, [*LOWERING], [*LOWERING.values()]))
        longest = (self.first_angle - self.lowest_angle) / self.rate / LEAST_SPEED
        expected = slowness * self.length * LOWERING_RATE / self.rate
        raising = 0.0 if self.rise == 0.0 else RISE_DEG / self.rise
        return PREPARED + self.flow_time + min(expected, longest, self.time_limit) + raising


SINGLE = Layers(
    contact=PLASTIC, layers=1, length=4, width=1, filled=1, base="ordered", polydispersity=0.0,
    stiffness_over_weight=1e4, steps_per_contact=100.0, first_angle=10.5, rate=0.02, flow_time=10.0,
)  # fmt: skip
RAISED = SINGLE.replace(rise=0.05)  # the same grain, raised again until it leaves its well
SMALL_FLOW = Layers(layers=4, length=8, width=4, first_angle=16.0, rate=0.5)

_OVERLAP_DEG = math.degrees(1.0 / SINGLE.stiffness_over_weight)
STOP = Tolerance(
    SINGLE.rate + _OVERLAP_DEG,
    reason="the angle falls by the rate over the well that is not passed any more; the weight "
    "presses m g/k into the row, an angle of m g/(k d)",
)
START = Tolerance(
    RAISED.rise * math.sqrt(2.0 * RAISED.arrest_speed / math.radians(RAISED.rise)) + _OVERLAP_DEG,
    reason="a grain that slides from rest has the speed of the criterion sqrt(2 speed/rise) later "
    "at most; the weight presses m g/k into the row",
)
SCATTER = Tolerance(0.033, reason="runs of other rounding part: twice the scatter over six bases")


def profile_in(output: Output) -> dict[str, Floats]:
    """Return means over slices of the flow at the first angle; raise EngineOutputError for none.

    Heights are in d above the mean height of the base, speeds in sqrt(g d); the solid fraction is
    that of whole grains with centres in the slice.
    """
    rows = output.rows("profile", 3)
    if not len(rows):
        raise EngineOutputError(f"{output.engine} left no profile of the flow")
    return dict(zip(("height", "solid_fraction", "speed"), rows.T, strict=True))


def middle_fraction(output: Output) -> float:
    """Return the mean solid fraction between the quartiles of the grains' heights."""
    fraction = profile_in(output)["solid_fraction"]
    return float(fraction[middle_half(fraction)].mean())


class LayersCase(PackingCase[Layers]):
    """Frictionless layers on a rough base: the angle at which their flow stops, starts."""

    name = "layers"
    parameters = Layers
    quantities = (
        Quantity("stop_angle_deg", "deg", "at which the flow came to rest as it was lowered", 10.0),
        Quantity("start_angle_deg", "deg", "at which the rest began to flow as it was raised",
                 10.0),
        Quantity("stop_angle_at_100_times_the_ratio_deg", "deg", "by 100 times the ratio of "
                 "energies", 10.0),
        Quantity("stop_angle_by_speed_deg", "deg", "by the mean speed alone", 10.0),
        Quantity("mean_speed", "1", "of the grains at the first angle, in sqrt(g d)", 0.1),
        Quantity("kinetic_over_elastic", "1", "energies at the first angle", 10.0),
        Quantity("coordination", "1", "contacts of a grain at the first angle"),
        Quantity("solid_fraction", "1", "of the middle half of the grains at the first angle", 0.1),
        Quantity("mean_height", "1", "of the grains at the first angle, in d above the base"),
        Quantity("rest_coordination", "1", "contacts of a grain at rest"),
        Quantity("rest_mean_height", "1", "of the grains at rest, in d above the base"),
        Quantity("lowering_time", "1", "from the first angle to the rest, in sqrt(d/g)", 100.0),
        Quantity("steps", "1", "time steps that were taken", lambda p: p.time / p.step),
    )  # fmt: skip
    presets = {"layers": Layers(), "single": SINGLE, "small": SMALL_FLOW}  # noqa: RUF012

    def measure(self, parameters: Layers, output: Output) -> Mapping[str, float]:
        """Return angles and means.

        Raise EngineLostAtomsError for a grain below the base, EngineUndecidedError, with the values
        that were measured, for a flow that never started or never stopped.
        """
        verdict = output.text("verdict")
        check_base(parameters, verdict)
        names = [quantity.name for quantity in self.quantities]
        values = {name: output.number(name) for name in names if output.has(name)}
        if output.has("profile"):
            values["solid_fraction"] = middle_fraction(output)
        if verdict != "stopped":
            raise EngineUndecidedError(f"undecided: {_reason(parameters, output)}", values)
        for name in names:
            if name not in values and name != "start_angle_deg":
                raise EngineOutputError(f"{output.engine} left an incomplete result ({name!r})")
        return values

    def exact(self, parameters: Layers) -> Mapping[str, float]:
        """Return the angles of a single grain on the row; without rebound also that of the stop."""
        if not parameters.is_single_grain:
            return {}
        angles = {"start_angle_deg": STATIC_ANGLE_DEG}
        if parameters.contact.zeta >= PLASTIC.zeta:
            angles["stop_angle_deg"] = critical_angle()
        return angles

    def profile(self, parameters: Layers, output: Output) -> Mapping[str, Sequence[float]]:
        """Return the profile of the flow at the first angle."""
        return {name: values.tolist() for name, values in profile_in(output).items()}

    def checks(self, engine: Engine) -> Iterable[Check]:
        """Return the single grain, lowered; beyond level quick raised as well."""
        yield self._angle("one grain on a row, lowered", "stop_angle_deg", SINGLE, STOP, "quick")
        yield self._angle("one grain on a row, raised", "start_angle_deg", RAISED, START, "default")
        flow = self.job(SMALL_FLOW)
        yield Check(
            setup="4 layers, 8 x 4 d, from 16 deg", quantity="solid_fraction", unit="1",
            kind=Kind.RECORDED, jobs=[flow], tolerance=SCATTER,
            measure=lambda bench: middle_fraction(bench.output(flow)),
        )  # fmt: skip

    def _angle(self, setup: str, name: str, p: Layers, tolerance: Tolerance, level: Level) -> Check:
        job = self.job(p)
        return Check(
            setup=setup, quantity=name, unit="deg", kind=Kind.ANALYTIC, level=level, jobs=[job],
            measure=lambda bench: self.measure(p, bench.output(job))[name],
            expected=self.exact(p)[name], tolerance=tolerance,
        )  # fmt: skip


def _reason(p: Layers, output: Output) -> str:
    """Return why a descent has no angle; raise EngineOutputError for an unknown verdict."""
    verdict = output.text("verdict")
    if verdict == "never_started":
        return (
            f"the flow never started: at rest after flow_time = {p.flow_time:g} at first_angle = "
            f"{p.first_angle:g} deg"
        )
    if verdict != "never_stopped":
        raise EngineOutputError(f"{output.engine} left an unknown verdict {verdict!r}")
    angle = output.number("last_angle_deg")
    if angle < p.lowest_angle:
        return f"the flow never stopped above lowest_angle = {p.lowest_angle:g} deg"
    return f"the flow never stopped within time_limit = {p.time_limit:g}; it was at {angle:.4g} deg"


CASE = LayersCase()
