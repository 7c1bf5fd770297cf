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

    The frictionless incline (critical angle 10.2078 deg), the tower hit by a dropped grain,
    contacts with friction and layers, in closed form, in solvers of this package and in DEM codes.

    Exit status: 0 all verdicts hold; 1 a verdict failed; 2 the request was
    wrong; 3 an engine could not be run, died or does not qualify; 4 internal error;
    130 interrupted; 143 terminated.
    """


for command in (
    verify, reproduce, theory, critical_angle, tower, impulse, cases, run, sweep, study, inputs,
    engines, releases, diff, history, cache,
):  # fmt: skip
    add_command(app, command)
app.add_typer(baseline)
