"""An engine that integrates under another rule than it declares is told which one."""

from dataclasses import replace

import pytest

from harness.cases.contact.motion import followed
from harness.cases.contact.verification import verify_trials
from harness.cases.registry import get_case
from harness.cases.verification import Study
from harness.comparison.known_defects import mark_known_defects, with_single_rules
from harness.comparison.verdicts import Verdict
from harness.engines.output import Output
from harness.parameters.rules import Rules
from tests.cases.contact_base.perturbed import Perturbed, series_of

MINDLIN, LINEAR = "mindlin, elastic", "linear_history"


class OtherRules(Perturbed):
    """Says that it computes as LAMMPS does, and computes under other rules."""

    def __init__(self, case, coefficient="friction", factor=1.0, **rules):
        super().__init__(case, coefficient, factor)
        self.rules = Rules(**rules)

    def output(self, job):
        scene = self.scenes[frozenset(job.values.items())]
        if self.factor != 1.0:
            return super().output(job)
        motion = followed(scene, self.rules).motion
        return Output((), self.identify(), series_of(motion, scene))


def noted(case, submodel, system, **planted):
    """Return the rows of a trial as a verification has them, those that fail by their notes."""
    engine = OtherRules(get_case(case), **planted)
    every = engine.case.trials("default", (*engine.case.submodels, *engine.case.other_submodels))
    trials = [one for one in every if (one.submodel, one.system) == (submodel, system)]
    assert trials
    raw = verify_trials(engine.case, engine, Study("quick"), trials).checks
    rows = with_single_rules(mark_known_defects(raw, [], {}), raw)
    return {row.note for row in rows if row.verdict is Verdict.FAIL}


@pytest.mark.parametrize(
    ("case", "submodel", "system", "rule", "word"),
    [
        ("oblique", LINEAR, "wall", "wall_lever", "height"),
        ("prescribed-motion", MINDLIN, "two spheres", "mindlin_factor", "2/3"),
        ("head-on", "hertz, coeff_restitution", "wall", "hertz_restitution", "linear"),
    ],
)
def test_the_rule_that_an_engine_follows_is_named(case, submodel, system, rule, word):
    notes = noted(case, submodel, system, **{rule: word})
    assert notes == {f"holds under {rule} = {word}"}


def test_rules_that_are_one_between_equal_spheres_are_all_named():
    notes = noted("oblique", MINDLIN, "two spheres", velocity_lever="share")
    levers = ("contact_point", "share", "circle")
    assert notes == {
        "holds under " + ", or under ".join(f"velocity_lever = {word}" for word in levers)
    }


def test_a_wrong_coefficient_is_no_rule():
    notes = noted("oblique", LINEAR, "wall", factor=1.05)
    assert notes == {"no single rule of the harness reproduces it"}


def test_a_rule_that_other_quantities_contradict_is_not_said_to_hold():
    engine = OtherRules(get_case("oblique"), wall_lever="height")
    place = (LINEAR, "wall")
    trials = [one for one in engine.case.trials("default") if (one.submodel, one.system) == place]
    raw = verify_trials(engine.case, engine, Study("quick"), trials).checks
    failing = [row for row in raw if row.verdict is Verdict.FAIL]
    other = next(row for row in raw if row.predict is not None and row is not failing[0])
    moved = replace(other, value=other.value + 1e3 * other.tolerance)
    changed = [moved if row is other else row for row in raw]
    rows = with_single_rules(mark_known_defects(changed, [], {}), changed)
    first = next(row for row in rows if row.name == failing[0].name)
    assert first.note.startswith("this value alone holds under wall_lever = height")
