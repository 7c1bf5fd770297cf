"""The command line: parse, call, print. Everything heavy is imported inside a command."""

from __future__ import annotations

try:
    import atexit
    import contextlib
    import os
    import signal
    import sys
    from pathlib import Path
    from typing import Any
except KeyboardInterrupt:  # Ctrl-C before main() is there to hear it
    raise SystemExit(130) from None

INTERRUPTED = 130
"""Exit status after Ctrl-C, by the shells' convention (128 + SIGINT)."""

TERMINATED = 143
"""Exit status after SIGTERM, likewise (128 + SIGTERM)."""

INTERNAL = 4
"""Exit status of a bug, or of a machine that cannot go on: a full disk, no memory."""

TRACEBACK = "DEM_HARNESS_TRACEBACK"
"""Environment variable: where it is set, an internal error shows its traceback."""


_stopped_by: list[int] = []
"""Signals that ended this process as Ctrl-C does."""


def main() -> None:
    """Run ``dem-harness``; end with the exit status of the design (0 to 4, 130 or 143)."""
    try:
        signal.signal(signal.SIGTERM, _stop)
        _open_streams()
        for stream in (sys.stdout, sys.stderr):
            # a terminal or a pipe that is not UTF-8, or an argument that was not
            with contextlib.suppress(AttributeError, ValueError):
                stream.reconfigure(errors="replace")  # type: ignore[union-attr]
        status = _status()
    except KeyboardInterrupt:  # while the commands were being imported
        status = interrupted_status()
    stopped = status in (INTERRUPTED, TERMINATED)
    if stopped:
        how = "interrupted" if status == INTERRUPTED else "terminated"
        print(f"dem-harness: {how}; nothing half-written is left", file=sys.stderr)
    status = _flushed(status)
    if stopped:
        # all is cleared away by now; threads that go on with what nobody waits for
        # would keep the process until they are done
        os._exit(status)
    # what is left is the interpreter's end: a signal then must not change the status
    for number in (signal.SIGINT, signal.SIGTERM):
        atexit.register(signal.signal, number, signal.SIG_IGN)
    sys.exit(status)


def _open_streams() -> None:
    """Open what the caller closed of stdin, stdout and stderr: no file may get their numbers."""
    for name, mode in (("stdin", "r"), ("stdout", "w"), ("stderr", "w")):
        if getattr(sys, name) is None:
            setattr(sys, name, Path(os.devnull).open(mode, encoding="utf-8"))  # noqa: SIM115


def interrupted_status() -> int:
    """Return the exit status of a run that was interrupted, by Ctrl-C or SIGTERM."""
    return TERMINATED if _stopped_by else INTERRUPTED


def _stop(number: int, _: Any) -> None:
    """Clean up as after Ctrl-C; a second SIGTERM does not cut that short."""
    signal.signal(number, signal.SIG_IGN)
    _stopped_by.append(number)
    raise KeyboardInterrupt


def _status() -> int:
    """Run the command and return its exit status; errors are printed here."""
    from cyclopts import CycloptsError

    from harness.cli.command import app, usage_message, with_options
    from harness.errors import HarnessError

    words = sys.argv[1:]
    try:
        if not words or words[0].startswith("-"):
            app.resolved_commands()  # the list of the commands says what each does
        status = app(words, exit_on_error=False, print_error=False, result_action="return_value")
        if status is None:  # no command: the help, which is wrong only where nobody asked for it
            return 0 if any(word.startswith("-") for word in words) else 2
        return int(status)
    except HarnessError as error:
        return _print_error(with_options(str(error), words), error.exit_status)
    except BrokenPipeError:
        return 0  # the reader of our output has seen enough
    except KeyboardInterrupt:
        return interrupted_status()
    except CycloptsError as error:
        return _print_error(usage_message(error), 2)
    except SystemExit as ending:
        if isinstance(ending.__context__, BrokenPipeError):
            return 0  # as rich ends then
        return _print_error(f"internal error: a library ended the process ({ending})", INTERNAL)
    except Exception as error:  # whatever it is, one line says it
        if os.environ.get(TRACEBACK):
            raise
        return _print_error(_internal(error), INTERNAL)


def _internal(error: Exception) -> str:
    """Return an error that nobody foresaw, or a machine's, in words."""
    from harness.errors import FULL

    if isinstance(error, OSError) and error.errno in FULL:
        where = f": {error.filename}" if error.filename else ""
        return f"no space is left on the disk{where}"
    if isinstance(error, MemoryError):
        return "there is not enough memory for this"
    try:
        Path.cwd()
    except OSError:
        return "the working directory does not exist any more"
    name = f"{type(error).__name__}: {error}".strip(": ")
    return f"internal error: {name}\nthis is a bug; {TRACEBACK}=1 shows where it is"


def _print_error(message: str, status: int) -> int:
    """Print an error on stderr, and with --json as an object on stdout; return the status."""
    from harness.report.plain import printable, shortened

    message = shortened(printable(message))
    with contextlib.suppress(OSError):
        print(f"dem-harness: {message}", file=sys.stderr)
        if "--json" in sys.argv[1:]:
            from harness.cli.files import print_json

            print_json({"error": message, "status": status})
    return status


def _flushed(status: int) -> int:
    """Write out what is still in stdout; a closed pipe is no error, a full disk is."""
    try:
        sys.stdout.flush()
    except BrokenPipeError:
        _to_nowhere()
    except OSError as error:
        from harness.errors import FULL

        _to_nowhere()
        if status == INTERNAL:
            return status  # the command failed by it, and said so
        full = error.errno in FULL  # the same words, whenever what was printed is written out
        return _print_error(_internal(error) if full else f"stdout: {error.strerror}", INTERNAL)
    return status


def _to_nowhere() -> None:
    """Discard what stdout still holds: the interpreter would complain of it at the end."""
    with contextlib.suppress(OSError, ValueError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
