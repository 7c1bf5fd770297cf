"""``dem-harness cases``, ``engines`` and ``run``: what there is, and one run of it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from harness.cli.command import File, Json, Name, Settings, options
from harness.cli.engine_options import (
    IntegratorOptions,
    LongRunOptions,
    WhereOptions,
    answer,
    completed,
)
from harness.cli.files import (
    FilmOptions,
    check_target,
    print_columns,
    print_json,
    print_wrapped,
    write_all,
)
from harness.errors import RequestError
from harness.report.plain import write_csv

if TYPE_CHECKING:
    from harness.engines.contract import Engine
    from harness.report.film import Film
    from harness.workflows.case_runs import RunResult


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


@options()
class CaseOptions(LongRunOptions):
    """What is run."""

    settings: Settings = None
    """A parameter of the case, in SI units and degrees; repeat it for several."""
    profile: File = None
    """Write the profile of the run over the height, or its curves over time, to this CSV file, of a
    case that has one."""

    def check_profile(self, case: str) -> None:
        """Raise RequestError, before anything is run, for a profile that cannot be written."""
        check_target(self.profile, "--profile", (".csv",))
        if self.profile is None:
            return
        from harness.cases.contract import Case
        from harness.cases.registry import get_case

        if type(get_case(case)).profile is Case.profile:
            raise RequestError(f"--profile {self.profile}: case {case!r} has no profile")

    def write_profile(self, result: RunResult) -> None:
        """Write the profile, if one is requested."""
        if self.profile is not None:
            import pandas as pd

            frame = pd.DataFrame(dict(result.profile))
            write_all({("--profile", self.profile): partial(write_csv, frame)})

    quantity: Annotated[str, Parameter(metavar="NAMES")] = ""
    """Quantities to measure and show, with commas between. One such as `critical_angle_deg` takes
    several runs. [default: all that a run measures]"""


@options("Engine")
class RunnerOptions(IntegratorOptions):
    """Who runs the case."""

    engine: Name = None
    """An engine that `dem-harness engines` lists, `module:Class` of one of your own, or a solver
    that `dem-harness cases` names. [default: lammps, or a solver where it cannot]"""


def run(
    case: str,
    /,
    choice: CaseOptions = CaseOptions(),
    runner: RunnerOptions = RunnerOptions(),
    film: FilmOptions = FilmOptions(),
    *,
    json: Json = False,
) -> int:
    """One run of any case: its parameters, what it measures, and what is expected.

    A run has five minutes, or ten times its expected time where that is longer.

    For example:

        dem-harness run tower --set height=2 --set speed=4
        dem-harness run layers-flow --set angle=16 --profile profile.csv
        dem-harness run columns --set n=8 --quantity critical_angle_deg --engine reference

    Parameters
    ----------
    case
        A case that `dem-harness cases` lists.
    """
    from harness.engines.registry import named_values
    from harness.workflows import progress_bars
    from harness.workflows import run as run_case
    from harness.workflows.case_runs import check_film
    from harness.workflows.sweep_plan import names_in

    values = named_values(choice.settings or (), "--set")
    choice.check_profile(case)
    film.check()
    if film.film is not None:
        _check_film(case, film.film, runner.engine)
    engines = [runner.engine or "lammps"]
    runner.check_names(engines)
    more: dict[str, Any] = {}

    @contextmanager
    def open_one(name: str) -> Iterator[Engine]:
        with runner.open(name, runner.integrator) as engine:
            if film.film is not None:
                check_film(case, values, engine, film.pictures)
            yield engine
            more.update(completed({}, engine, progress))

    with progress_bars("run", quiet=json) as progress:
        result = run_case(
            case,
            values,
            runner.engine,
            quantities=names_in(choice.quantity),
            open_one=open_one,
            progress=progress,
            check_duration=lambda seconds: choice.check_duration(
                seconds, f"case {case!r} with these values"
            ),
        )
        record = {**result.to_json(), **more}
        choice.write_profile(result)
        film.write(partial(_film, case, values, runner))
    return answer(record, result.engine, json, _print)


def _check_film(case: str, path: Path, name: str | None) -> None:
    """Raise RequestError, before anything is run, for a case without a film, and for a solver."""
    from harness.cases.registry import get_case
    from harness.workflows.case_runs import is_solver, usual_engine

    chosen = get_case(case)
    if not chosen.display.has_film:
        raise RequestError(f"--film {path}: case {case!r} has no film")
    name = name or usual_engine(chosen)
    if is_solver(chosen, name):
        raise RequestError(f"--film {path}: {name!r} is a solver: an engine runs the film")


def _film(case: str, values: Mapping[str, str], runner: RunnerOptions, frames: int) -> Film:
    """Return the film of the same system, by a run of its own."""
    from harness.workflows.case_runs import film

    with runner.open(runner.engine or "lammps", runner.integrator) as engine:
        return film(case, values, engine, frames=frames)


def _print(record: Mapping[str, Any]) -> None:
    from harness.cases.registry import get_case

    print(f"{record['case']} in {record['engine']} {record['engine_version']}")
    parameters = (f"{name} = {_short(value)}" for name, value in _flat(record["parameters"]))
    print_wrapped(", ".join(parameters), indent=2)
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
    more = [q.name for derived in get_case(record["case"]).derived() for q in derived.quantities]
    if more and not record["quantities"].keys() & set(more):
        print_wrapped(f"by --quantity, of several runs: {', '.join(more)}", indent=2)


def _flat(values: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    for name, value in values.items():
        if isinstance(value, Mapping):
            yield from _flat(value, f"{prefix}{name}.")
        else:
            yield prefix + name, value


def engines(where: WhereOptions = WhereOptions(), *, json: Json = False) -> int:
    """Which engines are here, in which version, how they are run, and why one is missing.

    For example:

        dem-harness engines
        dem-harness engines --program yade=/opt/yade/bin/yade
    """
    from harness.engines.registry import refused_plugins
    from harness.store.entries import tell_stderr
    from harness.workflows import engines as ask
    from harness.workflows import progress_bars

    with progress_bars("engines", quiet=json) as progress:
        statuses = ask(
            lmp=where.lmp, launcher=where.mpirun, programs=where.programs, progress=progress
        )
    for fault in refused_plugins():
        tell_stderr(fault)
    if json:
        print_json({"engines": [status.to_json() for status in statuses]})
        return 0
    lines = []
    for status in statuses:
        provenance = status.provenance
        cells = (
            ("missing", status.reason)
            if provenance is None
            else (provenance.engine_version, provenance.executable)
        )
        lines.append((status.engine, status.how, *cells))
    print_columns(lines)
    return 0
