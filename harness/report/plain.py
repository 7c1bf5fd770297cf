"""Make text safe for a terminal, Markdown and file names, and records for strict JSON."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Mapping
from typing import Any

_ESCAPES = re.compile(
    r"\x1b\[[0-?]*[ -/]*[@-~]"  # colours, moves of the cursor
    r"|\x1b[\]PX^_].*?(?:\x07|\x1b\\|$)"  # titles, links, other strings
    r"|\x1b[ -/]*[0-~]",
    re.DOTALL,
)
_CONTROLS = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u202a-\u202e\u2066-\u2069\ud800-\udfff]")
"""Control characters but tab and newline, marks that turn the direction of writing, and halves
of characters, which no encoding writes."""

_MARKUP = re.compile(r"([\\`*\[\]|])")
_NAME = re.compile(r"[^A-Za-z0-9._+=-]+")
LONGEST_NAME = 100


def printable(text: str) -> str:
    """Return text without escape sequences, other control characters replaced by ``?``."""
    return _CONTROLS.sub("?", _ESCAPES.sub("", text.replace("\r\n", "\n")))


def one_line(text: str) -> str:
    """Return printable text on one line."""
    return " ".join(printable(text).split())


def markdown_text(text: str) -> str:
    """Return text as Markdown shows it: no markup, no table cell, no tag, no mention."""
    text = one_line(text).replace("&", "&amp;").replace("<", "&lt;")
    return _MARKUP.sub(r"\\\1", text).replace("@", "@\u200b")


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
