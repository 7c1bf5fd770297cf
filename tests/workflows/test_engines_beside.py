"""What a case is expected to take an engine is said beforehand, also where nothing draws bars."""

from contextlib import nullcontext
from dataclasses import replace

import pytest

from harness.cases.drop.case import CASE, DropCase
from harness.cases.verification import Study, Verification
from harness.comparison.verification import Findings
from harness.engines.cost import in_words
from harness.workflows import verification
from harness.workflows.engine_status import EngineSelection
from harness.workflows.verification import MainRun, OtherEngines
from tests.engine_doubles import Twin

PARAMETERS = CASE.presets["fall"]


class Falls(DropCase):
    """Two falls."""

    name = "falls"
    qualifies = False

    @property
    def verification(self):
        return TwoFalls(self)


class TwoFalls(Verification):
    def run(self, engine, study):
        assert study.role == "other"
        engine.run([self.case.job(PARAMETERS)] * 2)
        return Findings("falls", engine.name)


def of_seconds(per_step):
    """Return an engine that says what its steps took."""
    return Twin(
        change_output=lambda job, output: replace(output, seconds=per_step * job.values["steps"])
    )


@pytest.mark.parametrize(("per_step", "said"), [(1e-3, True), (1e-6, False)])
def test_a_case_is_announced_by_the_steps_of_the_engines_before(
    monkeypatch, capsys, per_step, said
):
    opened = {"twin": of_seconds(1e-9), "again": of_seconds(per_step)}
    opened["again"].name, opened["again"].workers = "again", 1
    monkeypatch.setattr(verification, "engine_class", lambda _: Twin)
    study = Study("quick", open_engine=lambda name: nullcontext(opened[name]))
    OtherEngines(EngineSelection(tuple(opened)), [Falls()], study, None).run()
    seconds = 2 * PARAMETERS.steps * per_step
    told = capsys.readouterr().err
    expected = in_words(float(f"{seconds:.2g}"))
    assert (f"dem-harness: again: about {expected} for the falls" in told) == said
    assert "twin: about" not in told


def test_an_engine_that_is_named_by_its_class_has_the_name_that_it_gives_itself():
    """As ``--engines module:Class``; its inputs are asked of the class."""
    name = "tests.engine_doubles:Twin"
    study = Study("quick", open_engine=lambda _: nullcontext(Twin()))
    found = OtherEngines(EngineSelection((name,)), [Falls()], study, None).run()
    assert [one.summary for one in found.declared] == ["qualified"]
    assert found.kinds == {"twin": Twin}
    run = MainRun([], study)
    assert run.scripts(replace(found, findings={"twin": {"drop": Findings("drop", "twin")}})) == {}
