"""What the levels of a contact case go through."""

import pytest

from harness.cases.contact.contact_case import LONGER, PAIRS, ContactCase
from harness.cases.contact.transformations import EQUAL, SYSTEMS, chosen
from harness.cases.registry import all_cases

CASES = [case for case in all_cases().values() if isinstance(case, ContactCase)]


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_at_the_shortest_level_submodels_take_turns_in_the_systems(case):
    trials = [*case.trials("quick")]
    short_ones = [one for one in case.submodels if one.quick]
    assert {trial.submodel for trial in trials} == {one.name for one in short_ones}
    short = [system for system in case.systems if system not in LONGER]
    mixes = PAIRS if case.two_materials_of else ()
    assert {trial.system for trial in trials} == {*short, *mixes}
    for submodel in short_ones:
        systems = [trial.system for trial in trials if trial.submodel == submodel.name]
        # walls and pairs of the earlier interface share no code
        old = submodel.law.get("interface") == "old"
        both = [system for system in systems if system in PAIRS]
        assert both == (PAIRS if submodel.name == case.two_materials_of else []), submodel.name
        alone = [system for system in systems if system not in PAIRS]
        always = [name for name in short if name in case.every_level]
        assert [name for name in alone if name in always] == always
        taken = len(alone) - len(always)
        assert alone == short if old else taken == 1, submodel.name


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_what_a_level_runs_a_longer_one_runs_as_well(case):
    levels = [
        {(trial.submodel, trial.system) for trial in case.trials(level)}
        for level in ("quick", "default", "full")
    ]
    assert levels[0] <= levels[1] <= levels[2]


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_the_shortest_level_turns_each_named_submodel_in_each_of_its_systems(case):
    all_told = [(trial.submodel, trial.system) for trial in chosen(case, "quick")]
    carried = [(name, EQUAL) for name in case.by_defaults]
    told = [one for one in all_told if one not in carried]
    assert len(all_told) == len(told) + len(carried)
    assert told == [
        (submodel.name, system)
        for submodel in case.submodels
        for system in case.systems
        if submodel in case.invariant and submodel.quick and system in SYSTEMS["quick"]
    ]
