"""Closed forms of the contact cases, held against the independent integration of the law."""

import pytest

from harness.cases.contact_base.reference import followed
from harness.cases.registry import get_case
from harness.pair.integration import integrate
from harness.parameters.contact_rules import Rules

NAMES = ("head-on", "slip-to-roll", "incline-roll", "twist", "bounce")


def exact_trials(name):
    """Return the trials of a case that have a closed form."""
    case = get_case(name)
    trials = [trial for trial in case.trials("default") if case.closed_forms(trial.parameters)]
    return [pytest.param(case, one, id=f"{name}-{one.submodel}-{one.system}") for one in trials]


@pytest.mark.parametrize(("case", "trial"), [one for name in NAMES for one in exact_trials(name)])
def test_the_integration_of_the_law_gives_the_closed_forms(case, trial):
    parameters = trial.parameters.replace(steps_per_contact=1000)
    integrated = case.observed(parameters, followed(case.scene(parameters), Rules()).motion)
    for name, value in case.closed_forms(parameters).items():
        assert integrated[name] == pytest.approx(value, rel=2e-8, abs=1e-9), name


def test_cases_have_closed_forms_where_they_say_so():
    for name, least in zip(NAMES, (24, 8, 16, 4, 2), strict=True):
        assert len(exact_trials(name)) >= least, name


@pytest.mark.parametrize("preset", ["dmt", "jkr"])
@pytest.mark.parametrize("partner", ["wall", "sphere"])
def test_pull_off_is_where_the_integrated_contact_ends(preset, partner):
    case = get_case("pull-off")
    parameters = case.presets[preset].replace(partner=partner)
    (end,) = integrate(case.scene(parameters), Rules()).of_kind("ends")
    exact = case.closed_forms(parameters)
    assert -end.force == pytest.approx(exact["pull_off_force_N"], rel=1e-8)
    assert end.overlap / parameters.overlap == pytest.approx(exact["parting_ratio"], abs=1e-8)
