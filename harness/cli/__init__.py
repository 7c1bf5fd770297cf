"""The command line: parse, call, print. Whatever is heavy is imported inside a command."""

from __future__ import annotations

try:
    import contextlib
    import os
    import signal
    import sys
    from pathlib import Path
    from typing import Any
except KeyboardInterrupt:  # Ctrl-C before main() can handle it
    raise SystemExit(130) from None

REFUSED, INTERNAL, INTERRUPTED, TERMINATED = 2, 4, 130, 143
TRACEBACK = "DEM_HARNESS_TRACEBACK"  # environment variable: show the traceback of internal errors
MOST_CHARACTERS = 4000  # of an error
_stopped_by: list[int] = []  # signals that ended this process


def main() -> None:
    """Run ``dem-harness``; end with its exit status (0 to 4, 130 or 143)."""
    try:
        signal.signal(signal.SIGTERM, _stop)
        _open_streams()
        status = _flushed(_status(sys.argv[1:]))
    except KeyboardInterrupt:
        status = TERMINATED if _stopped_by else INTERRUPTED
        how = "terminated" if _stopped_by else "interrupted"
        print(f"dem-harness: {how}; nothing half-written is left", file=sys.stderr)
        os._exit(status)  # threads that go on would keep the process
    sys.exit(status)


def _status(words: list[str]) -> int:
    """Run a command, print its error if it fails, and return its exit status."""
    from cyclopts import CycloptsError

    from harness.cli.app import make_app, usage_error
    from harness.errors import HarnessError

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
        name = f"{type(error).__name__}: {error}".strip(": ")
        text = f"internal error: {name}\nif this is a bug, {TRACEBACK}=1 shows where it is"
        return _print_error(text, INTERNAL)


def _print_error(message: str, status: int) -> int:
    """Print an error on stderr, and with --json as an object on stdout; return the status."""
    from harness.cli.output import print_json
    from harness.report.content import printable

    message = printable(message)[:MOST_CHARACTERS]
    with contextlib.suppress(OSError):
        print(f"dem-harness: {message}", file=sys.stderr)
        if "--json" in sys.argv[1:]:
            print_json({"error": message, "status": status})
    return status


def _stop(number: int, _: Any) -> None:
    signal.signal(number, signal.SIG_IGN)  # a second SIGTERM does not cut the cleaning short
    _stopped_by.append(number)
    raise KeyboardInterrupt


def _open_streams() -> None:
    """Open streams that the caller closed, and replace what a terminal cannot show."""
    for name, mode in (("stdin", "r"), ("stdout", "w"), ("stderr", "w")):
        if getattr(sys, name) is None:
            setattr(sys, name, Path(os.devnull).open(mode, encoding="utf-8"))  # noqa: SIM115
    for stream in (sys.stdout, sys.stderr):
        with contextlib.suppress(AttributeError, ValueError):
            stream.reconfigure(errors="replace")  # type: ignore[union-attr]


def _flushed(status: int) -> int:
    """Write out stdout; a closed pipe is no error, a full disk is."""
    try:
        sys.stdout.flush()
    except OSError as error:
        with contextlib.suppress(OSError, ValueError):  # the interpreter would complain at its end
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        if not isinstance(error, BrokenPipeError) and status != INTERNAL:
            return _print_error(f"stdout: {error}", INTERNAL)
    return status
