"""Contact cases in codes beside LAMMPS: their own rules hold in the limit of a small step."""

from dataclasses import replace

import pytest

from harness.cases.contact_base.study import verify_trials
from harness.cases.contact_base.tolerances import WHY_JUMPS
from harness.cases.contract import Study
from harness.cases.registry import get_case
from harness.comparison.verdicts import Verdict
from harness.engines.contract import Engine
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
        "rolling-resistance": {
            "rolling sds, mindlin/force, elastic",
            "rolling sds, linear_history, elastic",
        },
        "twist": {"twisting sds, linear_history, elastic"},
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


class Planted(Engine):
    """An engine that is told a coefficient other than it is asked for."""

    name, title = "liggghts", "Planted"

    def __init__(self, inner, coefficient, factor):
        self.inner, self.traits = inner, inner.traits
        self.change = coefficient, factor

    def identify(self):
        return self.inner.identify()

    def refuses(self, job):
        return self.inner.refuses(job)

    def run(self, jobs):
        name, factor = self.change
        changed = [{**job.values, name: job.values[name] * factor} for job in jobs]
        told = zip(jobs, changed, strict=True)
        return self.inner.run([replace(job, values=values) for job, values in told])


def springs(name, engine, *systems):
    """Return a case, and what it finds of linear springs with friction in some systems."""
    case = get_case(name)
    submodels = [one for one in case.submodels if one.name == "linear_history"]
    trials = [one for one in case.trials("default", submodels) if one.system in systems]
    return case, verify_trials(case, engine, Study("default"), trials)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("coefficient", "shows"),
    [
        ("friction", {"tangential_ratio", "spin_ratio", "impulse_ratio"}),
        ("tangential_stiffness", {"tangential_ratio", "spin_ratio"}),
        ("normal_stiffness", {"normal_restitution", "tangential_ratio", "spin_ratio"}),
        ("damping_coefficient", {"normal_restitution"}),
        ("tangential_damping", set()),
    ],
)
def test_the_width_of_a_jump_hides_no_fault(coefficient, shows):
    """A percent is a twentieth of the smallest defect that is known of any code."""
    try:
        with engine_class("liggghts")(workers=1) as inner:
            case, found = springs("oblique", Planted(inner, coefficient, 1.01), "wall")
            planted = Planted(inner, coefficient, 1.003)
            _, along_a_path = springs("prescribed-motion", planted, "wall", "two spheres, turned")
    except EngineMissingError as error:
        pytest.skip(str(error))
    rows = {check.name.rpartition(": ")[2]: check for check in found.checks if check.judged}
    wide = {name for name, row in rows.items() if row.why == WHY_JUMPS}
    assert wide == {"tangential_ratio", "spin_ratio", "impulse_ratio"}
    (climbed,) = found.evidence.climbed
    other = climbed.finest.replace(**{coefficient: 1.01 * getattr(climbed.finest, coefficient)})
    moved = case.expected(other, climbed.rules)
    # what moves a value by more than the width and its jitter, at most as large, fails
    seen = {
        name
        for name, row in rows.items()
        if abs(moved[name].value - row.expected) > 2.0 * row.tolerance
    }
    failed = {name for name, row in rows.items() if row.verdict is Verdict.FAIL}
    assert seen <= failed == shows
    # along a path that is given the forces have no jitter: a third of it, in every coefficient
    assert Verdict.FAIL in {row.verdict for row in along_a_path.checks}
