"""``dem-harness run``: one run of a case."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Annotated

from cyclopts import Group, Parameter

from harness.cli.app import ENGINE, File, Force, Json, MaybeWhole, Name, Settings
from harness.cli.engines import ClusterOptions, Opener, duration_check
from harness.cli.output import check_target, show, write_all, write_csv
from harness.errors import RequestError
from harness.files import text_writer

if TYPE_CHECKING:
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
        import pandas as pd

        profile = partial(write_csv, pd.DataFrame(dict(result.profile)))
        files = {("--profile", self.profile): profile}
        write_all(files | {("--script", self.script): text_writer(result.script)})
        if self.film is not None and result.discs is not None:
            from harness.report.film import write_film

            write_film(result.discs, self.film, self.pictures)


def run(
    case: str,
    /,
    choice: RunOptions = RunOptions(),
    engines: ClusterOptions = ClusterOptions(),
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
    from harness.engines.registry import named_values
    from harness.workflows import run as run_case
    from harness.workflows.progress import progress_bars
    from harness.workflows.runs import runner_name

    choice.check()
    name = runner_name(get_case(case), choice.engine)
    engines.check([name], "--engine")
    opener = Opener(engines)
    with progress_bars("run", quiet=json) as progress, engines.executor() as opener.executor:
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
    return opener.answer(result.to_json(), result.engine, json, lambda _: show(result, False))
