import pytest

from harness.comparison.series import Divergence
from harness.comparison.verdicts import Triage, of_divergence, of_error
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


def test_divergence_says_when():
    late = Divergence("x_m", 0.45, 0.44, from_first_step=False, stays=True)
    assert of_divergence(late) == "diverged late: x_m, at 0.45 s (within its band up to 0.44 s)"
    back = Divergence("x_m", 0.45, 0.44, from_first_step=False, stays=False)
    assert of_divergence(back).endswith("; it came back")
    first = Divergence("x_m", 1e-3, 0.0, from_first_step=True, stays=True)
    assert of_divergence(first).startswith(Triage.FIRST_STEP)
