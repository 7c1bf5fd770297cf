"""``dem-harness cases``, ``engines`` and ``inputs``."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter

from harness.cli.app import Folder, Json, Name
from harness.cli.engines import ProgramOptions
from harness.cli.output import print_columns, print_json, print_wrapped, short, tell


def cases(name: str | None = None, /, *, json: Json = False) -> int:
    """List the cases: what each simulates, its quantities, and the engines that run it.

    Of one case: its parameters with unit, default and what is allowed, presets with their source,
    quantities with their meaning, and why an engine cannot run it.

    For example:

        dem-harness cases oblique

    Parameters
    ----------
    name
        A case that is shown in full.
    """
    from harness.cases.registry import plugin_faults
    from harness.workflows import cases as list_cases

    for fault in plugin_faults():
        tell(fault)
    records = [case.to_json() for case in list_cases(name)]
    if json:
        print_json({"cases": records})
        return 0
    for case in records:
        print_wrapped(f"{case['name']} ({case['group']}): {case['summary']}")
        if name is not None:
            _print_details(case)
            continue
        units = {**case["quantities"], **case["derived"]}
        quantities = ", ".join(f"{n} ({unit or '-'})" for n, unit in units.items())
        for title, text in (
            ("quantities", quantities),
            ("parameters", ", ".join(case["parameters"])),
            ("engines", ", ".join(case["engines"]) or "none"),
        ):
            print_wrapped(f"{title}: {text}", indent=4)
    return 0


def engines(
    programs: ProgramOptions = ProgramOptions(),
    *,
    json: Json = False,
) -> int:
    """List the engines: version, how they are run, and why one is missing.

    For example:

        dem-harness engines --program yade=/opt/yade/bin/yade
    """
    from harness.engines.registry import engine_names, named_values, refused_plugins
    from harness.workflows import engines as list_engines
    from harness.workflows.progress import progress_bars

    programs.check(engine_names(), "--engine")
    with progress_bars("engines", quiet=json) as progress:
        statuses = list_engines(
            programs=named_values(programs.program or (), "--program"),
            lmp=programs.lmp,
            launcher=programs.mpirun,
            progress=progress,
        )
    for fault in refused_plugins():
        tell(fault)
    if json:
        print_json({"engines": [status.to_json() for status in statuses]})
        return 0
    lines = []
    for status in statuses:
        found = status.provenance
        version, where = ("missing", status.reason) if found is None else (
            found.engine_version, found.executable)  # fmt: skip
        lines.append((status.engine, status.how, version, where))
    print_columns(lines)
    return 0


def inputs(
    *,
    check: bool = False,
    engine: Name = None,
    output: Annotated[Folder, Parameter(alias="--folder")] = None,
    json: Json = False,
) -> int:
    """Write the scripts of LAMMPS, or check that the committed ones are up to date.

    For example:

        dem-harness inputs --check

        dem-harness inputs --engine yade --output mine

    Parameters
    ----------
    check
        Write nothing; exit status 1 where a script differs or is missing.
    engine
        Write the scripts of this engine, into a new folder.
    output
        The folder of the scripts. [default: inputs]
    """
    from harness.errors import RequestError
    from harness.workflows import inputs as write_inputs
    from harness.workflows import outdated_inputs

    folder = output or Path("inputs")
    if check:
        if engine is not None:
            raise RequestError(f"--engine {engine}: goes without --check, which is of LAMMPS")
        outdated = outdated_inputs(folder)
        if json:
            print_json({"folder": str(folder), "outdated": outdated})
        for name, difference in {} if json else outdated.items():
            print(f"{folder / name}: {difference}")
        return 1 if outdated else 0
    if engine is not None and output is None:
        raise RequestError(f"--engine {engine}: needs --output, a new folder")
    written = [str(path) for path in write_inputs(folder, engine)]
    if json:
        print_json({"folder": str(folder), "written": written})
    else:
        print("\n".join(written))
    return 0


def _print_details(case: Mapping[str, Any]) -> None:
    heading = ("name", "default", "unit", "allowed", "meaning")
    presets = [("name", "source", "values")]
    for name, entry in case["preset_details"].items():
        values = ", ".join(f"{key}={short(value)}" for key, value in entry["values"].items())
        presets.append((name, entry["source"] or "this package", values or "the defaults"))
    meanings, units = case["meanings"], ("name", "unit", "meaning")
    tables: dict[str, Sequence[Sequence[str]]] = {
        "parameters, by --set NAME=VALUE": [heading, *_parameters(case["parameters"])],
        "presets, by --set preset=NAME": presets,
        "quantities": [units, *((n, u, meanings[n]) for n, u in case["quantities"].items())],
        "quantities of several runs, by --quantity NAME": [
            units, *((n, u, meanings[n]) for n, u in case["derived"].items())],
        "their own parameters": [heading, *_parameters(case["derived_parameters"])],
        "engines": [("name", "", ""), *_engines(case)],
    }  # fmt: skip
    for title, lines in tables.items():
        if len(lines) > 1:
            print(f"\n{title}")
            print_columns(lines)


def _parameters(parameters: Mapping[str, Any]) -> list[tuple[str, ...]]:
    return [
        (name, "-" if e["default"] is None else short(e["default"]), e["unit"], e["allowed"],
         e["description"])
        for name, e in parameters.items()
    ]  # fmt: skip


def _engines(case: Mapping[str, Any]) -> list[tuple[str, str, str]]:
    refused = case["refused_by"]
    lines = [(name, "not by default" if name in refused else "runs it", refused.get(name, ""))
             for name in case["engines"]]  # fmt: skip
    lines += [(name, "runs it", "a solver of this package") for name in case["solvers"]]
    others = [name for name in refused if name not in case["engines"]]
    return lines + [(name, "cannot", refused[name]) for name in others]
