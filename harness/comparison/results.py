"""The published form of a run: what results.json holds, validated when it is read.

These models are the one source: the committed JSON Schema is generated from
them, and :func:`harness.workflows.diff` reads runs with them.
"""

from __future__ import annotations

import math
from typing import Annotated, Any, Literal

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, WithJsonSchema

from harness.comparison.verdicts import Kind, Verdict
from harness.comparison.verification import SCHEMA


def _nan(value: Any) -> Any:
    return math.nan if value is None else value


Number = Annotated[
    float, BeforeValidator(_nan), WithJsonSchema({"anyOf": [{"type": "number"}, {"type": "null"}]})
]
"""A number; what was not finite or is not there is null in JSON, and NaN here."""


class _Published(BaseModel):
    """Base of the models: later versions may add keys, which readers pass over."""

    model_config = ConfigDict(frozen=True, extra="allow")


class CheckRow(_Published):
    """One check: a value, what it is held against, and the verdict."""

    name: str = Field(description="unique within its kind in most runs; not across kinds")
    kind: Kind = Field(description="what the value is held against; kinds are never mixed")
    unit: str = Field(description="of value, expected, difference, uncertainty and tolerance")
    value: Number
    expected: Number
    difference: Number = Field(description="value - expected, in full")
    uncertainty: Number = Field(description="of the measurement")
    tolerance: Number = Field(description="largest difference that passes; null for a finding")
    verdict: Verdict
    why: str = Field("", description="where the tolerance comes from")
    note: str = Field("", description="what went wrong, or what is to be seen")
    triage: str = Field("", description="class of a failure; empty for a check that holds")
    engine_died: bool = False
    log: str = Field("", description="file under logs/ with what a failed run left; or empty")

    @property
    def judged(self) -> bool:
        """Return whether the check has a verdict that holds or fails."""
        return self.verdict in (Verdict.PASS, Verdict.FAIL)


class EngineRow(_Published):
    """Who ran: engine, release, packages, how it was started."""

    engine: str
    engine_version: str
    packages: tuple[str, ...] = ()
    executable: str = ""
    how: str = Field("", description="in-process, executable, or the launcher's command")


class ExtrapolatedRow(_Published):
    """The critical angle for a step to zero, then a stiffness to infinity."""

    critical_angle_deg: Number
    uncertainty_deg: Number


class AngleRow(_Published):
    """A critical angle at one contact, stiffness and step."""

    critical_angle_deg: Number
    uncertainty_deg: Number
    method: str
    contact: str
    stiffness_N_per_m: Number
    steps_per_contact: Number


class DivergenceRow(_Published):
    """A series that left the band about its reference, and when."""

    case: str
    column: str
    largest_difference: Number = Field(description="from the reference, over the whole series")
    band: Number = Field(description="largest difference that passes")
    divergence_time_s: Number = Field(description="first time outside for good [s]")
    from_first_step: bool | None = None
    stays: bool | None = Field(None, description="whether it is outside up to the end")


class DeclaredRow(_Published):
    """What an engine declares of itself, and whether it was used."""

    engine: str
    version: str = Field(description="empty where it could not be run")
    how: str
    install_hint: str = Field(description="how to get it")
    versions: tuple[str, ...] = Field(description="versions that it was tried with")
    integrator: str = Field(description="its scheme, by the reference DEM's name")
    tails: tuple[str, ...]
    effective_masses: tuple[str, ...] = Field(description="against a fixed sphere: m or m/2")
    spring: str
    digits: int = Field(description="of its output")
    lineage: str = Field(description="engine that it grew out of; empty for an independent one")
    caveats: tuple[str, ...]
    missing: str = Field(description="why it could not be run; or empty")
    unqualified: str = Field(description="checks of its qualification that failed; or empty")
    standing: Literal["missing", "did not qualify", "qualified"]


class EngineAngleRow(_Published):
    """A critical angle of an engine, beside theory and the reference DEM under its rules."""

    engine: str
    contact: str
    tail: str
    effective_mass: str
    spring: str
    stiffness_N_per_m: Number
    steps_per_contact: Number
    critical_angle_deg: Number
    uncertainty_deg: Number
    off_theory_deg: Number = Field(description="from the closed form")
    reference_deg: Number = Field(description="of the reference DEM; null without such rules")
    off_reference_deg: Number
    integrator: str
    microseconds_per_step: Number
    evidence: str = Field(description="independent, a regression partner, or recorded")


class EngineTowerRow(_Published):
    """A tower of an engine beside the exact propagator."""

    engine: str
    height: int
    steps_per_contact: Number
    peak_force_N: Number
    peak_force_relative_error: Number
    impulse_Ns: Number
    impulse_relative_error: Number
    recorded: bool


class EngineOrderRow(_Published):
    """How the error of an engine's tower falls with its step."""

    solver: str
    height: int
    l2_force_order: Number
    errors: tuple[dict[str, Any], ...]


class EnginesRow(_Published):
    """What engines beside LAMMPS left."""

    declared: tuple[DeclaredRow, ...]
    critical_angles: tuple[EngineAngleRow, ...]
    towers: tuple[EngineTowerRow, ...]
    orders: tuple[EngineOrderRow, ...]


class Results(_Published):
    """One verification run, as results.json holds it."""

    model_config = ConfigDict(title="dem-harness results")

    version: Literal[SCHEMA] = Field(  # type: ignore[valid-type]
        SCHEMA, alias="schema", description="version of this form; 1 where the key is missing"
    )
    level: str = Field(description="quick, default or full")
    started: str = Field(description="ISO 8601, UTC")
    seconds: Number = Field(description="wall time [s]")
    platform: str
    harness_version: str
    status: int = Field(description="exit status: 0 holds, 1 a verdict failed, 3 an engine died")
    engine: EngineRow | None = Field(description="null when no engine could be run")
    engine_errors: tuple[str, ...] = ()
    baseline: str = Field("", description="where the accepted values lie; empty without them")
    divergences: tuple[DivergenceRow, ...] = ()
    closed_form_deg: Number = Field(description="critical angle of the incline by theory [deg]")
    checks: tuple[CheckRow, ...]
    extrapolated: ExtrapolatedRow | None = None
    critical_angles: tuple[AngleRow, ...] = ()
    engines: EnginesRow | None = Field(None, description="null where none were compared")
    scripts: dict[str, str] = Field(
        default_factory=dict, description="SHA-256 of each script that ran, by name"
    )
