"""``dem-harness run``."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any

import typer

from harness.cli.engine_options import Integrator, ProgramOptions
from harness.cli.options import Json

if TYPE_CHECKING:
    from harness.engines.contract import Engine


@dataclass(frozen=True)
class RunnerOptions(ProgramOptions):
    """Who runs the case."""

    engine: Annotated[
        str | None,
        typer.Option(
            "--engine",
            metavar="NAME",
            help="An engine that `dem-harness engines` lists, `module:Class` of one of your own, "
            "or a solver that `dem-harness cases` names.  [default: lammps, or a solver where "
            "it cannot]",
            rich_help_panel="Engine",
        ),
    ] = None
    integrator: Integrator = None


def run(
    case: Annotated[
        str, typer.Argument(metavar="CASE", help="A case that `dem-harness cases` lists.")
    ],
    runner: RunnerOptions,
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
    from harness.cli.engine_options import runs_made
    from harness.cli.history_records import run_quantities
    from harness.cli.lists import named_values
    from harness.cli.output import print_json
    from harness.cli.qualified import end_unqualified, qualification
    from harness.cli.recording import recorded
    from harness.workflows import run as run_case

    values = named_values(settings or (), "--set")
    runner.check_names([runner.engine or "lammps"])
    more: dict[str, Any] = {}

    @contextmanager
    def open_one(name: str) -> Iterator[Engine]:
        with runner.open(name, runner.integrator) as engine:
            yield engine
            more.update(qualification(engine, told))
            more.update(runs_made(engine))

    with recorded("run") as told:
        found = run_case(case, values, runner.engine, open_one=open_one)
        record = {**found.record(), **more}
        told.engine, told.quantities = record, run_quantities(record, values)
    if json:
        print_json(record)
    else:
        _print(record)
    end_unqualified(record, found.engine)


def _print(record: Mapping[str, Any]) -> None:
    """Print who ran, the parameters, and a line for each quantity."""
    from harness.cli.output import print_wrapped

    print(f"{record['case']} in {record['engine']} {record['engine_version']}")
    given = (f"{name} = {_short(value)}" for name, value in _flat(record["parameters"]))
    print_wrapped(", ".join(given), indent=2)
    width = max((len(name) for name in record["quantities"]), default=0)
    for name, quantity in record["quantities"].items():
        unit = "" if quantity["unit"] == "1" else quantity["unit"]
        line = f"{name:<{width}}  {_short(quantity['value'])} {unit}".rstrip()
        if quantity["reference_kind"] != "none":
            line += (
                f", {_short(quantity['reference'])} by {quantity['reference_kind']}, "
                f"difference {quantity['difference']:.2g}"
            )
        print_wrapped(line)


def _flat(values: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    """Yield names and values, of nested ones with a dot, as ``--set`` takes them."""
    for name, value in values.items():
        if isinstance(value, Mapping):
            yield from _flat(value, f"{prefix}{name}.")
        else:
            yield prefix + name, value


def _short(value: Any) -> str:
    return f"{value:.8g}" if isinstance(value, float) else str(value)
