"""Codes beside the main one: each is held against the law under the rules that it declares."""

import pytest

from harness.cases.contact.motion import followed
from harness.cases.registry import get_case
from harness.cases.verification import Study
from harness.comparison.verdicts import Verdict
from harness.engines.contract import Engine
from harness.engines.output import Output
from harness.engines.traits import ContactModel, Traits, stating
from harness.observables.provenance import Provenance
from harness.parameters.rules import Rules
from tests.cases.contact_base.perturbed import series_of

SPRINGS = {
    "normal": ("hooke",),
    "damping": ("velocity",),
    "tangential": ("linear_history", "linear_history_classic"),
    "interface": ("current",),
}
OWN = {"damping_in_cap": "sticking_only"}


def half_damped(values):
    return "" if values["tangential_damping"] == 0.5 else "has half of the damping along it"


class Code(Engine):
    """The integration of the law under some rules, in the place of a code."""

    name = "code"

    def __init__(self, declared, rules, scenes):
        model = ContactModel("springs", SPRINGS, declared, half_damped)
        self.traits = Traits("", (), "", contact_models=(model,))
        self.rules, self.scenes, self.jobs = rules, scenes, []

    @classmethod
    def states(cls, template):  # noqa: ARG003
        return True

    def identify(self):
        return Provenance("code", "1", (), "", "")

    def run(self, jobs):
        self.jobs += jobs
        return [self.output(self.scenes[frozenset(job.values.items())]) for job in jobs]

    def output(self, scene):
        motion = followed(scene, self.rules).motion
        return Output((), self.identify(), series_of(motion, scene))


def compared(declared, rules, submodels, engine=Code):
    """Return what a case finds in a code that declares some rules and follows others."""
    scenes, kind = {}, type(get_case("oblique"))

    class Told(kind):
        def job(self, parameters):
            job = super().job(parameters)
            scenes[frozenset(job.values.items())] = self.scene(parameters)
            return job

    case = Told()
    case.submodels = [one for one in kind.submodels if one.name in submodels]
    case.other_submodels, case.invariant = (), ()
    case.systems = {"wall": kind.systems["wall"]}
    code = engine(declared, Rules(**rules), scenes)
    return case, code, case.verification.run(code, Study("quick", role="other"))


def test_a_code_holds_under_its_own_rules_and_differs_from_others_as_predicted():
    _, _, found = compared(OWN, OWN, {"linear_history"})
    judged = [check for check in found.checks if check.judged]
    assert judged
    assert {check.verdict for check in judged} == {Verdict.PASS}
    (row,) = [check for check in found.checks if check.verdict is Verdict.FINDING]
    assert "damping_in_cap = sticking_only: moves it by" in row.note
    predicted = float(row.note.partition("moves it by ")[2].split()[0])
    assert predicted == pytest.approx(row.difference, rel=1e-2)
    assert abs(predicted) > 1e-4


def test_a_code_that_does_not_follow_what_it_declares_fails():
    _, _, found = compared({}, OWN, {"linear_history"})
    assert Verdict.FAIL in {check.verdict for check in found.checks}


def test_a_law_that_a_code_cannot_state_is_not_tested_with_the_reason():
    _, code, found = compared(OWN, OWN, {"mindlin"})
    (row,) = found.checks
    assert row.verdict is Verdict.NOT_TESTED
    assert row.note == "its springs takes normal = hooke, not hertz"
    assert code.jobs == []


def test_of_several_models_the_one_that_states_a_contact_is_taken_and_the_closest_says_why_not():
    springs = ContactModel("springs", SPRINGS, OWN, half_damped)
    hertz = ContactModel("solids", {"normal": ("hertz",)})
    law = {"normal": "hooke", "tangential": "linear_history", "damping": "velocity"}
    models = (springs, hertz)
    assert stating(models, {**law, "tangential_damping": 0.5}) == (springs, "")
    assert stating(models, {**law, "normal": "hertz"}) == (hertz, "")
    assert stating(models, {**law, "tangential_damping": 1.0})[1] == (
        "its springs has half of the damping along it"
    )
