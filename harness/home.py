"""Where things are kept: the cache, and the history of runs.

In the cache are results, environments of engines' releases (``releases``) and compiled kernels
(``numba``). Both are found in this order: the option ``--cache`` (the cache only), the
environment variable ``DEM_HARNESS_HOME`` (``cache`` and ``history.sqlite``
under that folder), else the places of the XDG base directory specification.
"""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

from harness.errors import RequestError

VARIABLE = "DEM_HARNESS_HOME"
NAME = "dem-harness"
KERNELS = "numba"
"""Folder of the cache for compiled kernels."""


@dataclass(frozen=True)
class Place:
    """A file or folder, and what named it; ``named_by`` is empty for a default place."""

    path: Path
    named_by: str = ""

    def refused(self, why: str) -> RequestError:
        """Return the error for a place that was asked for and cannot be used."""
        return RequestError(f"{self.named_by} {self.path}: cannot be used ({why})")


def cache_place(option: Path | None = None) -> Place:
    """Return the folder of the cache, the value of ``--cache`` first."""
    if option is not None:
        return Place(option, "--cache")
    named = os.environ.get(VARIABLE)
    if named:
        return Place(Path(named) / "cache", VARIABLE)
    return Place(_base("XDG_CACHE_HOME", ".cache") / NAME)


def history_place() -> Place:
    """Return the file of the history."""
    named = os.environ.get(VARIABLE)
    if named:
        return Place(Path(named) / "history.sqlite", VARIABLE)
    return Place(_base("XDG_DATA_HOME", ".local/share") / NAME / "history.sqlite")


def _base(variable: str, below_home: str) -> Path:
    """Return a base directory; the specification has relative values ignored."""
    value = os.environ.get(variable, "")
    return Path(value) if value.startswith("/") else Path("~").expanduser() / below_home
