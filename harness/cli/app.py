"""The commands of ``dem-harness``, gathered."""

from __future__ import annotations

from typing import Annotated

import typer

from harness.cli.baseline import baseline
from harness.cli.cache import cache
from harness.cli.cases import cases
from harness.cli.command import add_command
from harness.cli.critical_angle import critical_angle
from harness.cli.diff import diff
from harness.cli.engines import engines
from harness.cli.history import history
from harness.cli.impulse import impulse
from harness.cli.inputs import inputs
from harness.cli.releases import releases
from harness.cli.reproduce import reproduce
from harness.cli.run import run
from harness.cli.study import study
from harness.cli.sweep import sweep
from harness.cli.theory import theory
from harness.cli.tower import tower
from harness.cli.verify import verify

app = typer.Typer(
    name="dem-harness",
    no_args_is_help=True,
    rich_markup_mode="markdown",
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)


def _version(value: bool) -> None:
    if value:
        from harness import __version__

        typer.echo(f"dem-harness {__version__}")
        raise typer.Exit


@app.callback()
def root(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Print the version.")
    ] = False,
) -> None:
    """Check discrete element (DEM) codes against theory.

    Two systems, the frictionless incline (critical angle 10.2078 deg) and the
    tower hit by a dropped grain, in closed form, in solvers of this package and in DEM codes.

    Exit status: 0 all verdicts hold; 1 a verdict failed; 2 the request was
    wrong; 3 an engine could not be run, died or does not qualify; 4 internal error;
    130 interrupted; 143 terminated.
    """


add_command(
    app,
    verify,
    "dem-harness verify --quick --output mine",
    "dem-harness verify --engines all --cases incline,tower",
)
add_command(
    app,
    reproduce,
    "dem-harness reproduce --output mine",
    "dem-harness reproduce --check",
)
add_command(
    app, theory, "dem-harness theory --restitution 0.5", "dem-harness theory --shock 0.1 --json"
)
add_command(
    app,
    critical_angle,
    "dem-harness critical-angle --extrapolate",
    "dem-harness critical-angle --engine yade --program yade=/opt/yade/bin/yade --contact clipped",
)
add_command(
    app,
    tower,
    "dem-harness tower --height 4 --law overlap --solver lammps",
    "dem-harness tower --height 2 --window first-contact --series tower.csv",
)
add_command(
    app,
    impulse,
    "dem-harness impulse --heights 1-4 --stiffness 1e6 --speed 2",
    "dem-harness impulse --law overlap --figure angles.svg --reference measured.csv",
)
add_command(app, cases, "dem-harness cases", "dem-harness cases --json")
add_command(
    app,
    run,
    "dem-harness run tower --set height=2 --set speed=4",
    "dem-harness run incline --engine reference --json",
)
add_command(
    app,
    sweep,
    "dem-harness sweep incline --over angle=9:11:5 --over stiffness=1e5:1e7:log3",
    "dem-harness sweep tower --over height=1,2,5:20:4 --engines exact,lammps --output mine",
)
add_command(
    app,
    study,
    "dem-harness study layers --quick",
    "dem-harness study layers --reference measured.csv --output mine",
)
add_command(app, inputs, "dem-harness inputs --check", "dem-harness inputs --folder mine")
add_command(
    app, engines, "dem-harness engines", "dem-harness engines --program yade=/opt/yade/bin/yade"
)
add_command(
    app,
    releases,
    "dem-harness releases 2024.8.29.3.0 2025.7.22.4.0",
    "dem-harness releases ./lmp-old ./lmp-new --level default --output mine",
)
add_command(
    app,
    diff,
    "dem-harness diff reports/runs/monday reports/runs/tuesday",
    "dem-harness diff before after --output page",
)
add_command(
    app,
    history,
    "dem-harness history --command verify --limit 5",
    "dem-harness history --quantity 'critical angle*' --plot angle.svg --against version",
)
add_command(app, cache, "dem-harness cache --json", "dem-harness cache --clear --older-than 30")
app.add_typer(baseline)
