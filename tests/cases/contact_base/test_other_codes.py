"""Codes beside the main one: each is held against the law under the rules that it declares."""

from dataclasses import replace

import pytest

from harness.cases.contact.limits import Scan, measured_scan
from harness.cases.contact.motion import followed
from harness.cases.contact.report import codes_over_parameter
from harness.cases.registry import get_case
from harness.cases.verification import Study
from harness.comparison.verdicts import Verdict, missing_from
from harness.comparison.verification import Findings
from harness.engines.contract import Engine
from harness.engines.output import Output
from harness.engines.registry import DEFAULT
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


class Main(Code):
    """The same under the name of the engine that is verified by default."""

    name = DEFAULT


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
    case.other_submodels, case.invariant, case.scan = (), (), replace(kind.scan, families=())
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


def test_the_command_that_repeats_a_case_names_the_code():
    case, _, found = compared(OWN, OWN, {"linear_history"})
    (section,) = case.display.sections(found, Findings("oblique"), {})
    (cell,) = section.cells
    (only, run) = (text for _, text in cell.commands[:2])
    assert only == "dem-harness verify --only oblique/linear_history/wall --engine code"
    assert run.startswith("dem-harness run oblique --engine code --set ")
    assert section.tables == ()


def test_a_code_that_does_not_follow_what_it_declares_fails():
    _, _, found = compared({}, OWN, {"linear_history"})
    assert Verdict.FAIL in {check.verdict for check in found.checks}


def test_a_law_that_a_code_cannot_state_is_not_tested_with_the_reason():
    _, code, found = compared(OWN, OWN, {"mindlin"})
    (row,) = found.checks
    assert row.verdict is Verdict.NOT_TESTED
    assert row.note == "its springs takes normal = hooke, not hertz"
    assert code.jobs == []


def test_what_was_run_as_the_main_engine_is_not_run_again():
    case, code, _ = compared(OWN, OWN, {"linear_history"}, Main)
    study, before = Study("quick"), len(code.jobs)
    case.other_submodels = [
        one for one in type(case).submodels if one.name == "linear_history_classic"
    ]
    main = case.verification.run(code, study)
    beside = case.verification.run(code, replace(study, role="other"))
    # each submodel once more, in as many runs as the first took to be decided
    assert len(code.jobs) == before + 2 * before
    assert {c.cell.submodel for c in beside.checks if c.cell} == {"linear_history_classic"}
    assert [one.trial.submodel for one in beside.evidence.refined] == [
        "linear_history",
        "linear_history_classic",
    ]
    assert main.evidence.refined == beside.evidence.refined[:1]


def test_any_other_main_engine_goes_through_all_submodels_at_once():
    case, code, _ = compared(OWN, OWN, {"linear_history"})
    study = Study("quick")
    case.other_submodels = [
        one for one in type(case).submodels if one.name == "linear_history_classic"
    ]
    found = case.verification.run(code, study)
    names = {"linear_history", "linear_history_classic"}
    assert {c.cell.submodel for c in found.checks if c.cell} == names
    assert missing_from(found.checks, case.verification.planned("quick", code)) == []
    assert len(case.verification.planned("quick", code)) == 2
    before = len(code.jobs)
    assert case.verification.run(code, replace(study, role="other")).checks == []
    assert len(code.jobs) == before


def test_the_figure_of_all_codes_shows_what_a_code_states_beside_its_own_rules():
    case, code, _ = compared(OWN, OWN, {"linear_history", "mindlin"})
    case.scan = Scan("tangential_ratio", "angle", (30.0, 60.0), (("mindlin",), ("linear_history",)))
    (one,) = measured_scan(case, code)
    assert (one.family, one.submodel) == (1, "linear_history")
    assert one.apart < 1e-9
    other = Main({}, Rules(**OWN), code.scenes)
    (wrong,) = measured_scan(case, other)
    assert wrong.measured == pytest.approx(one.measured)
    assert wrong.apart > 1e-5
    axes = codes_over_parameter(case, [("One", [one]), ("Other", [wrong])]).axes[0]
    told = [text.get_text() for text in axes.get_legend().get_texts()]
    assert told[0] == "linear history"
    assert told[1].startswith("One (")
    assert axes.get_xlabel() == "angle (deg)"


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
