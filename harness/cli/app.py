"""The app, its commands, and types of options that several commands share."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any

from cyclopts import App, CycloptsError, Group, Parameter, Token, UnusedCliTokensError

from harness import __version__
from harness.errors import RequestError

ENGINE, KEPT = Group("Engine", sort_key=2), Group("Kept results", sort_key=3)


def whole_number(_: Any, tokens: Sequence[Token]) -> int:
    """Return a whole number; cyclopts would round 1.5. Raise RequestError for anything else."""
    try:
        return int(tokens[0].value)
    except ValueError:
        option = f"{tokens[0].keyword or ''} {tokens[0].value!r}".strip()
        raise RequestError(f"{option}: must be a whole number") from None


Json = Annotated[bool, Parameter(help="Print one JSON object on stdout, and nothing else.")]
Folder = Annotated[Path | None, Parameter(metavar="DIR")]
File = Annotated[Path | None, Parameter(metavar="FILE")]
Name = Annotated[str | None, Parameter(metavar="NAME")]
Names = Annotated[str | None, Parameter(metavar="NAME[,NAME...]")]
Settings = Annotated[list[str] | None, Parameter(name="--set", metavar="NAME=VALUE")]
Whole = Annotated[int, Parameter(converter=whole_number)]
MaybeWhole = Annotated[int | None, Parameter(converter=whole_number)]
Force = Annotated[
    bool, Parameter(help="Run also what is expected to take more than ten minutes of a core.")
]
HELP = (
    "Check discrete element (DEM) codes against theory.\n\n"
    "The frictionless incline (critical angle 10.2078 deg), the tower hit by a dropped grain, "
    "contacts with friction and layers, in closed form, in solvers of this package and in DEM "
    "codes.\n\n"
    "Exit status: 0 all verdicts hold; 1 a verdict failed; 2 the request was wrong; 3 an engine "
    "could not be run or died, or a named case tested nothing; 4 internal error; 130 interrupted; "
    "143 terminated."
)
COMMANDS = {
    "verify": ("verify:verify", "Hold engines against theory and accepted runs, and report."),
    "run": ("runs:run", "Run a case once: what it measures, and what is expected."),
    "sweep": ("runs:sweep", "Run a case over values of its parameters and over engines."),
    "theory": ("incline:theory", "Critical angle of the incline in closed form."),
    "critical-angle": ("incline:critical_angle", "Critical angle of the incline in an engine."),
    "tower": ("tower:tower", "Drop a grain on a tower: force, impulse and contacts."),
    "impulse": ("tower:impulse", "Impulse and critical angle against the height of the tower."),
    "cases": ("lists:cases", "List the cases; or show one in full."),
    "engines": ("lists:engines", "List the engines that are here, and why others are not."),
    "inputs": ("lists:inputs", "Write the scripts of LAMMPS, or check the committed ones."),
    "diff": ("results:diff", "Compare runs: what moved, and by how much."),
    "accept": ("results:accept", "Merge the rows of a run into the accepted runs."),
    "releases": ("results:releases", "Run the same cases in several LAMMPS releases."),
    "defect": ("lists:defect", "Show known defects: cause, releases, script."),
    "upstream": ("results:upstream", "Run LAMMPS's own granular tests against the reference."),
    "reproduce": ("results:reproduce", "Recompute what the source states: ledger and figures."),
    "site": ("results:site", "Build a static site of the committed reports and of runs."),
    "cache": ("lists:cache", "Show what is kept, or clear it."),
}
"""Module and function of each command, imported when it is run, and its line in the help."""


def make_app(words: Sequence[str]) -> App:
    """Return the app; in its help commands have their line of :data:`COMMANDS`.

    The command that is run, the first of ``words``, has the docstring of its function instead.
    """
    app = App(
        name="dem-harness",
        help=HELP,
        version=f"dem-harness {__version__}",
        version_flags="--version",
        group_parameters=Group("Options", sort_key=1),
        default_parameter=Parameter(negative=(), show_default=default_text),
        help_format="markdown" if words[:1] and words[0] in COMMANDS else "plaintext",
        suppress_keyboard_interrupt=False,
    )
    for place, (name, (home, summary)) in enumerate(COMMANDS.items()):
        line = None if name in words[:1] else summary
        app.command(f"harness.cli.{home}", name=name, sort_key=place, help=line)
    app.register_install_completion_command()
    return app


def default_text(value: Any) -> str | None:
    """Return the text of a default in the help; None for a flag or an empty one."""
    if value is None or value is False or value in ("", ()):
        return None
    return f"{value:g}" if isinstance(value, float) else str(value)


def usage_error(error: CycloptsError) -> str:
    """Return an error of parsing in two lines: option, value and what is allowed; the help."""
    error.verbose = False
    cause = error.__cause__
    message = str(cause) if isinstance(cause, RequestError) else " ".join(str(error).split())
    if isinstance(error, UnusedCliTokensError) and error.unused_tokens:
        message = f"{error.unused_tokens[0]!r}: is more than the command takes"
    command = " ".join(["dem-harness", *(error.command_chain or ())])
    return f"{message}\nsee {command} --help"
