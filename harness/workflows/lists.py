"""Lists: the cases, the engines, and the committed scripts of LAMMPS."""

from __future__ import annotations

import difflib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from harness.cases.base import Case
from harness.cases.registry import DEFAULT as DEFAULT_CASES
from harness.cases.registry import get_case, homes, usable_cases
from harness.engines.base import SCENE_NAME, Traits
from harness.engines.output import Provenance
from harness.engines.registry import DEFAULT, ENGINES, engine_class, engine_names, open_engine
from harness.errors import EngineError, EngineMissingError, RequestError
from harness.files import check_folder, text_writer, write_files
from harness.model.base import Parameters, allowed_in, unit
from harness.workflows import Progress, silent
from harness.workflows.runs import takes_job
from harness.workflows.settings import leaves

Record = dict[str, Any]
UNKNOWN = Traits("", (), "")  # of an engine whose class cannot be imported


def cases(name: str | None = None) -> list[Record]:
    """Return every case that can be used, those of this package first; or one, in full.

    ``parameters`` are by name, of nested ones with a dot; ``quantities`` and, of several runs,
    ``derived`` map names to units; ``engines`` have a script for the case, or take its scene;
    ``solvers`` are of this package. In full with meanings, presets and refusals. Raise RequestError
    for an unknown name.
    """
    if name is None:
        return [_case(case) for case in usable_cases().values()]
    case = get_case(name)
    return [{**_case(case), **_details(case)}]


def engines(
    *,
    programs: Mapping[str, str] | None = None,
    lmp: str | None = None,
    launcher: str | None = None,
    progress: Progress = silent,
) -> list[Record]:
    """Return the status of every engine.

    ``programs`` are executables by engine; ``lmp`` and ``launcher`` are those of LAMMPS.
    """
    records, names = list[Record](), engine_names()
    for done, name in enumerate(names):
        progress("engines", done, len(names))
        options = {"program": programs[name]} if programs and name in programs else {}
        more = {"lmp": lmp, "launcher": launcher} if name == DEFAULT else {}
        options |= {key: value for key, value in more.items() if value is not None}
        records.append(_engine(name, options))
    progress("engines", len(names), len(names))
    return records


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
    differences = {}
    for name, text in input_texts().items():
        file = folder / name
        if not file.is_file():
            differences[name] = "is missing"
        elif (old := file.read_bytes().decode(errors="replace")) != text:
            lines = (old.splitlines(), text.splitlines())
            diff = difflib.unified_diff(*lines, "committed", "generated", lineterm="", n=0)
            differences[name] = "\n".join(diff) or "differs in its line ends"
    return differences


def input_texts(engine: str = DEFAULT) -> dict[str, str]:
    """Return an engine's scripts of the cases of this package by name; it need not be installed.

    Raise RequestError for an unknown engine, and for one that runs without scripts.
    """
    jobs = [case.job(case.default) for case in map(get_case, homes())]
    templates = [job.template for job in jobs if job.template.name != SCENE_NAME]
    if texts := engine_class(engine).inputs(templates):
        return texts
    names = [name for name in ENGINES if engine_class(name).inputs(templates)]
    raise RequestError(
        f"--engine {engine!r}: runs without scripts: must be one of {', '.join(names)}"
    )


def parameter_records(values: Parameters, path: str = "") -> dict[str, Record]:
    """Return default, unit, description and what is allowed of all parameters, by name.

    The name of a nested parameter has a dot; the values are the defaults.
    """
    kind, records = type(values), dict[str, Record]()
    allowed = allowed_in(kind)
    for name, field in kind.model_fields.items():
        value, limits = getattr(values, name), allowed.get(name)
        if isinstance(value, Parameters):
            records |= parameter_records(value, f"{path}{name}.")
            continue
        records[path + name] = {
            "default": value,
            "unit": unit(kind, name),
            "description": (field.description or "").partition("]")[2].strip(),
            "allowed": (", ".join(limits.words) or limits.range) if limits else "",
        }
    return records


def _case(case: Case[Any]) -> Record:
    return {
        "name": case.name,
        "group": case.group,
        "summary": case.summary,
        "parameters": parameter_records(case.default),
        "quantities": {q.name: q.unit for q in case.quantities if not q.varies},
        "engines": [name for name in engine_names() if _takes(name, case)],
        "solvers": list(case.solvers),
        "presets": list(case.presets),
        "by_default": case.name in DEFAULT_CASES,
        "derived": {q.name: q.unit for q in case.quantities if q.varies},
    }


def _details(case: Case[Any]) -> Record:
    defaults = dict(leaves(case.default))
    changes = {
        name: {n: v for n, v in leaves(preset) if n in defaults and v != defaults[n]}
        for name, preset in case.presets.items()
    }
    refusals = {name: _refusal(name, case) for name in engine_names()}
    return {
        "meanings": {quantity.name: quantity.meaning for quantity in case.quantities},
        "preset_details": {
            name: {"source": case.sources.get(name, ""), "values": values}
            for name, values in changes.items()
        },
        "derived_parameters": parameter_records(case.search_options()),
        "refused_by": {name: reason for name, reason in refusals.items() if reason},
    }


def _takes(engine: str, case: Case[Any]) -> bool:
    try:
        return takes_job(engine_class(engine), case)
    except EngineMissingError:  # of another package, which is broken
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


def _engine(name: str, options: Mapping[str, Any]) -> Record:
    traits, provenance, reason = UNKNOWN, Provenance("", ""), ""
    how = str(options.get("launcher") or ("executable" if options else "-"))
    try:
        traits = engine_class(name).traits
        with open_engine(name, options=options) as engine:
            provenance = engine.identify()
    except (EngineError, RequestError) as error:
        reason = str(error) if traits is UNKNOWN else traits.missing(str(error))
    return {
        "engine": name,
        "how": provenance.how or how,
        "available": not reason,
        "engine_version": provenance.engine_version,
        "executable": provenance.executable,
        "packages": list(provenance.packages),
        "reason": reason,
        "install_hint": traits.install_hint,
        "lineage": traits.lineage,
        "integrator": traits.integrator,
        "digits": traits.digits,
    }
