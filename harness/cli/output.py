"""What a command prints on stdout."""

from __future__ import annotations

import contextlib
import shutil
import sys
import textwrap
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Literal

from harness.report.plain import json_text, one_line

if TYPE_CHECKING:
    import pandas as pd

GAP = 2
"""Blanks between two columns."""


def print_json(record: Mapping[str, Any]) -> None:
    """Print one JSON object, strict JSON: what is not finite becomes null."""
    print(json_text(record), end="")


def print_json_rows(head: Mapping[str, Any], name: str, rows: Iterable[Mapping[str, Any]]) -> None:
    """Print one JSON object as :func:`print_json` does, with ``rows`` under ``name`` at its end.

    Each row is printed as it comes: the memory that this takes is that of one row.
    """
    text = json_text({**head, name: []}).rstrip("\n")
    before, _, after = text.rpartition("]")
    end = ""
    print(before, end="")
    for row in rows:
        one = json_text(row).rstrip("\n").replace("\n", "\n    ")
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
    shown = {key: value for key, value in record.items() if _is_short(value)}
    print_columns(
        [
            (key, f"{value:.8g}" if isinstance(value, float) else str(value))
            for key, value in shown.items()
        ]
    )


def print_columns(lines: Sequence[Sequence[str]], right: Collection[str] = ()) -> None:
    """Print aligned columns; those that the first line names in ``right`` end at their right.

    On a terminal that is narrower, cells but the first of a line go on below; a pipe gets whole
    lines.
    """
    lines = [[one_line(cell) for cell in line] for line in lines]
    turns: list[Literal["left", "right"]] = ["right" if n in right else "left" for n in lines[0]]
    widths = [max(map(len, column)) for column in zip(*lines, strict=True)]
    if sys.stdout.isatty() and sum(widths) + GAP * (len(widths) - 1) > terminal_width():
        _print_folded(lines, turns)
        return
    marks = ("<" if turn == "left" else ">" for turn in turns)
    form = (GAP * " ").join(f"{{:{m}{w}}}" for m, w in zip(marks, widths, strict=True))
    print("\n".join(form.format(*line).rstrip() for line in lines))


def _print_folded(
    lines: Iterable[Sequence[str]], turns: Sequence[Literal["left", "right"]]
) -> None:
    """Print columns that share the width of the terminal."""
    from rich.console import Console
    from rich.table import Table

    table = Table(box=None, show_header=False, padding=(0, GAP, 0, 0), pad_edge=False)
    for number, turn in enumerate(turns):
        table.add_column(justify=turn, overflow="fold", no_wrap=number == 0)
    for line in lines:
        table.add_row(*line)
    Console(markup=False, highlight=False, emoji=False).print(table)


def print_frame(frame: pd.DataFrame, digits: int) -> None:
    """Print a table, its numbers to so many digits.

    On a terminal that is narrower, columns go on below; a pipe gets whole lines.
    """
    width = terminal_width() if sys.stdout.isatty() else None
    form = f"{{:.{digits}g}}".format
    print(frame.to_string(index=False, float_format=form, na_rep="-", line_width=width))


def print_line(text: str, *, indent: int = 0) -> None:
    """Print text after ``indent`` blanks: wrapped on a terminal, on one line in a pipe."""
    if sys.stdout.isatty():
        print_wrapped(text, indent=indent)
    else:
        print(" " * indent + one_line(text))


def terminal_width() -> int:
    """Return the columns of the terminal; 80 where there is none."""
    return shutil.get_terminal_size().columns


def print_wrapped(text: str, *, indent: int = 0) -> None:
    """Print printable text on lines that fit the terminal, the first after ``indent`` blanks."""
    width = min(terminal_width(), 120)
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
