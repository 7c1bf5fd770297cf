"""The command line: parse, call, print. Everything heavy is imported inside a command."""

from __future__ import annotations

import os
import sys

INTERRUPTED = 130
"""Exit status after Ctrl-C, by the shells' convention (128 + SIGINT)."""


def main() -> None:
    """Run ``dem-harness``; end with the exit status of the design (0, 1, 2 or 3)."""
    from harness.cli.app import app
    from harness.errors import HarnessError

    try:
        app()
    except HarnessError as error:
        print(f"dem-harness: {error}", file=sys.stderr)
        sys.exit(error.exit_status)
    except SystemExit as ending:
        if ending.code == INTERRUPTED:
            print("dem-harness: interrupted; nothing half-written is left", file=sys.stderr)
            # all is cleared away by now; threads that go on with what nobody waits for
            # would keep the process until they are done
            sys.stdout.flush()
            sys.stderr.flush()
            os._exit(INTERRUPTED)
        raise
