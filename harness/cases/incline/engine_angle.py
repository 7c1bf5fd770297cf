"""The critical angle of an engine, beside theory and the reference DEM under its rules."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from typing import Any

OWN = "reference"
"""The harness's own DEM, that the others are held against."""


@dataclass(frozen=True)
class Rules:
    """The class of a contact law. Results are comparable only within a class."""

    tail: str
    effective_mass: str
    spring: str

    @property
    def text(self) -> str:
        """Return the class in words."""
        mass = "m" if self.effective_mass == "full" else "m/2"
        return f"{self.tail} tail, m_eff {mass}, {self.spring} spring"

    @property
    def short(self) -> str:
        """Return the class for a table."""
        mass = "m" if self.effective_mass == "full" else "m/2"
        return f"{self.tail}, {mass}, {self.spring}"


@dataclass(frozen=True)
class EngineAngle:
    """A critical angle [deg] of an engine, beside theory and the reference DEM under its rules.

    ``role`` is the contact that ``contact`` stands for in the engine, ``plastic`` or ``source``.
    ``reference_deg`` is NaN where the reference DEM has no such rules;
    ``microseconds_per_step`` is the cost, NaN where none was measured. ``lineage`` is the
    engine that it grew out of. A ``recorded`` angle was measured elsewhere.
    """

    engine: str
    role: str
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
