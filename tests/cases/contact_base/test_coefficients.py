"""The standing test of all coefficients: each moved by a percent must turn a row.

Rows of limits alone, which the law is integrated for, no regression. The engine is the integration
of the law with the coefficient moved; a sample in LAMMPS shows that an engine's is seen as well.
"""

from dataclasses import replace

import pytest

from harness.cases.contact.verification import verify_trials
from harness.cases.registry import get_case
from harness.cases.verification import Study
from harness.comparison.verdicts import Kind, Verdict
from harness.engines.lammps.engine import Lammps
from tests.cases.contact_base.perturbed import (
    Planted,
    acts,
    along_normal,
    coefficients_of,
    contact_cases,
    rows_of,
    submodels_of,
    trials_of,
    unseen,
)

FAST = ["twisting sds, linear_history", "mdr, yield"]

QUICK = submodels_of("quick")
LONGER = [name for name in submodels_of("default") if name not in QUICK]


@pytest.mark.parametrize("submodel", FAST)
def test_a_percent_of_a_coefficient_turns_a_row(submodel):
    assert unseen(submodel, "quick") == set()


@pytest.mark.slow
@pytest.mark.parametrize("submodel", [name for name in QUICK if name not in FAST])
def test_a_percent_of_any_coefficient_turns_a_row_at_level_quick(submodel):
    # two materials go along a given path, which shows both ratios of Poisson, at level default only
    longer = {name for name in unseen(submodel, "quick") if name.startswith("partner_")}
    assert unseen(submodel, "quick") == longer
    assert not longer or not longer & unseen(submodel, "default")


@pytest.mark.slow
@pytest.mark.parametrize("submodel", LONGER)
def test_a_percent_of_any_coefficient_of_the_other_laws_turns_a_row_at_level_default(submodel):
    assert unseen(submodel, "default") == set()


def test_every_submodel_of_every_contact_case_is_among_them():
    names = {
        one.name for case in contact_cases() for one in (*case.submodels, *case.other_submodels)
    }
    assert names == {*QUICK, *LONGER}


def test_the_integration_itself_turns_no_row():
    for case, trial in trials_of("rolling sds, mindlin", "quick"):
        rows = rows_of(case, trial, "friction", "quick", factor=1.0)
        assert {row.verdict for row in rows} == {Verdict.PASS}


@pytest.mark.parametrize(
    ("submodel", "level", "coefficient"),
    [
        ("mdr, yield, bulk", "default", "yield_stress"),
        ("old hertz/history, clipped", "default", "friction"),
        ("rolling sds, linear_history, elastic", "quick", "tangential_damping"),
    ],
)
def test_a_coefficient_that_has_no_effect_changes_no_value(submodel, level, coefficient):
    case, trial = trials_of(submodel, level)[0]
    if coefficient == "tangential_damping":
        trial = replace(trial, parameters=trial.parameters.replace(tangential_damping=0.5))
    law = trial.parameters.law
    assert coefficient in coefficients_of(law)
    assert not acts(law, coefficient) or along_normal(case.scene(trial.parameters))
    rows = rows_of(case, trial, coefficient, level, factor=1.5)
    assert {row.verdict for row in rows} == {Verdict.PASS}


@pytest.fixture(scope="module")
def lammps():
    with Lammps(workers=1) as engine:
        yield engine


@pytest.mark.live
@pytest.mark.usefixtures("lammps_here")
@pytest.mark.parametrize(
    ("submodel", "coefficient", "factor", "cases"),
    [
        ("twisting sds, linear_history", "twisting_stiffness", 2.0, ("twist", "prescribed-motion")),
        ("twisting sds, linear_history", "twisting_damping", 3.0, ("twist", "prescribed-motion")),
        ("twisting sds, linear_history", "twisting_stiffness", 1.01, ("prescribed-motion",)),
        ("twisting sds, mindlin", "twisting_damping", 1.01, ("twist",)),
        ("rolling sds, linear_history", "rolling_damping", 1.01, ("prescribed-motion",)),
        ("mdr, yield", "yield_stress", 1.01, ("head-on",)),
    ],
)
def test_lammps_with_another_coefficient_turns_a_row(lammps, submodel, coefficient, factor, cases):
    for case in map(get_case, cases):
        own = [one for one in case.submodels if one.name == submodel]
        trials = [*case.trials("quick", own)]
        told = []
        for engine in (lammps, Planted(lammps, coefficient, factor)):
            found = verify_trials(case, engine, Study("quick"), trials).checks
            told.append({row.verdict for row in found if row.judged})
            assert Kind.REGRESSION not in {row.kind for row in found}
        assert told[0] == {Verdict.PASS}
        assert Verdict.FAIL in told[1]
