"""``dem-harness run``."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any

import typer

from harness.cli.engine_options import EngineOptions
from harness.cli.options import Json


def run(
    case: Annotated[
        str, typer.Argument(metavar="CASE", help="A case that `dem-harness cases` lists.")
    ],
    engine: EngineOptions,
    settings: Annotated[
        list[str] | None,
        typer.Option(
            "--set",
            metavar="NAME=VALUE",
            help="A parameter of the case, in SI units and degrees; repeat it for several.",
        ),
    ] = None,
    json: Json = False,
) -> None:
    """One run of any case: its parameters, what it measures, and what is expected."""
    from harness.cli.engine_options import named_values, runs_made, value_of
    from harness.cli.history_records import run_quantities
    from harness.cli.output import print_json
    from harness.cli.recording import recorded
    from harness.workflows.run import run as run_case

    values = {name: value_of(text) for name, text in named_values(settings or (), "--set").items()}
    with recorded("run") as told, engine.run() as opened:
        found = run_case(case, values, engine=opened)
        record = {**found.record(), **runs_made(opened)}
        told.engine, told.quantities = record, run_quantities(record, values)
    if json:
        print_json(record)
    else:
        _print(record)


def _print(record: Mapping[str, Any]) -> None:
    """Print who ran, the parameters, and a line for each quantity."""
    from harness.cli.output import print_wrapped

    print(f"{record['case']} in {record['engine']} {record['engine_version']}")
    given = (f"{name} = {_short(value)}" for name, value in record["parameters"].items())
    print_wrapped(", ".join(given), indent=2)
    width = max((len(name) for name in record["quantities"]), default=0)
    for name, quantity in record["quantities"].items():
        line = f"{name:<{width}}  {_short(quantity['value'])} {quantity['unit']}".rstrip()
        if quantity["reference_kind"] != "none":
            line += (
                f", {_short(quantity['reference'])} by {quantity['reference_kind']}, "
                f"difference {quantity['difference']:.2g}"
            )
        print_wrapped(line)


def _short(value: Any) -> str:
    return f"{value:.8g}" if isinstance(value, float) else str(value)
