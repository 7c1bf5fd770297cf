"""Of what class a failure is, so that the next thing to look at is known."""

from __future__ import annotations

from enum import StrEnum

from harness.comparison.divergence import Divergence
from harness.errors import (
    EngineError,
    EngineInputError,
    EngineLostAtomsError,
    EngineMemoryError,
    EngineNaNError,
    EngineTimeoutError,
)


class Triage(StrEnum):
    """The class of a failure. The text of a check's triage opens with one of these."""

    FIRST_STEP = "diverged from the first step"
    LATE = "diverged late"
    OUT_OF_TOLERANCE = "out of tolerance"
    WRONG_INPUT = "wrong input"
    ENGINE_ERROR = "engine error"
    NAN = "NaN"
    OUT_OF_TIME = "out of time"
    OUT_OF_MEMORY = "out of memory"
    HARNESS = "harness error"
    MISSING = "missing"
    NOT_TESTED = "not tested"


_BY_ERROR: tuple[tuple[type[EngineError], Triage], ...] = (
    (EngineTimeoutError, Triage.OUT_OF_TIME),
    (EngineMemoryError, Triage.OUT_OF_MEMORY),
    (EngineNaNError, Triage.NAN),
    # an atom that is lost was put in rightly
    (EngineLostAtomsError, Triage.ENGINE_ERROR),
    (EngineInputError, Triage.WRONG_INPUT),
)


def of_error(error: EngineError) -> str:
    """Return the class of an engine's error, with its kind where the class does not say it."""
    triage = next((t for kind, t in _BY_ERROR if isinstance(error, kind)), Triage.ENGINE_ERROR)
    return triage if error.kind == triage else f"{triage}: {error.kind}"


def of_divergence(divergence: Divergence) -> str:
    """Return the class of a series that left its reference, with the time."""
    if divergence.from_first_step:
        return f"{Triage.FIRST_STEP}: {divergence.column}, at {divergence.time:.6g} s"
    last = f"within its band up to {divergence.last_inside:.6g} s"
    back = "" if divergence.stays else "; it came back"
    return f"{Triage.LATE}: {divergence.column}, at {divergence.time:.6g} s ({last}){back}"
