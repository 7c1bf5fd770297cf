"""``dem-harness cases``."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from harness.cli.command import Json
from harness.cli.files import print_columns, print_json, print_wrapped


def cases(name: str | None = None, /, *, json: Json = False) -> int:
    """List the cases: what each simulates, its quantities, and the engines that state it.

    Of one case: its parameters with unit, default and what is allowed, presets with their source,
    quantities with their meaning, and why an engine cannot run it.

    For example:

        dem-harness cases
        dem-harness cases oblique
        dem-harness cases --json

    Parameters
    ----------
    name
        A case that is shown in full.
    """
    from harness.cases.registry import faults
    from harness.store.entries import tell_stderr
    from harness.workflows import case_details
    from harness.workflows import cases as ask

    for fault in faults():
        tell_stderr(fault)
    records = [case.to_json() for case in (ask() if name is None else [case_details(name)])]
    if json:
        print_json({"cases": records})
        return 0
    for case in records:
        print_wrapped(f"{case['name']} ({case['group']}): {case['summary']}")
        if case["verify_seconds"]:
            cost = ", ".join(f"{s:.0f} s {level}" for level, s in case["verify_seconds"].items())
            print_wrapped(f"verify: {cost}, of CPU time", indent=4)
        if name is not None:
            _print_details(case)
            continue
        every = {**case["quantities"], **case["derived"]}
        quantities = (f"{name} ({unit or '-'})" for name, unit in every.items())
        print_wrapped(f"quantities: {', '.join(quantities)}", indent=4)
        print_wrapped(f"parameters: {', '.join(case['parameters'])}", indent=4)
        print_wrapped(f"engines: {', '.join(case['engines']) or 'none'}", indent=4)
    return 0


def _print_details(case: Mapping[str, Any]) -> None:
    tables: dict[str, list[tuple[str, ...]]] = {
        "parameters, by --set NAME=VALUE": [("name", "default", "unit", "allowed", "meaning")],
        "presets, by --set preset=NAME": [("name", "source", "values")],
        "quantities": [("name", "unit", "meaning")],
        "quantities of several runs, by --quantity NAME": [("name", "unit", "meaning")],
        "their own parameters": [("name", "default", "unit", "allowed", "meaning")],
        "engines": [("name", "", "")],
    }
    parameters, presets, quantities, derived, derived_parameters, engines = tables.values()
    for table, key in ((parameters, "parameters"), (derived_parameters, "derived_parameters")):
        for name, entry in case[key].items():
            default = "-" if entry["default"] is None else _short(entry["default"])
            table.append((name, default, entry["unit"], entry["allowed"], entry["description"]))
    for name, entry in case["preset_details"].items():
        values = ", ".join(f"{key}={_short(value)}" for key, value in entry["values"].items())
        presets.append((name, entry["source"] or "this package", values or "the defaults"))
    quantities += [(n, unit, case["meanings"][n]) for n, unit in case["quantities"].items()]
    derived += [(n, unit, case["meanings"][n]) for n, unit in case["derived"].items()]
    engines += _engines(case)
    for title, lines in tables.items():
        if len(lines) > 1:
            print(f"\n{title}")
            print_columns(lines)


def _engines(case: Mapping[str, Any]) -> Iterator[tuple[str, str, str]]:
    for name in case["engines"]:
        reason = case["refused_by"].get(name, "")
        yield name, "not by default" if reason else "runs it", reason
    for name in case["solvers"]:
        yield name, "runs it", "a solver of this package"
    for name, reason in case["refused_by"].items():
        if name not in case["engines"]:
            yield name, "cannot", reason


def _short(value: Any) -> str:
    return "none" if value is None else f"{value:.8g}" if isinstance(value, float) else str(value)
