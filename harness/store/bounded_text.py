"""Read a text file that a user names, up to a largest size: a device does not end."""

from __future__ import annotations

import errno
from pathlib import Path

LONGEST = 2**27
"""Bytes: the results of the longest verification are a hundredth of it."""


def bounded_text(path: Path, longest: int = LONGEST) -> str:
    """Return a file's text; raise OSError for one that is too long, UnicodeDecodeError."""
    with path.open("rb") as file:
        data = file.read(longest + 1)
    if len(data) > longest:
        raise OSError(errno.EFBIG, f"is longer than {longest} bytes")
    return data.decode("utf-8")
