"""Frictionless spheres in layers on a tilted rough base: the angle of their stop, steady flow.

Both cases have lengths in diameters d, masses in m, times in sqrt(d/g), and the stiffness in
weights over diameters, k d / (m g).
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Annotated, Any, ClassVar, Literal, Self, TypeVar

import numpy as np
from numpy.typing import NDArray
from pydantic import BeforeValidator, Field, model_validator

from harness.cases.base import Case
from harness.engines.base import Job, Template, Value
from harness.errors import EngineLostAtomsError
from harness.model.base import Allowed, Parameters, allowed_in, descriptions
from harness.model.law import Contact, NamedContact

Floats = NDArray[np.float64]
CLIPPED_CONTACT = Contact(name="e = 0.1, clipped", restitution=0.1, tail="clipped")
SOFTEST = 20.0  # [m g/d] for each layer: the weight presses 5 % of d into the lowest contact
DISSIPATION = {  # of a contact, as values of scripts
    "damping": "restitution or ratio: which of the two gives zeta",
    "restitution": "gives zeta of a contact (0: critical); its force never attracts",
    "damping_ratio": "zeta: the dashpot is 2 zeta sqrt(k m_eff)",
}
PREPARED = 20.0  # [sqrt(d/g)] before the angle is set
SECONDS_PER_STEP = 4e-6  # of a particle in the slowest code, for time limits, as of bulk


def _with_tail(value: object) -> object:
    return {"tail": "clipped", **value} if isinstance(value, dict) else value


class Packing(Parameters):
    """Layers of grains on a base in a periodic box, and how they are simulated.

    A system gives the time that a run is expected to take [sqrt(d/g)].
    """

    time: ClassVar[property]

    # fmt: off
    contact: Annotated[NamedContact, BeforeValidator(_with_tail)] = Field(
        CLIPPED_CONTACT, description="[-] dissipation of the contact; its tail is clipped")
    layers: int = Field(
        4, ge=1, le=100, description="[-] of grains, each with as many as the base has spheres")
    length: int = Field(16, ge=2, le=10000, description="[d] of the box along the flow")
    width: int = Field(
        8, ge=1, le=10000, description="[d] of the box across; 1: all spheres in one plane")
    filled: int = Field(
        0, ge=0, description="[d] of the length that grains are placed over; 0: all of it")
    base: Literal["ordered", "disordered"] = Field(
        "disordered", description="[-] touching rows side by side, or displaced at random")
    roughness: float = Field(
        0.6, ge=0.0, lt=1.0, description="[d] range of heights of a disordered base")
    polydispersity: float = Field(
        0.05, ge=0.0, le=0.2, description="[-] w: half the grains are 1 + w, half 1 - w wide")
    seed: int = Field(1, ge=1, le=10000, description="[-] of base, sizes and places")
    stiffness_over_weight: float = Field(
        1e3, ge=SOFTEST, le=1e9, description="[-] normal stiffness k d / (m g)")
    steps_per_contact: float = Field(
        15.0, gt=0.0, le=1e4, description="[-] steps per contact time pi sqrt(m/k)")
    # fmt: on

    @model_validator(mode="after")
    def _check(self) -> Self:
        for wrong, reason in self._flaws():
            if wrong:
                raise ValueError(reason)
        return self

    def _flaws(self) -> Iterable[tuple[bool, str]]:
        """Yield whether values do not go together, each with the reason."""
        layers, softest, fewest = self.layers, SOFTEST * self.layers, self.fewest_steps_per_contact
        contact = self.contact
        # fmt: off
        yield (self.stiffness_over_weight < softest,
               f"stiffness_over_weight = {self.stiffness_over_weight:g}: is too soft; must be at "
               f"least {softest:g} for {layers} layers")
        yield (self.length < layers,
               f"length = {self.length} d: is too small for {layers} layers; must be at least "
               f"{layers}")
        yield (self.width == 2 or 1 < 2 * self.width < layers,
               f"width = {self.width} d: must be 1, or at least 3 and half the {layers} layers")
        yield (self.filled > self.length,
               f"filled = {self.filled} d: must be at most length = {self.length} d")
        yield (self.base == "disordered" and self.roughness >= self.widest_roughness,
               f"roughness = {self.roughness:g} d: grains fall through the base; must be less "
               f"than {self.widest_roughness:.6g}")
        yield (contact.tail != "clipped" or contact.effective_mass != "full",
               f"contact = {contact.name!r}: must have the clipped tail and the effective mass "
               "'full'")
        yield (self.steps_per_contact < fewest * (1.0 - 1e-12),
               f"steps_per_contact = {self.steps_per_contact:g}: must be at least {fewest:.6g}, "
               "below which it is unstable")
        # fmt: on

    @property
    def fewest_steps_per_contact(self) -> float:
        """Return the fewest steps that are stable in a packing, with up to twelve neighbours.

        Gershgorin: a mode feels at most 8 k/m of springs and 8 sqrt(2) zeta sqrt(k/m) of dashpots;
        velocity Verlet with the dashpot taken explicitly is stable while
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
    def grains(self) -> int:
        """Return the number of grains that move."""
        return self.layers * (self.filled or self.length) * self.width

    @property
    def step(self) -> float:
        """Return the time step [sqrt(d/g)]."""
        return math.pi / math.sqrt(self.stiffness_over_weight) / self.steps_per_contact


P = TypeVar("P", bound=Packing)


class PackingCase(Case[P]):
    """A case of layers: its script takes the parameters, and the dissipation of the contact.

    The docstring of a case is its summary.
    """

    group = "layers"
    parameters: ClassVar[type[Packing]]
    template: ClassVar[Template]

    def __init_subclass__(cls, **more: Any) -> None:
        """Make the template of the case from its parameters."""
        super().__init_subclass__(**more)
        cls.summary = cls.__doc__ or ""
        contact = {"damping": Allowed(words=("restitution", "ratio")), **allowed_in(Contact)}
        allowed = {name: contact[name] for name in DISSIPATION if name in contact}
        cls.template = Template(
            cls.name,
            {"": script_values(cls.parameters())},
            allowed=allowed_in(cls.parameters) | allowed,
            about=descriptions(cls.parameters) | DISSIPATION,
        )

    def job(self, parameters: P) -> Job:
        """Return the job of one run."""
        seconds = SECONDS_PER_STEP * self.cost(parameters)
        return Job(self.template, script_values(parameters), seconds=seconds)

    def cost(self, parameters: P) -> float:
        """Return the expected steps of a run times its particles."""
        p = parameters
        return float(p.time / p.step * (p.grains + p.length * p.width))


def script_values(p: Packing) -> dict[str, Value]:
    """Return the values of a script for a descent, or a flow at one angle."""
    contact = p.contact.script_values
    values: dict[str, Value] = {name: value for name, value in p if name != "contact"}
    return {**values, **{name: contact[name] for name in DISSIPATION}}


def check_base(p: Packing, verdict: str) -> None:
    """Raise EngineLostAtomsError for a grain below the base."""
    if verdict == "fell_through":
        raise EngineLostAtomsError(
            f"a grain fell through the base: roughness = {p.roughness:g} d is too much for "
            f"seed = {p.seed}"
        )


def middle_half(share: Floats) -> NDArray[np.bool_]:
    """Return whether slices are between the quartiles of the grains' heights, by their shares."""
    below = np.cumsum(share) / share.sum()
    return np.asarray((below >= 0.25) & (below - share / share.sum() <= 0.75))
