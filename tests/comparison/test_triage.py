import pytest

from harness.comparison.parting import Parting
from harness.comparison.triage import Triage, of_error, of_parting
from harness.errors import (
    EngineCrashError,
    EngineInputError,
    EngineLostAtomsError,
    EngineMemoryError,
    EngineMissingError,
    EngineNaNError,
    EngineOutputError,
    EngineTimeoutError,
)


@pytest.mark.parametrize(
    ("error", "said"),
    [
        (EngineTimeoutError, "out of time"),
        (EngineMemoryError, "out of memory"),
        (EngineNaNError, "NaN"),
        (EngineInputError, "wrong input: refused"),
        (EngineLostAtomsError, "engine error: lost atoms"),
        (EngineCrashError, "engine error: crashed"),
        (EngineMissingError, "engine error: not found"),
        (EngineOutputError, "engine error: bad output"),
    ],
)
def test_every_error_has_its_class(error, said):
    assert of_error(error("why")) == said


def test_parting_says_when():
    late = Parting("x_m", 0.45, 0.44, from_first_step=False, stays=True)
    assert of_parting(late) == "diverged late: x_m, at 0.45 s (within its band up to 0.44 s)"
    back = Parting("x_m", 0.45, 0.44, from_first_step=False, stays=False)
    assert of_parting(back).endswith("; it came back")
    first = Parting("x_m", 1e-3, 0.0, from_first_step=True, stays=True)
    assert of_parting(first).startswith(Triage.FIRST_STEP)
