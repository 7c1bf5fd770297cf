"""The errors that the harness raises on purpose, one tree.

Each carries the exit status with which the command line ends. The texts are
one or two lines that name the option or file, the value, and what is allowed.
"""

from __future__ import annotations

import errno
from collections.abc import Mapping
from typing import Any, Self

FULL = (errno.ENOSPC, errno.EDQUOT)
"""Numbers of the system's errors that speak of a full disk."""


class HarnessError(Exception):
    """Base of all errors that the harness raises on purpose."""

    exit_status = 3


class RequestError(HarnessError, ValueError):
    """A request that cannot be met as it was put: bad option, value or file."""

    exit_status = 2


class FullDiskError(HarnessError):
    """What was asked for cannot be written: there is no space left."""

    exit_status = 4


def cannot_write(request: str, error: OSError) -> HarnessError:
    """Return the error of an option or file that cannot be written, and what the system says."""
    kind = FullDiskError if error.errno in FULL else RequestError
    return kind(f"{request}: {error.strerror or error}")


class CombinationError(RequestError):
    """Values that are allowed each by itself, but not together."""


class Unsupported(HarnessError):
    """A scene that an engine cannot state, with the reason in one line."""


class EngineError(HarnessError, RuntimeError):
    """An engine that could not be run, or died.

    ``kind`` is one word for the row of a report; ``log`` is what the engine left
    of the run that failed: script, parameters and log. Empty when it left none.
    """

    kind = "engine error"
    log = ""

    def __init_subclass__(cls, kind: str = "", **more: object) -> None:
        super().__init_subclass__(**more)
        cls.kind = kind or cls.kind

    def with_log(self, log: str) -> Self:
        """Return the error with this log."""
        self.log = log
        return self


class EngineMissingError(EngineError, kind="not found"):
    """An executable, library or package of the engine is not here."""


class EngineUnsupportedError(EngineMissingError, kind="not supported"):
    """A part of the engine's input that this build of it lacks, in the engine's own words."""


class EngineCrashError(EngineError, kind="crashed"):
    """The engine's process died (signal, abort, non-zero exit)."""


class EngineTimeoutError(EngineError, kind="out of time"):
    """The engine did not finish in the time it was given."""


class EngineMemoryError(EngineError, kind="out of memory"):
    """The engine asked for more memory than it was given."""


class EngineInputError(EngineError, kind="refused"):
    """The engine refused its input or lost an atom, and said so."""


class EngineOutputError(EngineError, kind="bad output"):
    """The engine ended without a complete, finite result."""


class EngineUndecidedError(EngineOutputError, kind="undecided"):
    """A run that ended well without the event that it waits for: ``values`` were measured.

    ``provenance``, ``seconds`` and ``ranks`` are those of the run.
    """

    provenance: Any = None
    seconds = 0.0
    ranks: int | None = None

    def __init__(self, message: str, values: Mapping[str, float]) -> None:
        super().__init__(message)
        self.values = values

    def __reduce__(self) -> tuple[Any, ...]:
        """Return how to make it again: a worker of another process sends it."""
        return type(self), (str(self), self.values), vars(self)


class EngineLostAtomsError(EngineInputError, kind="lost atoms"):
    """The engine lost an atom: the run left its box."""


class EngineNaNError(EngineOutputError, kind="NaN"):
    """The engine met or returned something that is not a number."""
