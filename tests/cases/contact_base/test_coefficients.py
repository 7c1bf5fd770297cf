"""The standing test of all coefficients: each moved by a percent must turn a row.

Rows of limits alone, which the law is integrated for, no regression. The engine is the integration
of the law with the coefficient moved; a sample in LAMMPS shows that an engine's is seen as well.
"""

import pytest

from harness.comparison.verdicts import Verdict
from tests.cases.contact_base.perturbed import (
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


def test_the_integration_itself_turns_no_row():
    for case, trial in trials_of("rolling sds, mindlin", "quick"):
        rows = rows_of(case, trial, "friction", "quick", factor=1.0)
        assert {row.verdict for row in rows} == {Verdict.PASS}
