"""The errors that the harness raises on purpose, one tree.

Each carries the exit status with which the command line ends. The texts are one or two lines that
name the option or file, the value, and the allowed ones.
"""

from __future__ import annotations

import errno
from collections.abc import Mapping
from typing import Any, Self

FULL = (errno.ENOSPC, errno.EDQUOT)  # numbers of the system's errors for a full disk


class HarnessError(Exception):
    """Base of all errors that the harness raises on purpose."""

    exit_status = 3


class RequestError(HarnessError, ValueError):
    """A wrong request: bad option, value or file."""

    exit_status = 2


class FullDiskError(HarnessError):
    """A file that cannot be written: the disk is full."""

    exit_status = 4


class CombinationError(RequestError):
    """Values that are allowed each by itself, but not together."""


class BrokenCaseError(HarnessError):
    """A case of another package that cannot be used, in one line that names package and case."""


class Unsupported(HarnessError):
    """A scene that an engine cannot express, with the reason in one line."""


class EngineError(HarnessError, RuntimeError):
    """An engine that could not be run, or died."""

    kind = "engine error"  # words for the row of a report
    log = ""  # script, parameters and log of the failed run

    def __init_subclass__(cls, kind: str = "", **more: object) -> None:
        super().__init_subclass__(**more)
        cls.kind = kind or cls.kind

    def with_log(self, log: str) -> Self:
        """Return the error with this log."""
        self.log = log
        return self


class EngineMissingError(EngineError, kind="not found"):
    """An executable, library or package of the engine is missing."""


class EngineUnsupportedError(EngineMissingError, kind="not supported"):
    """A part of the engine's input that this build of it lacks, in the engine's own words."""


class EngineCrashError(EngineError, kind="crashed"):
    """The engine's process died (signal, abort, non-zero exit)."""


class EngineTimeoutError(EngineError, kind="out of time"):
    """The engine did not finish in its time."""


class EngineMemoryError(EngineError, kind="out of memory"):
    """The engine needed more memory than it may have."""


class EngineInputError(EngineError, kind="refused"):
    """The engine refused its input or lost an atom, with its message."""


class EngineOutputError(EngineError, kind="bad output"):
    """The engine ended without a complete, finite result."""


class EngineUndecidedError(EngineOutputError, kind="undecided"):
    """A run that ended well without the event that it waits for: ``values`` were measured."""

    provenance: Any = None  # of the run
    seconds = 0.0  # that the run took

    def __init__(self, message: str, values: Mapping[str, float] | None = None) -> None:
        super().__init__(message)  # pickled for a worker: the message, then all attributes
        self.values = values or {}


class EngineLostAtomsError(EngineInputError, kind="lost atoms"):
    """The engine lost an atom, which moved out of its box."""


class EngineNaNError(EngineOutputError, kind="NaN"):
    """The engine met or returned a value that is not a number."""
