"""What drops leave for the report."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from harness.cases.drop.result import DropRun

if TYPE_CHECKING:
    from harness.cases.drop.checks import DropTest


@dataclass(frozen=True)
class DropEvidence:
    """The runs of an engine's drops with the tests that they were made for."""

    who: str
    made: tuple[tuple[DropTest, DropRun], ...]
