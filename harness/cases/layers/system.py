"""Layers of frictionless spheres on a rough base that is tilted, in the scales of a grain.

Lengths are in diameters d, masses in m, times in sqrt(d/g): the stiffness is in weights over
diameters, k d / (m g). Parameters, the values that a script takes, and what is read of a descent:
angles, the flow before them, and the rest after.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Literal, Self

import numpy as np
from pydantic import BeforeValidator, Field, model_validator

from harness.engines.contract import Job, Template, Value
from harness.engines.output import Output
from harness.errors import EngineLostAtomsError, EngineOutputError, EngineUndecidedError
from harness.observables.provenance import numbers
from harness.parameters.allowed import allowed_in
from harness.parameters.base import Parameters
from harness.parameters.law import PLASTIC, Contact, NamedContact, contact_allowed, contact_values

if TYPE_CHECKING:
    from numpy.typing import NDArray


CLIPPED_CONTACT = Contact(name="e = 0.1, clipped", restitution=0.1, tail="clipped")

SOFTEST = 20.0
"""[m g/d] for each layer: the weight presses 5 % of a diameter into the lowest contact."""


def _with_tail(value: object) -> object:
    return {"tail": "clipped", **value} if isinstance(value, dict) else value


class Packing(Parameters):
    """Layers of grains on a base in a periodic box, and how they are simulated."""

    contact: Annotated[NamedContact, BeforeValidator(_with_tail)] = Field(
        CLIPPED_CONTACT, description="[-] dissipation of the contact; its tail is clipped"
    )
    layers: int = Field(
        4, ge=1, le=100, description="[-] of grains, each with as many as the base has spheres"
    )
    length: int = Field(16, ge=2, le=10000, description="[d] of the box along the flow")
    width: int = Field(
        8, ge=1, le=10000, description="[d] of the box across; 1: all spheres in one plane"
    )
    filled: int = Field(
        0, ge=0, description="[d] of the length that grains are placed over; 0: all of it"
    )
    base: Literal["ordered", "disordered"] = Field(
        "disordered", description="[-] touching rows side by side, or displaced at random"
    )
    roughness: float = Field(
        0.6, ge=0.0, lt=1.0, description="[d] range of heights of a disordered base"
    )
    polydispersity: float = Field(
        0.05, ge=0.0, le=0.2, description="[-] w: half the grains are 1 + w, half 1 - w wide"
    )
    seed: int = Field(1, ge=1, le=10000, description="[-] of base, sizes and places")
    stiffness_over_weight: float = Field(
        1e3, ge=SOFTEST, le=1e9, description="[-] normal stiffness k d / (m g)"
    )
    steps_per_contact: float = Field(
        15.0, gt=0.0, le=1e4, description="[-] steps per contact time pi sqrt(m/k)"
    )

    @model_validator(mode="after")
    def _is_sound(self) -> Self:
        least = SOFTEST * self.layers
        if self.stiffness_over_weight < least:
            raise ValueError(
                f"stiffness_over_weight = {self.stiffness_over_weight:g}: is too soft; must be at "
                f"least {least:g} for {self.layers} layers"
            )
        if self.length < self.layers:
            raise ValueError(
                f"length = {self.length} d: is too small for {self.layers} layers; must be at "
                f"least {self.layers}"
            )
        if self.width == 2 or 1 < 2 * self.width < self.layers:
            raise ValueError(
                f"width = {self.width} d: must be 1, or at least 3 and half the {self.layers} "
                "layers"
            )
        if self.filled > self.length:
            raise ValueError(f"filled = {self.filled} d: must be at most length = {self.length} d")
        self._check_contact()
        return self

    def _check_contact(self) -> None:
        if self.base == "disordered" and self.roughness >= self.widest_roughness:
            raise ValueError(
                f"roughness = {self.roughness:g} d: grains fall through the base; must be less "
                f"than {self.widest_roughness:.6g}"
            )
        if self.contact.tail != "clipped" or self.contact.effective_mass != "full":
            raise ValueError(
                f"contact = {self.contact.name!r}: must have the clipped tail and the effective "
                "mass 'full'"
            )
        if self.steps_per_contact < self.fewest_steps_per_contact * (1.0 - 1e-12):
            raise ValueError(
                f"steps_per_contact = {self.steps_per_contact:g}: must be at least "
                f"{self.fewest_steps_per_contact:.6g}, below which it is unstable"
            )

    @property
    def fewest_steps_per_contact(self) -> float:
        """Return the least that is stable in a packing, where a grain has up to twelve neighbours.

        Gershgorin: a mode feels at most 8 k/m of springs and 8 sqrt(2) zeta sqrt(k/m) of dashpots;
        velocity-Verlet with the dashpot taken explicitly holds while
        (frequency step)^2 / 4 + rate step / 2 <= 1.
        """
        zeta = self.contact.zeta
        return math.pi / (math.sqrt(2.0 * zeta**2 + 0.5) - math.sqrt(2.0) * zeta)

    @property
    def widest_roughness(self) -> float:
        """Return the roughness [d] at which a small grain passes four spheres of the base.

        Heights move by half of it at most, places by a quarter along and across.
        """
        return (4.0 - 2.0 * self.polydispersity - math.sqrt(8.0)) / math.sqrt(2.0)

    @property
    def base_spheres(self) -> int:
        """Return how many spheres are fixed."""
        return self.length * self.width

    @property
    def grains(self) -> int:
        """Return how many grains move."""
        return self.layers * (self.filled or self.length) * self.width

    @property
    def step(self) -> float:
        """Return the time step [sqrt(d/g)]."""
        return math.pi / math.sqrt(self.stiffness_over_weight) / self.steps_per_contact


class Layers(Packing):
    """One descent of the angle until the layers stop, and a rise until they start again."""

    first_angle: float = Field(20.0, gt=0.0, le=45.0, description="[deg] of the first flow")
    lowest_angle: float = Field(1.0, ge=0.0, le=45.0, description="[deg] at which lowering ends")
    flow_time: float = Field(
        40.0, gt=1.0, le=1e5, description="[-] at the first angle, in sqrt(d/g)"
    )
    rate: float = Field(
        0.1, gt=0.0, le=10.0, description="[deg] lower for each diameter of mean displacement"
    )
    rise: float = Field(
        0.0, ge=0.0, le=1.0, description="[deg] of raising in each sqrt(d/g); 0: no angle of start"
    )
    arrest_speed: float = Field(
        0.01, gt=0.0, le=0.1, description="[-] mean speed of an arrest at most, in sqrt(g d)"
    )
    arrest_ratio: float = Field(
        1e-5, gt=0.0, le=1e-2, description="[-] kinetic over elastic energy of an arrest at most"
    )
    time_limit: float = Field(
        5000.0, gt=0.0, le=1e6, description="[-] of lowering and of raising, in sqrt(d/g)"
    )

    @model_validator(mode="after")
    def _holds(self) -> Layers:
        if self.lowest_angle >= self.first_angle:
            raise ValueError(
                f"lowest_angle = {self.lowest_angle:g} deg: must be less than first_angle = "
                f"{self.first_angle:g} deg"
            )
        return self


SINGLE = Layers(
    contact=PLASTIC,
    layers=1,
    length=4,
    width=1,
    filled=1,
    base="ordered",
    polydispersity=0.0,
    stiffness_over_weight=1e4,
    steps_per_contact=100.0,
    first_angle=10.5,
    rate=0.02,
    flow_time=10.0,
)
"""One grain on a row: the incline, whose critical angle is known."""

RAISED = SINGLE.replace(rise=0.05)
"""The same grain, raised again until it leaves its well."""


STOPPED = "stopped"

QUANTITIES = numbers(
    stop_angle_deg="[deg] at which the flow came to rest as it was lowered",
    start_angle_deg="[deg] at which the rest began to flow as it was raised",
    stop_angle_at_100_times_the_ratio_deg="[deg] by 100 times the ratio of energies",
    stop_angle_by_speed_deg="[deg] by the mean speed alone",
    mean_speed="[-] of the grains in the flow (descent: first angle), in sqrt(g d)",
    kinetic_over_elastic="[-] energies at the first angle",
    coordination="[-] contacts of a grain in the flow (descent: first angle)",
    solid_fraction="[-] of the middle half of the grains in the flow (descent: first angle)",
    mean_height="[-] of the grains in the flow (descent: first angle), in d above the base",
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
    declared = [quantity.name for quantity in QUANTITIES]
    values = {name: output.number(name) for name in declared if output.has(name)}
    if verdict != STOPPED:
        if output.has("profile"):
            values["solid_fraction"] = profile_in(output).middle_fraction
        raise EngineUndecidedError(f"undecided: {_why(case, verdict, output)}", values)
    missing = [name for name in declared if name not in (*values, *OPTIONAL, "solid_fraction")]
    if missing:
        raise EngineOutputError(f"{output.who} left an incomplete result ({missing[0]!r})")
    return {**values, "solid_fraction": profile_in(output).middle_fraction}


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


NAME = "layers"
"""Name of the case, and of its template."""

DISSIPATION = ("damping", "restitution", "damping_ratio")
"""Values of a contact that scripts take: the others are fixed here."""


def values_of(case: Packing) -> dict[str, Value]:
    """Return the values of a script for a descent, or a flow at one angle."""
    contact = contact_values(case.contact)
    values = {name: getattr(case, name) for name in type(case).model_fields if name != "contact"}
    return {**values, **{name: contact[name] for name in DISSIPATION}}


CONTACT_ALLOWED = {
    name: allowed for name, allowed in contact_allowed().items() if name in DISSIPATION
}

TEMPLATE = Template(
    name=NAME,
    variants={"": values_of(Layers())},
    allowed={**allowed_in(Layers), **CONTACT_ALLOWED},
)


def job_of(case: Layers) -> Job:
    """Return the job of a descent."""
    return Job(TEMPLATE, values_of(case))
