"""The published form of a run: what results.json holds, and how it is read.

The dataclasses are the one source: the file is their dump, the committed JSON Schema is generated
from them, and :func:`harness.workflows.diff` reads runs with them. Beside their keys stand those
that cases publish, which each case documents.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from harness.comparison.engines import DeclaredEngine
from harness.comparison.findings import Headline
from harness.comparison.published import Number, adapter
from harness.comparison.verdicts import Check
from harness.observables.provenance import Provenance

SCHEMA = 2
"""Version of this form; raised when a key goes or changes its meaning."""


@dataclass(frozen=True)
class DivergenceRow:
    """A series that left the band about its reference, and when.

    ``largest_difference`` is over the whole series, ``band`` the largest that passes;
    ``divergence_time_s`` is the first time outside for good [s], ``stays`` whether it is outside
    up to the end.
    """

    case: str
    column: str
    largest_difference: Number
    band: Number
    divergence_time_s: Number
    from_first_step: bool | None = None
    stays: bool | None = None


@dataclass(frozen=True)
class Engines:
    """What engines beside the main one declare; keys of cases stand beside it."""

    declared: tuple[DeclaredEngine, ...] = ()


@dataclass(frozen=True)
class Results:
    """One verification run, as results.json holds it.

    ``schema`` is the version of this form, 1 where the key is missing. ``level`` is quick,
    default or full; ``started`` ISO 8601 in UTC; ``seconds`` the wall time [s]; ``status`` the
    exit status: 0 holds, 1 a verdict failed, 3 an engine died, or a case that was asked for by
    name tested nothing (``untested_cases``). ``engine`` is null when none could
    be run, ``engines`` when none were compared. ``baseline`` is where the accepted values lie,
    empty without them, ``baseline_sha256`` their digest; ``scripts`` maps the name of each script
    that ran to its SHA-256. ``strict`` says that what is not tested counts as a failure.
    """

    level: str
    started: str
    seconds: Number
    platform: str
    harness_version: str
    status: int
    engine: Provenance | None
    checks: tuple[Check, ...]
    schema: int = SCHEMA
    cases: tuple[str, ...] = ()
    strict: bool = False
    engine_errors: tuple[str, ...] = ()
    untested_cases: tuple[str, ...] = ()
    baseline: str = ""
    baseline_sha256: str = ""
    headlines: tuple[Headline, ...] = ()
    divergences: tuple[DivergenceRow, ...] = ()
    engines: Engines | None = None
    scripts: Mapping[str, str] = field(default_factory=dict)


def read_published(record: Any) -> Results:
    """Return a run from its JSON value; keys that are not known are passed over.

    One of schema 1 has its extrapolated angle told as a headline. Raise
    pydantic.ValidationError for what is no run.
    """
    if isinstance(record, dict) and record.get("schema", 1) == 1:
        record = {
            **record,
            "schema": 1,
            "headlines": _headlines_of_schema_1(record),
            "engines": None,
        }
    found: Results = adapter(Results).validate_python(record)
    return found


def _headlines_of_schema_1(record: Mapping[str, Any]) -> list[dict[str, Any]]:
    found, engine = record.get("extrapolated"), record.get("engine") or {}
    if not isinstance(found, dict) or not isinstance(engine, dict):
        return []
    return [
        {
            "name": "critical angle",
            "unit": "deg",
            "expected": record.get("closed_form_deg"),
            "value": found.get("critical_angle_deg"),
            "uncertainty": found.get("uncertainty_deg"),
            "who": engine.get("engine", ""),
        }
    ]


def json_schema() -> dict[str, Any]:
    """Return the JSON Schema of the keys that every run has."""
    return adapter(Results).json_schema(mode="serialization")
