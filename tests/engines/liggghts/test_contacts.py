"""Twisting springs in LIGGGHTS: the one that it has, and why it has no other."""

from dataclasses import replace

import pytest

from harness.cases.contact_base.study import verify_trials
from harness.cases.contract import Study
from harness.cases.registry import get_case
from harness.comparison.verdicts import Verdict
from harness.engines.contact_model import stating
from harness.engines.liggghts.contacts import CONTACTS

TWIST = get_case("twist")
TIED = [one for one in TWIST.beside if one.name == "twisting sds, linear_history, tied"]
TRIALS = {trial.system: trial for trial in TWIST.trials("default", TIED)}
WALL, FROZEN = (TRIALS[name].parameters for name in ("wall, spins", "frozen sphere, spins"))
# k_t R*^2 of two equal spheres: R* is half of that on a wall
QUARTER = WALL.twisting_stiffness / 4.0


@pytest.mark.parametrize(
    ("parameters", "changes", "said"),
    [
        (WALL, {}, ""),
        (FROZEN, {"twisting_stiffness": QUARTER}, ""),
        (FROZEN, {}, "of k_t R*^2 = 0.714286 N m, R* half the radius between two spheres"),
        (WALL, {"twisting_stiffness": QUARTER}, "k_t R*^2 = 2.85714 N m, R* the radius on a wall"),
        (WALL, {"twisting_damping": 0.1}, "without a dashpot only"),
        (FROZEN, {"radius_2": 0.02}, "with one R* only"),
        (FROZEN, {"planes": 1}, "with one R* only"),
        (WALL, {"rolling": "sds", "rolling_damping": 0.0}, "one limit for rolling and twisting"),
    ],
)
def test_a_twisting_spring_that_liggghts_does_not_have_is_named(parameters, changes, said):
    reason = stating(CONTACTS, {**TWIST.job(parameters).values, **changes})[1]
    assert said in reason
    assert bool(said) == bool(reason)
    assert "dashpot" not in reason or "twisting_damping" in changes


@pytest.mark.live
def test_the_twisting_spring_of_two_equal_spheres_holds(liggghts):
    stands = FROZEN.replace(twisting_stiffness=QUARTER, spin=0.01)
    trial = replace(TRIALS["frozen sphere, spins"], parameters=stands)
    checks = verify_trials(TWIST, liggghts, Study("quick"), [trial]).checks
    assert {check.verdict for check in checks} == {Verdict.PASS}
    # it is the spring that turns it back, not the limit
    assert all(check.tolerance <= 1e-6 for check in checks)
