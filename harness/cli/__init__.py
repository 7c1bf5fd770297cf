"""The command line: parse, call, print. Whatever is heavy is imported inside a command."""

from __future__ import annotations

import os
import sys

try:
    import contextlib
    import gc
    import signal
    import threading
    import time
    from collections.abc import Sequence
    from pathlib import Path
    from typing import Any

    from cyclopts import App, CycloptsError, Group, Parameter, UnusedCliTokensError

    from harness import __version__
    from harness.errors import FULL, HarnessError, RequestError
except KeyboardInterrupt:  # Ctrl-C before main() can handle it
    print("dem-harness: interrupted", file=sys.stderr)
    raise SystemExit(130) from None

REFUSED, INTERNAL, INTERRUPTED, TERMINATED = 2, 4, 130, 143
TRACEBACK = "DEM_HARNESS_TRACEBACK"  # environment variable: show the traceback of internal errors
MOST_CHARACTERS = 4000  # of an error
CLEANING_SECONDS = 2.0  # of threads after an interrupt, at most
HELP = (
    "Check discrete element (DEM) codes against theory.\n\n"
    "The frictionless incline (critical angle 10.2078 deg), the tower hit by a dropped grain, "
    "contacts with friction and layers, in closed form, in solvers of this package and in DEM "
    "codes.\n\n"
    "Exit status: 0 all verdicts hold; 1 a verdict failed; 2 the request was wrong; 3 an engine "
    "could not be run or died, or a named case, or all, tested nothing; 4 internal error; 130 "
    "interrupted; 143 terminated."
)
COMMANDS = {
    "verify": ("runs", "Hold engines against theory and accepted runs, and report.",
               "--quick --output mine", "--engines lammps,liggghts --cases contacts"),
    "run": ("runs", "Run a case once: what it measures, and what is expected.",
            "tower --set height=2 --set speed=4", "oblique --set friction=0.3 --film oblique.gif",
            "columns --set n=8 --quantity critical_angle_deg --engine reference"),
    "sweep": ("runs", "Run a case over values of its parameters and over engines.",
              "tower --over height=1,2,5:20:4 --engines exact,lammps --output mine",
              "oblique --set preset=kharaz --over angle=5:85:9 --reference measured.csv",
              "inputs/sweeps/step-and-stiffness.toml --dask tcp://head:8786"),
    "theory": ("systems", "Critical angle of the incline in closed form.",
               "--restitution 0.5", "--friction 0.5 --shape disc"),
    "critical-angle": ("systems", "Critical angle of the incline in an engine.",
                       "--engine yade --contact clipped"),
    "tower": ("systems", "Drop a grain on a tower: force, impulse and contacts.",
              "--height 4 --law overlap --solver lammps",
              "--height 2 --window first-contact --series tower.csv"),
    "impulse": ("systems", "Impulse and critical angle against the height of the tower.",
                "--heights 1-4 --stiffness 1e6 --law overlap --figure angles.svg"),
    "cases": ("results", "List the cases; or show one in full.", "oblique"),
    "engines": ("results", "List the engines that are here, and why others are not.",
                "--program yade=/opt/yade/bin/yade"),
    "inputs": ("results", "Write the scripts of LAMMPS, or check the committed ones.",
               "--engine yade --output mine"),
    "diff": ("results", "Compare runs: what moved, and by how much.",
             "reports/runs/monday reports/runs/tuesday", "mine accepted"),
    "accept": ("results", "Merge the rows of a run into the accepted runs.", "reports/runs/monday"),
    "releases": ("results", "Run the same cases in several LAMMPS releases.",
                 "2024.8.29.3.0 2025.7.22.4.0", './lmp-old "./lmp-new -sf omp" --output mine'),
    "defect": ("results", "Show known defects: cause, releases, script.", "tsuji-restitution"),
    "upstream": ("results", "Run LAMMPS's own granular tests against the reference.",
                 "~/lammps/unittest/granular/tests --lmp 2024.8.29.3.0 --lmp ./lmp"),
    "reproduce": ("results", "Recompute what the source states: ledger and figures.", "--check"),
    "site": ("results", "Build a static site of the committed reports and of runs.",
             "reports/runs/monday --output public"),
    "cache": ("results", "Show what is kept, or clear it.", "--clear --older-than 30"),
}  # fmt: skip
"""The module of each command, imported when it is run; its line in the help; examples."""
_stopped_by: list[int] = []  # signals that ended this process


def main() -> None:
    """Run ``dem-harness``; end with its exit status (0 to 4, 130 or 143)."""
    try:
        signal.signal(signal.SIGTERM, _stop)
        _open_streams()
        # imports and runs leave few cycles: looking for them took a twentieth of the time
        gc.set_threshold(20_000)
        # threads of the linear algebra cost a sixth of it, of matrices as small as these
        os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
        status = _flushed(_status(sys.argv[1:]))
    except KeyboardInterrupt:
        _let_threads_clean_up()
        status = TERMINATED if _stopped_by else INTERRUPTED
        how = "terminated" if _stopped_by else "interrupted"
        print(f"dem-harness: {how}; nothing half-written is left", file=sys.stderr)
        os._exit(status)  # threads that go on would keep the process
    gc.freeze()  # the interpreter would end with a last look for cycles, of half a second
    sys.exit(status)


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
        default_parameter=Parameter(negative=(), show_default=_default_text),
        help_format="markdown" if words[:1] and words[0] in COMMANDS else "plaintext",
        suppress_keyboard_interrupt=False,
    )
    for place, (name, (module, summary, *examples)) in enumerate(COMMANDS.items()):
        lines = "\n\n".join(["For example:", *(f"    dem-harness {name} {e}" for e in examples)])
        home = f"harness.cli.{module}:{name.replace('-', '_')}"
        line = None if name in words[:1] else summary
        app.command(home, name=name, sort_key=place, help=line, help_epilogue=lines)
    app.register_install_completion_command()
    return app


def usage_error(error: CycloptsError) -> str:
    """Return an error of parsing in two lines: option, value and what is allowed; the help."""
    error.verbose = False
    cause = error.__cause__
    message = str(cause) if isinstance(cause, RequestError) else " ".join(str(error).split())
    if isinstance(error, UnusedCliTokensError) and error.unused_tokens:
        message = f"{error.unused_tokens[0]!r}: is more than the command takes"
    command = " ".join(["dem-harness", *(error.command_chain or ())])
    return f"{message}\nsee {command} --help"


def _default_text(value: Any) -> str | None:
    if value is None or value is False or value in ("", ()):
        return None
    return f"{value:g}" if isinstance(value, float) else str(value)


def _status(words: list[str]) -> int:
    try:
        app = make_app(words)
        status = app(words, exit_on_error=False, print_error=False, result_action="return_value")
        if status is None:  # help or version; wrong only where nobody requested it
            return 0 if any(word.startswith("-") for word in words) else REFUSED
        return int(status)
    except CycloptsError as error:
        return _print_error(usage_error(error), REFUSED)
    except HarnessError as error:
        return _print_error(str(error), error.exit_status)
    except BrokenPipeError:
        return 0  # the reader of stdout has seen enough
    except SystemExit as ending:
        if isinstance(ending.__context__, BrokenPipeError):  # as rich ends then
            return 0
        return _print_error(f"internal error: a library ended the process ({ending})", INTERNAL)
    except Exception as error:
        if os.environ.get(TRACEBACK):
            raise
        if isinstance(error, OSError) and error.errno in FULL:
            return _print_error(
                f"{error.filename or 'stdout or a file'}: {error.strerror}", INTERNAL
            )
        if isinstance(error, PermissionError) and error.filename:
            return _print_error(f"{error.filename}: {error.strerror}", REFUSED)
        name = f"{type(error).__name__}: {error}".strip(": ")
        text = f"internal error: {name}\nif this is a bug, {TRACEBACK}=1 shows where it is"
        return _print_error(text, INTERNAL)


def _print_error(message: str, status: int) -> int:
    from harness.cli.output import show
    from harness.report.content import printable

    message = printable(message)[:MOST_CHARACTERS]
    with contextlib.suppress(OSError):
        print(f"dem-harness: {message}", file=sys.stderr)
        if "--json" in sys.argv[1:]:
            show({"error": message, "status": status}, True)
    return status


def _stop(number: int, _: Any) -> None:
    signal.signal(number, signal.SIG_IGN)  # a second SIGTERM does not cut the cleaning short
    _stopped_by.append(number)
    raise KeyboardInterrupt


def _let_threads_clean_up() -> None:
    """Wait for threads whose programs were killed: they remove temporary folders.

    One in compiled code goes on: it is not waited for any longer.
    """
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.SIG_IGN)
    end = time.monotonic() + CLEANING_SECONDS
    for thread in threading.enumerate():
        if thread is not threading.current_thread() and not thread.daemon:
            thread.join(max(0.0, end - time.monotonic()))


def _open_streams() -> None:
    """Open streams that the caller closed, and print question marks for what cannot be shown."""
    for name, mode in (("stdin", "r"), ("stdout", "w"), ("stderr", "w")):
        if getattr(sys, name) is None:
            setattr(sys, name, Path(os.devnull).open(mode, encoding="utf-8"))  # noqa: SIM115
    for stream in (sys.stdout, sys.stderr):
        with contextlib.suppress(AttributeError, ValueError):
            stream.reconfigure(errors="replace")  # type: ignore[union-attr]


def _flushed(status: int) -> int:
    """Write out stdout; a closed pipe is no error, a full disk is."""
    try:
        print(end="", flush=True)
    except OSError as error:
        with contextlib.suppress(OSError, ValueError):  # the interpreter would complain at its end
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        if not isinstance(error, BrokenPipeError) and status != INTERNAL:
            return _print_error(f"stdout: {error}", INTERNAL)
    return status
