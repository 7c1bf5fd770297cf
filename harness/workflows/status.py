"""Which engines are here, in which version, how they are run, and why one is missing."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from harness.engines.registry import DEFAULT, engine_class, engine_names, open_engine
from harness.engines.traits import Traits
from harness.errors import EngineError, RequestError
from harness.observables.provenance import Provenance
from harness.shown import Listing
from harness.workflows.engine_rows import NO_TRAITS
from harness.workflows.progress import Progress, silent

NOT_RUN = "-"
"""How an engine is run that is not here."""


@dataclass(frozen=True)
class EngineStatus:
    """One way to run an engine: who it is, or why it is missing; and what it declares."""

    engine: str
    how: str
    provenance: Provenance | None
    traits: Traits
    reason: str = ""

    def record(self) -> dict[str, Any]:
        """Return the status as a JSON-ready mapping."""
        found, declares = self.provenance, self.traits
        return {
            "engine": self.engine,
            "how": self.how,
            "available": found is not None,
            "engine_version": found.engine_version if found else None,
            "executable": found.executable if found else None,
            "packages": list(found.packages) if found else [],
            "reason": self.reason,
            "install_hint": declares.install_hint,
            "lineage": declares.lineage,
            "tails": list(declares.tails),
            "effective_masses": list(declares.effective_masses),
            "spring": declares.spring,
            "integrator": declares.integrator,
            "digits": declares.digits,
        }


def engines(
    *,
    programs: Mapping[str, str] | None = None,
    progress: Progress = silent,
    **options: str | None,
) -> Listing[EngineStatus]:
    """Return the status of every engine, and of its other way to run where it has one.

    ``programs`` are executables by the engine's name; ``options`` are those of the default
    engine's other way (``lmp``, ``launcher``). An engine of another package that cannot be
    imported is one line that says so.
    """
    found: Listing[EngineStatus] = Listing()
    names = engine_names()
    given = {key: value for key, value in options.items() if value is not None}
    for done, name in enumerate(names):
        progress("engines", done, len(names))
        program = {"program": programs[name]} if programs and name in programs else {}
        try:
            twin = engine_class(name).twin_options(**program)
        except RequestError as error:
            found.append(EngineStatus(name, NOT_RUN, None, NO_TRAITS, str(error)))
            continue
        found.append(_status(name, NOT_RUN, program))
        if twin is not None:
            chosen = {**twin, **given} if name == DEFAULT else dict(twin)
            found.append(_status(name, options.get("launcher") or "executable", chosen))
    progress("engines", len(names), len(names))
    return found


def _status(name: str, how: str, options: Mapping[str, Any]) -> EngineStatus:
    traits = engine_class(name).traits
    try:
        with open_engine(name, options=options) as engine:
            who = engine.identify()
    except (EngineError, RequestError) as error:
        return EngineStatus(name, how, None, traits, traits.missing(str(error)))
    return EngineStatus(name, who.how or how, who, traits)
