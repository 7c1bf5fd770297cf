"""``dem-harness run``."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from harness.cli.command import File, Json, Name, Settings, options
from harness.cli.engine_options import (
    CostOptions,
    IntegratorOptions,
    answer,
    completed,
    with_restarts,
)
from harness.cli.files import check_target, print_wrapped, write_all
from harness.cli.film import FilmOptions
from harness.errors import RequestError
from harness.report.plain import write_csv

if TYPE_CHECKING:
    from harness.engines.contract import Engine
    from harness.report.film import Film
    from harness.workflows.case_runs import RunResult


@options()
class CaseOptions(CostOptions):
    """What is run."""

    settings: Settings = None
    """A parameter of the case, in SI units and degrees; repeat it for several."""
    profile: File = None
    """Write the profile of the run over the height to this CSV file, of a case that has one."""

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

    A run of LAMMPS that takes long leaves restart files with the kept results, where the same
    command goes on after it was cut. With --force a run, or its part between two of them, has two
    hours in place of five minutes.

    For example:

        dem-harness run tower --set height=2 --set speed=4
        dem-harness run layers-flow --set angle=16 --profile profile.csv
        dem-harness run columns --set n=8 --quantity critical_angle_deg --engine reference

    Parameters
    ----------
    case
        A case that `dem-harness cases` lists.
    """
    from harness.cli.recording import recorded, run_quantities
    from harness.engines.border import MOST_SECONDS
    from harness.engines.typed import named_values
    from harness.workflows import run as run_case
    from harness.workflows.study_run import RUN_SECONDS
    from harness.workflows.sweep_plan import names_in

    values = named_values(choice.settings or (), "--set")
    choice.check_profile(case)
    film.check()
    if film.film is not None:
        _check_film(case, film.film)
    engines = [runner.engine or "lammps"]
    runner.check_names(engines)
    runner = with_restarts(runner, engines, RUN_SECONDS if choice.force else math.inf)
    more: dict[str, Any] = {}

    @contextmanager
    def open_one(name: str) -> Iterator[Engine]:
        with runner.open(name, runner.integrator) as engine:
            yield engine
            more.update(completed({}, engine, recording))

    with recorded("run", quiet=json) as recording:
        result = run_case(
            case,
            values,
            runner.engine,
            quantities=names_in(choice.quantity),
            open_one=open_one,
            progress=recording.progress,
            most_seconds=math.inf if choice.force else MOST_SECONDS,
        )
        record = {**result.to_json(), **more}
        recording.engine, recording.quantities = record, run_quantities(record, values)
        choice.write_profile(result)
        film.write(partial(_film, case, values, runner))
    return answer(record, result.engine, json, _print)


def _check_film(case: str, path: Path) -> None:
    """Raise RequestError, before anything is run, for a case without a film."""
    from harness.cases.contract import Case
    from harness.cases.registry import get_case

    if type(get_case(case)).film is Case.film:
        raise RequestError(f"--film {path}: case {case!r} has no film")


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


def _short(value: Any) -> str:
    return f"{value:.8g}" if isinstance(value, float) else str(value)
