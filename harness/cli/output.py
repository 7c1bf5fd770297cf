"""What a command prints on stdout."""

from __future__ import annotations

import contextlib
import json
import shutil
import textwrap
from collections.abc import Iterable, Iterator, Mapping
from typing import Any


def print_json(record: Mapping[str, Any]) -> None:
    """Print one JSON object, strict JSON: what is not finite becomes null."""
    from harness.report.finite import finite

    print(json.dumps(finite(record), indent=2, ensure_ascii=False))


def print_json_rows(head: Mapping[str, Any], name: str, rows: Iterable[Mapping[str, Any]]) -> None:
    """Print one JSON object as :func:`print_json` does, with ``rows`` under ``name`` at its end.

    Each row is printed as it comes: the memory that this takes is that of one row.
    """
    from harness.report.finite import finite

    text = json.dumps(finite({**head, name: []}), indent=2, ensure_ascii=False)
    before, _, after = text.rpartition("]")
    end = ""
    print(before, end="")
    for row in rows:
        one = json.dumps(finite(row), indent=2, ensure_ascii=False).replace("\n", "\n    ")
        print(f"{end and ','}\n    {one}", end="")
        end = "\n  "
    print(f"{end}]{after}")


@contextlib.contextmanager
def closed_pipe_allowed() -> Iterator[None]:
    """Go on where the reader of stdout has seen enough: the exit status is still to come."""
    try:
        yield
    except BrokenPipeError:
        pass
    except SystemExit as ending:  # as rich ends then
        if not isinstance(ending.__context__, BrokenPipeError):
            raise


def print_record(record: Mapping[str, Any]) -> None:
    """Print a flat record as aligned lines, one a key; tables and long lists are left to JSON."""
    from harness.report.plain import printable

    shown = {key: value for key, value in record.items() if _is_short(value)}
    width = max(len(key) for key in shown)
    for key, value in shown.items():
        text = f"{value:.8g}" if isinstance(value, float) else printable(str(value))
        print(f"{key:<{width}}  {text}")


def print_wrapped(text: str, *, indent: int = 0) -> None:
    """Print printable text on lines that fit the terminal, the first after ``indent`` blanks."""
    from harness.report.plain import one_line

    width = min(shutil.get_terminal_size().columns, 120)
    lines = textwrap.wrap(
        one_line(text),
        width,
        initial_indent=" " * indent,
        subsequent_indent=" " * (indent + 2),
        break_on_hyphens=False,
    )
    print("\n".join(lines))


def _is_short(value: Any) -> bool:
    if isinstance(value, (list, tuple)):
        return len(value) <= 2 and not any(isinstance(item, Mapping) for item in value)
    return value is not None and value != "" and not isinstance(value, Mapping)
