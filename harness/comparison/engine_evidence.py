"""What engines beside one another left: who they are, their critical angles and their towers."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass, field
from typing import Any

from harness.cases.tower.step_convergence import StepConvergence

OWN = "reference"
"""The harness's own DEM, that the others are held against."""


@dataclass(frozen=True)
class Rules:
    """The class of a contact law. Results are one only within a class."""

    tail: str
    effective_mass: str
    spring: str

    @property
    def text(self) -> str:
        """Return the class in words."""
        mass = "m" if self.effective_mass == "full" else "m/2"
        return f"{self.tail} tail, m_eff {mass}, {self.spring} spring"


@dataclass(frozen=True)
class Declared:
    """What an engine declares of itself, and what became of it here.

    ``version`` is empty where it could not be run, ``missing`` says why; ``unqualified``
    names the checks of its qualification that failed. ``lineage`` is the engine
    that it grew out of.
    """

    engine: str
    version: str
    how: str
    install_hint: str
    versions: tuple[str, ...]
    integrator: str
    tails: tuple[str, ...]
    effective_masses: tuple[str, ...]
    spring: str
    digits: int
    lineage: str
    caveats: tuple[str, ...]
    missing: str = ""
    unqualified: str = ""

    @property
    def standing(self) -> str:
        """Return whether the engine was used, and why not."""
        if self.missing:
            return "missing"
        return "did not qualify" if self.unqualified else "qualified"


@dataclass(frozen=True)
class EngineAngle:
    """A critical angle [deg] of an engine, beside theory and the reference DEM under its rules.

    ``reference_deg`` is NaN where the reference DEM has no such rules;
    ``microseconds_per_step`` is the cost, NaN where none was measured. ``lineage`` is the
    engine that it grew out of. A ``recorded`` angle was measured elsewhere.
    """

    engine: str
    contact: str
    rules: Rules
    stiffness: float  # [N/m]
    steps_per_contact: float
    value_deg: float
    uncertainty_deg: float
    closed_form_deg: float
    integrator: str
    reference_deg: float = math.nan
    reference_uncertainty_deg: float = math.nan
    microseconds_per_step: float = math.nan
    lineage: str = ""
    recorded: bool = False

    @property
    def off_theory_deg(self) -> float:
        """Return the difference from the closed form [deg]."""
        return self.value_deg - self.closed_form_deg

    @property
    def off_reference_deg(self) -> float:
        """Return the difference from the reference DEM under the same rules [deg]."""
        return self.value_deg - self.reference_deg

    @property
    def evidence(self) -> str:
        """Return what kind of evidence the value is."""
        if self.recorded:
            return "recorded"
        if self.engine == OWN:
            return "the harness's own"
        return "regression partner" if self.lineage else "independent"

    def record(self) -> dict[str, Any]:
        """Return the angle as a flat JSON-ready mapping."""
        return {
            "engine": self.engine,
            "contact": self.contact,
            **asdict(self.rules),
            "stiffness_N_per_m": self.stiffness,
            "steps_per_contact": self.steps_per_contact,
            "critical_angle_deg": self.value_deg,
            "uncertainty_deg": self.uncertainty_deg,
            "off_theory_deg": self.off_theory_deg,
            "reference_deg": self.reference_deg,
            "off_reference_deg": self.off_reference_deg,
            "integrator": self.integrator,
            "microseconds_per_step": self.microseconds_per_step,
            "evidence": self.evidence,
        }


@dataclass(frozen=True)
class EngineTower:
    """Peak force [N] and turnaround impulse [N s] of a tower, beside the exact propagator's.

    The impulse is NaN where none was recorded.
    """

    engine: str
    height: int
    steps_per_contact: float
    peak_force: float
    exact_peak_force: float
    impulse: float = math.nan
    exact_impulse: float = math.nan
    recorded: bool = False

    @property
    def peak_error(self) -> float:
        """Return the relative error of the peak force."""
        return self.peak_force / self.exact_peak_force - 1.0

    @property
    def impulse_error(self) -> float:
        """Return the relative error of the impulse."""
        return self.impulse / self.exact_impulse - 1.0

    def record(self) -> dict[str, Any]:
        """Return the tower as a flat JSON-ready mapping."""
        return {
            "engine": self.engine,
            "height": self.height,
            "steps_per_contact": self.steps_per_contact,
            "peak_force_N": self.peak_force,
            "peak_force_relative_error": self.peak_error,
            "impulse_Ns": self.impulse,
            "impulse_relative_error": self.impulse_error,
            "recorded": self.recorded,
        }


@dataclass
class EngineEvidence:
    """Everything that engines held against each other left, engine by engine."""

    closed_form_deg: float
    declared: list[Declared] = field(default_factory=list)
    angles: list[EngineAngle] = field(default_factory=list)
    towers: list[EngineTower] = field(default_factory=list)
    convergence: list[StepConvergence] = field(default_factory=list)

    def record(self) -> dict[str, Any]:
        """Return everything but the series as a JSON-ready mapping."""
        return {
            "declared": [{**asdict(d), "standing": d.standing} for d in self.declared],
            "critical_angles": [angle.record() for angle in self.angles],
            "towers": [tower.record() for tower in self.towers],
            "orders": [found.record() for found in self.convergence],
        }
