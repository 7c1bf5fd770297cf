"""How a long verb tells how far it is."""

from __future__ import annotations

from collections.abc import Callable

Progress = Callable[[str, int, int], None]
"""Called with the name of a stage, the parts done, and the parts in all; from any thread."""


def silent(stage: str, done: int, total: int) -> None:
    """Tell nobody."""
