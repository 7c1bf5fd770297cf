"""The published form of a run: what results.json holds, validated when it is read.

These models are the one source: the committed JSON Schema is generated from
them, and :func:`harness.verbs.diff` reads runs with them.
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


class PartingRow(_Published):
    """A series that left the band about its reference, and when."""

    case: str
    column: str
    largest_difference: Number = Field(description="from the reference, over the whole series")
    band: Number = Field(description="largest difference that passes")
    parting_time_s: Number = Field(description="first time outside for good [s]")
    from_first_step: bool | None = None
    stays: bool | None = Field(None, description="whether it is outside up to the end")


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
    partings: tuple[PartingRow, ...] = ()
    closed_form_deg: Number = Field(description="critical angle of the incline by theory [deg]")
    checks: tuple[CheckRow, ...]
    extrapolated: ExtrapolatedRow | None = None
    critical_angles: tuple[AngleRow, ...] = ()
    scripts: dict[str, str] = Field(
        default_factory=dict, description="SHA-256 of each script that ran, by name"
    )
