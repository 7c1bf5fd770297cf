"""Contact cases in codes beside LAMMPS: their own rules hold in the limit of a small step."""

import pytest

from harness.cases.contract import Study
from harness.cases.registry import get_case
from harness.comparison.verdicts import Verdict
from harness.engines.registry import engine_class
from harness.errors import EngineMissingError, RequestError

pytestmark = pytest.mark.live

STATED = {
    "liggghts": {
        "head-on": {"hooke, velocity", "hertz, viscoelastic, clipped"},
        "oblique": {"linear_history", "mindlin, coeff_restitution, clipped"},
        "rolling-resistance": {"rolling sds, linear_history, tied"},
        "twist": {"twisting sds, linear_history, tied"},
        "prescribed-motion": {"linear_nohistory", "mindlin"},
    },
    "yade": {
        "head-on": {"hooke, velocity, clipped", "dmt"},
        "oblique": {"linear_history, clipped", "mindlin/force, coeff_restitution, clipped"},
        "rolling-resistance": {"rolling sds, mindlin/force, elastic"},
        "prescribed-motion": {"linear_history, elastic", "rolling sds, mindlin/force, elastic"},
    },
}


SLOW = {"yade"}
CODES = [pytest.param(n, marks=pytest.mark.slow) if n in SLOW else n for n in STATED]


@pytest.fixture(scope="module", params=CODES)
def code(request):
    kind = engine_class(request.param)
    try:
        with kind(workers=1) as engine:
            engine.identify()
            yield engine
    except (EngineMissingError, RequestError) as error:
        pytest.skip(str(error))


def test_every_case_holds_under_the_rules_that_a_code_declares(code):
    for name, submodels in STATED[code.name].items():
        case = get_case(name)
        few = [s for s in (*case.submodels, *case.beside) if s.name in submodels]
        own = type(case)()
        own.submodels, own.beside = few, ()
        own.systems = dict(list(case.systems.items())[:2])
        found = own.verify(code, Study("quick"))
        judged = [check for check in found.checks if check.judged]
        assert {check.cell.submodel for check in judged} == submodels, name
        assert [check for check in judged if check.verdict is not Verdict.PASS] == []
