"""``dem-harness run``: one run of a case."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Group, Parameter

from harness.cli.app import (
    ENGINE,
    CacheOptions,
    DaskOptions,
    File,
    Force,
    Json,
    MaybeWhole,
    Name,
    ProgramOptions,
    Settings,
)
from harness.cli.engines import Opener, answer, duration_check, executor_of
from harness.cli.output import check_target, print_wrapped, short, write_all, write_csv
from harness.errors import RequestError

if TYPE_CHECKING:
    from harness.cli.output import Writer
    from harness.workflows.runs import RunResult

FILM = Group("Film", sort_key=2)


@Parameter(name="*")
@dataclass(frozen=True, kw_only=True)
class RunOptions:
    """What is run and written."""

    settings: Settings = None
    """A parameter of the case, in SI units and degrees, or `preset=NAME`; repeat it for several."""
    quantity: Annotated[str, Parameter(metavar="NAMES")] = ""
    """Quantities to measure and show, with commas between. One such as critical_angle_deg takes
    several runs. [default: all that a run measures]"""
    engine: Annotated[Name, Parameter(group=ENGINE)] = None
    """An engine that `dem-harness engines` lists, `module:Class` of your own, or a solver that
    `dem-harness cases` lists. [default: lammps, or a solver where it cannot]"""
    script: File = None
    """Write the plain script of the run, for the code itself, to this file."""
    profile: File = None
    """Write the profile of the run over the height, or its curves over time, to this CSV file, of a
    case that has one."""
    film: Annotated[File, Parameter(group=FILM)] = None
    """Write a film of the motion to this file: .gif, or .mp4 where ffmpeg is on the path. A .png is
    one picture of it."""
    frames: Annotated[MaybeWhole, Parameter(group=FILM)] = None
    """Pictures of the film, 20 a second. [default: 120]"""
    force: Force = False

    def check(self) -> None:
        """Raise RequestError, before anything is run, for files that cannot be written."""
        check_target(self.profile, "--profile", (".csv",))
        check_target(self.script, "--script")
        if self.frames is not None and self.film is None:
            raise RequestError(f"--frames {self.frames}: goes with --film only")
        if self.film is not None:
            from harness.report.film import check_film

            check_film(self.film, self.pictures)

    @property
    def pictures(self) -> int:
        """Return the number of pictures of the film."""
        return 120 if self.frames is None else self.frames

    def write(self, result: RunResult) -> None:
        """Write the requested files."""
        files: dict[tuple[str, Path], Writer] = {}
        if self.profile is not None:
            import pandas as pd

            frame = pd.DataFrame(dict(result.profile))
            files["--profile", self.profile] = partial(write_csv, frame)
        if self.script is not None:
            files["--script", self.script] = lambda path: path.write_text(result.script, "utf-8")
        if files:
            write_all(files)
        if self.film is not None and result.discs is not None:
            from harness.report.film import write_film

            write_film(result.discs, self.film, self.pictures)


def run(
    case: str,
    /,
    choice: RunOptions = RunOptions(),
    programs: ProgramOptions = ProgramOptions(),
    kept: CacheOptions = CacheOptions(),
    cluster: DaskOptions = DaskOptions(),
    *,
    json: Json = False,
) -> int:
    """Run a case once: its parameters, what it measures, and what is expected.

    The reference of a quantity is its value at equal steps where the reference can run the case,
    else the closed form. The limit is that of small steps.

    For example:

        dem-harness run tower --set height=2 --set speed=4

        dem-harness run layers-flow --set angle=16 --profile profile.csv

        dem-harness run columns --set n=8 --quantity critical_angle_deg --engine reference

    Parameters
    ----------
    case
        A case that `dem-harness cases` lists.
    """
    from harness.cases.registry import get_case
    from harness.workflows import run as run_case
    from harness.workflows.progress import progress_bars
    from harness.workflows.runs import runner_name
    from harness.workflows.settings import named_values

    choice.check()
    name = runner_name(get_case(case), choice.engine)
    opener = Opener(programs, kept)
    opener.check([name])
    with progress_bars("run", quiet=json) as progress, executor_of(cluster.dask) as opener.executor:
        result = run_case(
            case,
            named_values(choice.settings or (), "--set"),
            name,
            quantities=choice.quantity,
            open_engine=partial(opener.qualified, progress=progress),
            profile=choice.profile is not None,
            script=choice.script is not None,
            film_frames=choice.pictures if choice.film is not None else 0,
            check_duration=duration_check(choice.force, f"case {case!r} with these values"),
            progress=progress,
        )
    choice.write(result)
    record = {**result.to_json(), **opener.runs(), **opener.qualification}
    return answer(record, result.engine, json, _print)


def _print(record: Mapping[str, Any]) -> None:
    from harness.cases.registry import get_case

    print(f"{record['case']} in {record['engine']} {record['engine_version']}")
    values = _flat(record["parameters"]).items()
    print_wrapped(", ".join(f"{name} = {short(value)}" for name, value in values), indent=2)
    width = max((len(name) for name in record["quantities"]), default=0)
    for name, found in record["quantities"].items():
        print_wrapped(f"{name:<{width}}  {_words(found)}")
    more = [q.name for q in get_case(record["case"]).quantities if q.varies]
    if more and not record["quantities"].keys() & set(more):
        print_wrapped(f"by --quantity, of several runs: {', '.join(more)}", indent=2)


def _words(found: Mapping[str, Any]) -> str:
    unit = "" if found["unit"] == "1" else found["unit"]
    text = f"{short(found['value'])} {unit}".rstrip()
    if found.get("uncertainty"):
        text += f" +- {found['uncertainty']:.2g}"
    if found["reference_kind"] != "none":
        text += f", {short(found['reference'])} by {found['reference_kind']}"
        text += f", difference {found['difference']:.2g}"
    if found["step_error"] == found["step_error"]:
        text += f"; limit {short(found['limit'])}, error of the step {found['step_error']:.2g}"
    return text


def _flat(values: Mapping[str, Any], prefix: str = "") -> dict[str, Any]:
    flat: dict[str, Any] = {}
    for name, value in values.items():
        nested = isinstance(value, Mapping)
        flat |= _flat(value, f"{prefix}{name}.") if nested else {prefix + name: value}
    return flat
