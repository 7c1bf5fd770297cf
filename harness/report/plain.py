"""Make text safe for a terminal, Markdown and file names, and records for strict JSON."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, TextIO

if TYPE_CHECKING:
    from pathlib import Path

    from pandas import DataFrame

_ESCAPES = re.compile(
    r"\x1b\[[0-?]*[ -/]*[@-~]"  # colours, moves of the cursor
    r"|\x1b[\]PX^_].*?(?:\x07|\x1b\\|$)"  # titles, links, other strings
    r"|\x1b[ -/]*[0-~]",
    re.DOTALL,
)
_CONTROLS = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u202a-\u202e\u2066-\u2069\ud800-\udfff]")
"""Control characters but tab and newline, marks that turn the direction of writing, and halves
of characters, which no encoding writes."""

_MARKUP = re.compile(r"([\\`*\[\]|]|(?<![^\W_])_|_(?![^\W_])|^(?:[-+#](?= )|\d+(?=[.)] )|>))")
"""What Markdown takes for markup: within a line, and at its beginning a list, heading or quote."""
FORMULA = ("=", "+", "-", "@", "\t", "\r")
"""Beginnings of a cell that spreadsheets take for a formula, and run."""

LONGEST_WORD, LONGEST_LINE = 250, 600
"""Characters of a word and a line of an error that are shown in full: paths are as long."""

_NAME = re.compile(r"[^A-Za-z0-9._+=-]+")
LONGEST_NAME = 100


def printable(text: str) -> str:
    """Return text without escape sequences, other control characters replaced by ``?``."""
    return _CONTROLS.sub("?", _ESCAPES.sub("", text.replace("\r\n", "\n")))


def one_line(text: str) -> str:
    """Return printable text on one line."""
    return " ".join(printable(text).split())


def shortened(text: str) -> str:
    """Return an error's text with long words and lines cut in their middle: a value may be huge."""
    words = re.sub(rf"\S{{{LONGEST_WORD},}}", lambda word: _cut(word[0], 100, 40), text)
    return "\n".join(
        line if len(line) <= LONGEST_LINE else _cut(line, 350, 200) for line in words.split("\n")
    )


def _cut(text: str, first: int, last: int) -> str:
    return f"{text[:first]}...({len(text)} characters)...{text[-last:]}"


def csv_cell(value: Any) -> Any:
    """Return a cell that no spreadsheet takes for a formula: a text that begins as one is quoted.

    Numbers stay numbers, also those that are written as text.
    """
    if not (isinstance(value, str) and value.startswith(FORMULA)):
        return value
    try:
        float(value)
    except ValueError:
        return f"'{value}"
    return value


def write_csv(frame: DataFrame, file: Path | TextIO, **options: Any) -> None:
    """Write a table as CSV without its index; texts of others, such as a version, run nowhere.

    ``options`` are those of ``DataFrame.to_csv``.
    """
    texts = [name for name, kind in frame.dtypes.items() if kind.kind not in "biufcmM"]
    safe = frame.assign(**{str(name): frame[name].map(csv_cell) for name in texts})
    safe.to_csv(file, index=False, **options)


def markdown_text(text: str) -> str:
    """Return text as Markdown shows it: no markup, no table cell, no tag, no mention."""
    text = one_line(text).replace("&", "&amp;").replace("<", "&lt;")
    return _MARKUP.sub(_escaped, text).replace("@", "@\u200b")


def _escaped(markup: re.Match[str]) -> str:
    text = markup[0]
    return f"{text}\\" if text.isdigit() else f"\\{text}"  # of a list the dot behind its number


def safe_path(name: str) -> str:
    """Return a relative path of plain names: below its folder whatever the name says."""
    parts = (_NAME.sub("-", part).strip(".-")[:LONGEST_NAME] for part in name.split("/"))
    return "/".join(part for part in parts if part) or "unnamed"


def json_text(record: Any) -> str:
    """Return a record as the text of a JSON file, strict JSON: what is not finite becomes null."""
    return json.dumps(finite(record), indent=2, ensure_ascii=False) + "\n"


def finite(value: Any) -> Any:
    """Return a JSON value with NaN and infinities as None."""
    if isinstance(value, Mapping):
        return {key: finite(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [finite(item) for item in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
