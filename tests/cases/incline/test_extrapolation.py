import pytest

from harness.cases.incline.angle import CriticalAngle, extrapolate
from harness.cases.incline.levels import FULL_LADDER, QUICK_LADDER, Ladder
from harness.cases.incline.system import Incline
from harness.errors import RequestError
from harness.observables.provenance import Provenance
from harness.parameters.law import PLASTIC

TRUTH = 10.2


def _angle(case, truth=TRUTH):
    overlap = case.static_overlap
    value = truth - 40.0 * overlap - 100 * overlap**1.5 - 30 * overlap / case.steps_per_contact
    return CriticalAngle(value, 1e-5, 1e-6, "passage", case, Provenance("none", "0"))


@pytest.mark.parametrize("ladder", [QUICK_LADDER, Ladder(), FULL_LADDER])
def test_the_limit_of_a_synthetic_ladder(ladder):
    found = extrapolate([_angle(case) for case in ladder.cases(Incline(contact=PLASTIC))])
    assert abs(found.value_deg - TRUTH) <= found.uncertainty_deg
    assert found.value_deg == pytest.approx(TRUTH, abs=2e-5)
    assert len(found.at_stiffness) == len(ladder.factors)


@pytest.mark.parametrize(
    ("changes", "word"),
    [
        ({"factors": (1.0, 2.0, 3.0)}, "factors"),
        ({"factors": (1.0, 2.0, 3.0, -4.0)}, "factors"),
        ({"steps_per_contact": (50.0, 100.0)}, "steps_per_contact"),
    ],
)
def test_a_ladder_with_too_few_rungs_is_refused(changes, word):
    with pytest.raises(RequestError, match=word):
        Ladder(**changes)
