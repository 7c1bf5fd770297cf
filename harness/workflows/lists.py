"""Lists: the cases, the engines that are here, and the scripts of LAMMPS that are committed."""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from harness.cases.base import Case
from harness.cases.registry import DEFAULT as DEFAULT_CASES
from harness.cases.registry import get_case, homes, usable_cases
from harness.engines.base import Template, Traits
from harness.engines.provenance import Provenance
from harness.engines.registry import DEFAULT, ENGINES, engine_class, engine_names, open_engine
from harness.errors import EngineError, RequestError
from harness.files import check_folder, text_writer, write_files
from harness.model.base import Parameters
from harness.workflows.progress import Progress, silent
from harness.workflows.runs import takes_job
from harness.workflows.settings import parameter_infos

if TYPE_CHECKING:
    import pandas as pd

T = TypeVar("T")
UNKNOWN = Traits("", (), "")  # of an engine whose class cannot be imported


class Listing(list[T]):
    """Records that a notebook shows as a table."""

    def to_frame(self) -> pd.DataFrame:
        """Return a row for each record, its JSON keys as columns."""
        import pandas as pd

        return pd.DataFrame([record.to_json() for record in self])  # type: ignore[attr-defined]

    def _repr_html_(self) -> str:
        return str(self.to_frame().to_html(index=False, na_rep=""))


@dataclass(frozen=True)
class CaseInfo:
    """A case as it is listed, or ``in_full``."""

    case: Case[Any]
    in_full: bool = False

    def to_json(self) -> dict[str, Any]:
        """Return the case as a JSON-ready mapping.

        ``parameters`` by name, of nested ones with a dot; ``quantities`` and, of several runs,
        ``derived`` map names to units; ``engines`` have a script for the case, or take its scene;
        ``solvers`` are of this package. In full with meanings, presets and refusals.
        """
        case, parameters = self.case, _records(self.case.default)
        for info in parameters.values() if not self.in_full else ():
            del info["allowed"]
        record = {
            "name": case.name,
            "group": case.group,
            "summary": case.summary,
            "parameters": parameters,
            "quantities": {q.name: q.unit for q in case.quantities if not q.varies},
            "engines": tuple(name for name in engine_names() if _takes(name, case)),
            "solvers": tuple(case.solvers),
            "presets": tuple(case.presets),
            "by_default": case.name in DEFAULT_CASES,
            "derived": {q.name: q.unit for q in case.quantities if q.varies},
        }
        return record | (self._details() if self.in_full else {})

    def _details(self) -> dict[str, Any]:
        case, default = self.case, parameter_infos(self.case.default)
        presets = {}
        for name, preset in case.presets.items():
            found = {n: i.default for n, i in parameter_infos(preset).items() if n in default}
            values = {n: value for n, value in found.items() if value != default[n].default}
            presets[name] = {"source": case.sources.get(name, ""), "values": values}
        refusals = {name: _refusal(name, case) for name in engine_names()}
        return {
            "meanings": {quantity.name: quantity.meaning for quantity in case.quantities},
            "preset_details": presets,
            "derived_parameters": _records(case.search_options()),
            "refused_by": {name: reason for name, reason in refusals.items() if reason},
        }


@dataclass(frozen=True)
class EngineStatus:
    """An engine: who it is, or why it is missing; and how to get it."""

    engine: str
    provenance: Provenance | None
    how: str = ""
    reason: str = ""
    traits: Traits = UNKNOWN

    @property
    def available(self) -> bool:
        """Return whether the engine was found."""
        return self.provenance is not None

    def to_json(self) -> dict[str, Any]:
        """Return the status as a JSON-ready mapping."""
        found = self.provenance or Provenance("", "")
        return {
            "engine": self.engine,
            "how": self.how,
            "available": self.available,
            "engine_version": found.engine_version,
            "executable": found.executable,
            "packages": list(found.packages),
            "reason": self.reason,
            "install_hint": self.traits.install_hint,
            "lineage": self.traits.lineage,
            "integrator": self.traits.integrator,
            "digits": self.traits.digits,
        }


def cases(name: str | None = None) -> Listing[CaseInfo]:
    """Return every case that can be used, those of this package first; or one, in full.

    Raise RequestError for an unknown name.
    """
    if name is None:
        return Listing(map(CaseInfo, usable_cases().values()))
    return Listing([CaseInfo(get_case(name), in_full=True)])


def engines(
    *,
    programs: Mapping[str, str] | None = None,
    lmp: str | None = None,
    launcher: str | None = None,
    progress: Progress = silent,
) -> Listing[EngineStatus]:
    """Return the status of every engine, and of its other way to run where it has one.

    ``programs`` are executables by engine; ``lmp`` and ``launcher`` are those of LAMMPS.
    """
    statuses: Listing[EngineStatus] = Listing()
    names = engine_names()
    for done, name in enumerate(names):
        progress("engines", done, len(names))
        options = {"program": programs[name]} if programs and name in programs else {}
        try:
            twin = engine_class(name).twin_options(**options)
        except RequestError as error:
            statuses.append(EngineStatus(name, None, reason=str(error)))
            continue
        statuses.append(_status(name, options))
        if twin is not None:
            mine = {"lmp": lmp, "launcher": launcher} if name == DEFAULT else {}
            given = {key: value for key, value in mine.items() if value is not None}
            statuses.append(_status(name, {**twin, **given}))
    progress("engines", len(names), len(names))
    return statuses


def inputs(folder: Path, engine: str | None = None) -> list[Path]:
    """Write the scripts of LAMMPS, or of a named engine, into a folder; return the files.

    Those of a named engine make a new folder. Raise RequestError for an engine without scripts and
    for a folder that cannot be written.
    """
    texts = input_texts(engine or DEFAULT)
    if engine is not None:
        check_folder(folder)
    write_files({("--output", folder / name): text_writer(text) for name, text in texts.items()})
    return [folder / name for name in texts]


def outdated_inputs(folder: Path) -> dict[str, str]:
    """Return the difference of each script in a folder that is missing or not up to date."""
    if not folder.is_dir():
        raise RequestError(f"--output {folder}: no such folder; name the one with the scripts")
    found = {}
    for name, text in input_texts().items():
        file = folder / name
        old = file.read_text(encoding="utf-8", errors="replace") if file.is_file() else ""
        if not file.is_file():
            found[name] = "is missing"
        elif old != text:
            lines = (old.splitlines(), text.splitlines())
            diff = difflib.unified_diff(*lines, "committed", "generated", lineterm="", n=0)
            found[name] = "\n".join(diff) or "differs in its line ends"
    return found


def input_texts(engine: str = DEFAULT) -> dict[str, str]:
    """Return an engine's scripts of the cases of this package by name; it need not be here.

    Raise RequestError for an unknown engine, and for one that runs without scripts.
    """
    templates = list(_templates())
    if texts := engine_class(engine).inputs(templates):
        return texts
    names = [name for name in ENGINES if engine_class(name).inputs(templates)]
    raise RequestError(
        f"--engine {engine!r}: runs without scripts: must be one of {', '.join(names)}"
    )


def _templates() -> Iterable[Template]:
    for name in homes():
        case = get_case(name)
        template = case.job(case.default).template
        if template.name != "contact-scene":
            yield template


def _records(parameters: Parameters) -> dict[str, dict[str, Any]]:
    return {name: dict(vars(info)) for name, info in parameter_infos(parameters).items()}


def _takes(engine: str, case: Case[Any]) -> bool:
    try:
        return takes_job(engine_class(engine), case)
    except RequestError:  # of another package, which does not import
        return False


def _refusal(engine: str, case: Case[Any]) -> str:
    """Return why an engine cannot run a case with its default parameters."""
    try:
        if not takes_job(engine_class(engine), case):
            return "it has no script for the case, and the case has no scene that it takes"
        with open_engine(engine) as opened:
            return opened.refuses(case.job(case.default))
    except (EngineError, RequestError) as error:
        return str(error)


def _status(name: str, options: Mapping[str, Any]) -> EngineStatus:
    traits = engine_class(name).traits
    how = str(options.get("launcher") or ("executable" if options else "-"))
    try:
        with open_engine(name, options=options) as engine:
            found = engine.identify()
    except (EngineError, RequestError) as error:
        return EngineStatus(name, None, how, traits.missing(str(error)), traits)
    return EngineStatus(name, found, found.how or how, "", traits)
