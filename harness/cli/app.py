"""The commands of ``dem-harness``, gathered; each module is imported when its command is run."""

from __future__ import annotations

from cyclopts import App, Parameter

from harness import __version__
from harness.cli.command import converted, default_text, panel

app = App(
    name="dem-harness",
    help="""Check discrete element (DEM) codes against theory.

    The frictionless incline (critical angle 10.2078 deg), the tower hit by a dropped grain,
    contacts with friction and layers, in closed form, in solvers of this package and in DEM codes.

    Exit status: 0 all verdicts hold; 1 a verdict failed; 2 the request was
    wrong; 3 an engine could not be run, died or does not qualify; 4 internal error;
    130 interrupted; 143 terminated.
    """,
    version=f"dem-harness {__version__}",
    version_flags="--version",
    group_parameters=panel("Options"),
    default_parameter=Parameter(
        negative=(), converter=converted, allow_repeating=True, show_default=default_text
    ),
    help_format="markdown",
    suppress_keyboard_interrupt=False,
)

COMMANDS = (
    "verify", "reproduce", "theory", "critical_angle", "tower", "impulse", "cases", "run", "sweep",
    "study", "inputs", "engines", "releases", "upstream", "defect", "diff", "history", "site",
    "cache", "baseline",
)  # fmt: skip
for place, name in enumerate(COMMANDS):
    app.command(f"harness.cli.{name}:{name}", sort_key=place)
app.register_install_completion_command()


@app.command(name="--show-completion")
def show_completion() -> int:
    """Show completion for the current shell, to copy it or customize the installation."""
    print(app.generate_completion())
    return 0
