"""Contact cases in codes beside LAMMPS: their own rules hold in the limit of a small step."""

import math

import pytest

from harness.cases.contact.verification import verify_trials
from harness.cases.registry import all_cases, get_case
from harness.cases.verification import Study
from harness.comparison.known_defects import mark_known_defects
from harness.comparison.verdicts import Kind, Verdict
from harness.engines.registry import DEFAULT, engine_class, engine_names
from harness.errors import EngineMissingError, RequestError
from harness.store.baseline import known_defects
from tests.cases.contact_base.perturbed import Planted

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
        few = [s for s in (*case.submodels, *case.other_submodels) if s.name in submodels]
        own = type(case)()
        own.submodels, own.other_submodels = few, ()
        own.systems = dict(list(case.systems.items())[:2])
        found = own.verification.run(code, Study("quick"))
        judged = [check for check in found.checks if check.judged]
        assert {check.cell.submodel for check in judged} == submodels, name
        assert [check for check in judged if check.verdict is not Verdict.PASS] == []


@pytest.mark.slow
def test_no_row_fails_at_quick_in_any_engine_and_uncertainties_cover_what_is_left():
    """All contact cases in every engine that is here, at the shortest level."""
    rows = []
    contacts = [case for case in all_cases().values() if case.group == "contacts"]
    for name in engine_names():
        try:
            with engine_class(name)() as engine:
                versions = {name: engine.identify().engine_version}
                if name != DEFAULT and not engine.traits.contact_models:
                    continue
                for case in contacts:
                    found = case.verification.run(engine, Study("quick"))
                    rows += mark_known_defects(found.checks, known_defects(), versions)
        except EngineMissingError:
            continue
    rows = [one for one in rows if one.kind in (Kind.ANALYTIC, Kind.CROSS_CODE)]
    assert rows
    assert [one.name for one in rows if one.verdict is Verdict.FAIL] == []
    # defects apart: what is left of a value is its step's, and some units in the last place
    limits = [
        one for one in rows if one.verdict is Verdict.PASS and not math.isnan(one.uncertainty)
    ]
    covered = [
        abs(one.difference) <= one.uncertainty + 1e-9 * (1.0 + abs(one.expected)) for one in limits
    ]
    assert sum(covered) >= 0.95 * len(covered)
    assert all(one.uncertainty <= one.tolerance for one in limits)


def test_a_limit_in_which_a_force_jumps_is_refined_before_it_fails_and_hides_no_fault():
    def found(engine):
        case = get_case("oblique")
        trials = case.trials(
            "default", [s for s in case.other_submodels if s.name == "linear_history, 2/7"]
        )
        walls = [one for one in trials if one.system == "wall"]
        return verify_trials(case, engine, Study("default"), walls)

    try:
        with engine_class("liggghts")(workers=1) as inner:
            right, wrong = found(inner), found(Planted(inner, "friction", 1.01))
    except EngineMissingError as error:
        pytest.skip(str(error))
    assert {row.verdict for row in right.checks if row.judged} == {Verdict.PASS}
    (climbed,) = right.evidence.refined
    assert climbed.jumps
    assert climbed.finest.steps_per_contact > 1600
    assert Verdict.FAIL in {row.verdict for row in wrong.checks}
