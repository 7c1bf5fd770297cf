"""Engines as a command sees them: selected by name, opened, their state, their generated inputs."""

from __future__ import annotations

import difflib
import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

from harness.cases.contract import Case
from harness.cases.registry import built_in, get_case
from harness.comparison.verdicts import Check, Kind, finding, not_tested
from harness.comparison.verification import DeclaredEngine
from harness.engines.registry import (
    ALWAYS,
    DEFAULT,
    ENGINES,
    engine_class,
    engine_names,
    open_engine,
)
from harness.engines.traits import ContactModel, Traits
from harness.errors import EngineError, RequestError, cannot_write
from harness.files import check_folder, held_folder, whole_folder
from harness.observables.provenance import Provenance
from harness.shown import Listing, Record
from harness.workflows.progress import Progress, silent

ALL = "all"


@dataclass(frozen=True)
class EngineSelection:
    """The engines to compare, in order, and those of them that were asked for by name.

    Only one that was named must be here; of ``all`` an engine may be missing.
    """

    engines: tuple[str, ...] = ()
    named: frozenset[str] = frozenset()


def selected_engines(wanted: str | Iterable[str]) -> EngineSelection:
    """Return the engines of ``all``, ``one`` or ``one,two``; none for no texts.

    Those that every comparison shows are always among them. Raise RequestError for a
    name that is not known, and for texts without a name.
    """
    texts = [wanted] if isinstance(wanted, str) else list(wanted)
    names = [name.strip() for text in texts for name in text.split(",") if name.strip()]
    available = engine_names()
    for name in names:
        if ":" in name:
            engine_class(name)  # module:Class, which raises where there is none
        elif name not in (ALL, *available):
            raise RequestError(
                f"--engines {name!r} is not known: must be {ALL}, or one or more of "
                f"{', '.join(available)}"
            )
    if not names:
        if texts:
            raise RequestError(f"--engines {','.join(texts)!r}: names no engine")
        return EngineSelection()
    everything = ALL in names
    chosen = [name for name in available if everything or name in names or name in ALWAYS]
    others = [name for name in dict.fromkeys(names) if name not in (ALL, *available)]
    return EngineSelection((*chosen, *others), frozenset(names) - {ALL})


NO_TRAITS = Traits("", (), "", ContactModel("", {"tail": (), "effective_mass": ()}))
"""Of an engine whose class cannot be imported."""


def declared(
    name: str, traits: Traits, provenance: Provenance | None = None, *, missing: str = ""
) -> DeclaredEngine:
    """Return what an engine declares, copied for the report, and who it is here."""
    return DeclaredEngine(
        engine=name,
        version=provenance.engine_version if provenance else "",
        how=provenance.how if provenance else "",
        install_hint=traits.install_hint,
        versions=traits.versions,
        integrator=traits.integrator,
        tails=tuple(map(str, traits.frictionless.states["tail"])),
        effective_masses=tuple(map(str, traits.frictionless.states["effective_mass"])),
        digits=traits.digits,
        lineage=traits.lineage,
        caveats=traits.caveats,
        missing=missing,
    )


def untested(engine: str, cases: Iterable[Case[Any]], reason: str) -> list[Check]:
    """Return a row for each case that could not be run in an engine."""
    return [not_tested(f"{engine}: {case.name}", Kind.CROSS_CODE, reason) for case in cases]


def version_rows(name: str, traits: Traits, provenance: Provenance) -> list[Check]:
    """Return a finding where an engine's version is not one that it was tried with."""
    if provenance.engine_version in traits.versions:
        return []
    tried = ", ".join(traits.versions) or "none"
    note = f"version {provenance.engine_version}: not one that it was tried with ({tried})"
    return [finding(f"{name}: version", math.nan, math.nan, "", note)]


NOT_RUN = "-"
"""How an engine is run that is not here."""


@dataclass(frozen=True)
class EngineStatus(Record):
    """One way to run an engine: who it is, or why it is missing; and what it declares."""

    engine: str
    how: str
    provenance: Provenance | None
    traits: Traits
    reason: str = ""

    JSON: ClassVar = {
        "engine": "engine",
        "how": "how",
        "available": "available",
        "engine_version": "provenance.engine_version",
        "executable": "provenance.executable",
        "packages": "packages",
        "reason": "reason",
        "install_hint": "traits.install_hint",
        "lineage": "traits.lineage",
        "tails": "tails",
        "effective_masses": "effective_masses",
        "integrator": "traits.integrator",
        "digits": "traits.digits",
    }

    @property
    def available(self) -> bool:
        """Return whether the engine was found."""
        return self.provenance is not None

    @property
    def tails(self) -> tuple[str | int | float, ...]:
        """Return the rules for the tail that it states."""
        return self.traits.frictionless.states["tail"]

    @property
    def effective_masses(self) -> tuple[str | int | float, ...]:
        """Return the effective masses against a fixed sphere that it states."""
        return self.traits.frictionless.states["effective_mass"]

    @property
    def packages(self) -> tuple[str, ...]:
        """Return its packages, none of one that is missing."""
        return self.provenance.packages if self.provenance else ()


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
    statuses: Listing[EngineStatus] = Listing()
    names = engine_names()
    extra = {key: value for key, value in options.items() if value is not None}
    for done, name in enumerate(names):
        progress("engines", done, len(names))
        program = {"program": programs[name]} if programs and name in programs else {}
        try:
            twin = engine_class(name).twin_options(**program)
        except RequestError as error:
            statuses.append(EngineStatus(name, NOT_RUN, None, NO_TRAITS, str(error)))
            continue
        statuses.append(_status(name, NOT_RUN, program))
        if twin is not None:
            chosen = {**twin, **extra} if name == DEFAULT else dict(twin)
            statuses.append(_status(name, options.get("launcher") or "executable", chosen))
    progress("engines", len(names), len(names))
    return statuses


def _status(name: str, how: str, options: Mapping[str, Any]) -> EngineStatus:
    traits = engine_class(name).traits
    try:
        with open_engine(name, options=options) as engine:
            provenance = engine.identify()
    except (EngineError, RequestError) as error:
        return EngineStatus(name, how, None, traits, traits.missing(str(error)))
    return EngineStatus(name, provenance.how or how, provenance, traits)


def generated_inputs(engine: str = DEFAULT) -> dict[str, str]:
    """Return an engine's scripts of the cases of this package, by their names; it need not be here.

    Raise RequestError for an unknown engine, and for one that runs without scripts.
    """
    templates = [get_case(name).template for name in built_in()]
    texts = engine_class(engine).inputs(templates)
    if not texts:
        names = (name for name in ENGINES if engine_class(name).inputs(templates))
        raise RequestError(
            f"--engine {engine!r} runs without scripts: must be one of {', '.join(names)}"
        )
    return texts


def inputs(folder: Path, engine: str | None = None) -> list[Path]:
    """Write the scripts of LAMMPS, or of the named engine, into a folder; return the files.

    Those of LAMMPS are each written aside and renamed, in a folder that may hold others. Those of
    a named engine make a new folder, all of them or none. Raise RequestError for what
    :func:`generated_inputs` refuses, for a new folder that holds something, and for one that
    cannot be written, FullDiskError where there is no space.
    """
    if engine is not None:
        return _new_inputs(folder, generated_inputs(engine))
    written = []
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with held_folder(folder) as aside:
            for name, text in generated_inputs().items():
                (aside / "input").write_text(text, encoding="utf-8")
                written.append((aside / "input").replace(folder / name))
    except OSError as error:
        raise cannot_write(f"folder {folder} cannot be written", error) from None
    return written


def _new_inputs(folder: Path, texts: Mapping[str, str]) -> list[Path]:
    check_folder(folder)
    try:
        with whole_folder(folder) as aside:
            for name, text in texts.items():
                (aside / name).parent.mkdir(parents=True, exist_ok=True)
                (aside / name).write_text(text, encoding="utf-8")
    except OSError as error:
        raise cannot_write(f"--output {folder} cannot be written", error) from None
    return [folder / name for name in texts]


def outdated_inputs(folder: Path) -> dict[str, str]:
    """Return, for each input that is missing or differs in a folder, what differs.

    Raise RequestError when there is no such folder.
    """
    if not folder.is_dir():
        raise RequestError(f"folder {folder}: no such folder; give the one that holds the inputs")
    differences: dict[str, str] = {}
    for name, generated in generated_inputs().items():
        path = folder / name
        if not path.is_file():
            differences[name] = "is missing"
            continue
        text = path.read_text(encoding="utf-8", errors="replace")
        if text != generated:
            lines = difflib.unified_diff(
                text.splitlines(),
                generated.splitlines(),
                "committed",
                "generated",
                lineterm="",
                n=0,
            )
            differences[name] = "\n".join(lines) or "differs in its line ends"
    return differences
