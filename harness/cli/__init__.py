"""The command line: parse, call, print. Everything heavy is imported inside a command."""

from __future__ import annotations

import sys


def main() -> None:
    """Run ``dem-harness``; end with the exit status of the design (0, 1, 2 or 3)."""
    from harness.cli.app import app
    from harness.errors import HarnessError

    try:
        app()
    except HarnessError as error:
        print(f"dem-harness: {error}", file=sys.stderr)
        sys.exit(error.exit_status)
    except KeyboardInterrupt:
        print("dem-harness: interrupted; nothing half-written is left", file=sys.stderr)
        sys.exit(130)
