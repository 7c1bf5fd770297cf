"""Rolling and twisting springs in LIGGGHTS: which of its three states what, and why none does."""

from dataclasses import replace

import pytest

from harness.cases.contact.verification import verify_trials
from harness.cases.registry import get_case
from harness.cases.verification import Study
from harness.comparison.verdicts import Verdict
from harness.engines.liggghts.engine import CONTACTS
from harness.engines.traits import stating
from harness.parameters.rules import Rules

TWIST, ROLL, PATH = (get_case(one) for one in ("twist", "rolling-resistance", "prescribed-motion"))


def trial(case, submodel, system):
    """Return a trial of level default."""
    few = [one for one in (*case.submodels, *case.other_submodels) if one.name == submodel]
    (found,) = [one for one in case.trials("default", few) if one.system == system]
    return found


SPINS = "twisting sds, linear_history, tied"
WALL, FROZEN = (
    trial(TWIST, SPINS, system).parameters for system in ("wall, spins", "frozen sphere, spins")
)
ROLLS = trial(ROLL, "rolling sds, linear_history, tied", "wall, rolls").parameters
KN, MU_R, MU_W = 1e5, 0.05, 1e-4
ONE = KN * MU_W**2  # k_n mu_w^2
# k_t R*^2 of two equal spheres: R* is half of that on a wall
QUARTER = WALL.twisting_stiffness / 4.0


@pytest.mark.parametrize(
    ("case", "parameters", "changes", "model"),
    [
        (ROLL, ROLLS, {}, "epsd2"),
        (ROLL, ROLLS, {"rolling_damping": 0.5}, "epsd3"),
        (ROLL, ROLLS, {"rolling_stiffness": 2.25 * KN * MU_R**2}, "epsd"),
        (ROLL, ROLLS, {"rolling_stiffness": KN * MU_R**2}, "epsd3"),
        (ROLL, ROLLS, {"rolling": "none"}, "hooke/stiffness"),
        (TWIST, WALL, {}, "epsd2 torsionTorque"),
        (TWIST, WALL, {"twisting_damping": 1e-5}, "epsd3 torsionTorque"),
        (TWIST, WALL, {"twisting_stiffness": 2.25 * ONE}, "epsd torsionTorque"),
        (TWIST, WALL, {"twisting_stiffness": QUARTER}, "epsd3 torsionTorque"),
        (TWIST, FROZEN, {"twisting_stiffness": QUARTER}, "epsd2 torsionTorque"),
        (TWIST, FROZEN, {}, "epsd3 torsionTorque"),
        (TWIST, FROZEN, {"radius_2": 0.02}, "epsd3 torsionTorque"),
    ],
)
def test_each_of_the_three_states_the_springs_that_it_has(case, parameters, changes, model):
    found, why = stating(CONTACTS, {**case.job(parameters).values, **changes})
    assert (found.name, why) == (model, "")
    turning = model != "hooke/stiffness"
    assert Rules(**found.rules).wall_turning == ("levered" if turning else "spin")


@pytest.mark.parametrize(
    ("case", "parameters", "changes", "said"),
    [
        (ROLL, ROLLS, {"rolling_stiffness": 249.0}, "springs of k_n mu_r^2 = 250 N/m or more"),
        (ROLL, ROLLS, {"rolling_stiffness": 249.0}, "springs of 2.25 k_n mu_r^2 = 562.5 N/m"),
        (ROLL, ROLLS, {"rolling_stiffness": 249.0}, "its epsd2 has rolling springs of k_t = 28571"),
        (ROLL, ROLLS, {"rolling_damping": 0.1, "rolling_friction": 0.0}, "without a dashpot only"),
        (ROLL, ROLLS, {"twisting": "sds"}, "epsd2, epsd or epsd3 takes twisting = none, not sds"),
        (ROLL, ROLLS, {"normal": "hertz", "damping": "none"}, "hertz/stiffness takes tangential"),
        (TWIST, WALL, {"twisting_stiffness": 0.5 * ONE}, "k_t R*^2 = 2.85714 N m"),
        (TWIST, FROZEN, {"twisting_stiffness": 0.5 * ONE}, "k_t R*^2 = 0.714286 N m"),
        (TWIST, FROZEN, {"planes": 1, "twisting_stiffness": 0.5 * ONE}, "R* at a wall is another"),
        (TWIST, WALL, {"wx_1": 1.0}, "that resist rolling as well"),
        (TWIST, FROZEN, {"x_2": 1e-3}, "that resist rolling as well"),
        (TWIST, WALL, {"motion_1": "prescribed"}, "that resist rolling as well"),
    ],
)
def test_springs_that_liggghts_does_not_have_are_named(case, parameters, changes, said):
    assert said in stating(CONTACTS, {**case.job(parameters).values, **changes})[1]


@pytest.mark.live
@pytest.mark.parametrize(
    ("case", "submodel", "system", "changes", "width"),
    [
        # it is the spring that turns it back, not the limit
        (TWIST, SPINS, "frozen sphere, spins", {"twisting_stiffness": QUARTER, "spin": 1e-2}, 1e-6),
        (TWIST, SPINS, "frozen sphere, spins", {"spin": 5e-3, "twisting_damping": 1e-5}, 1e-6),
        (TWIST, SPINS, "wall, spins", {"twisting_stiffness": 2.25 * ONE, "spin": 1e-3}, 1e-6),
        (ROLL, "rolling sds, linear_history, of Ai", "wall, stands", {}, 1e-6),
        (ROLL, "rolling sds, linear_history", "wall, rolls", {}, 1e-4),
        (PATH, "rolling sds, linear_history, of Ai", "unequal spheres", {"friction": 9.0}, 1e-6),
        # rolling forth, it reaches its limit
        (PATH, "rolling sds, linear_history", "wall", {"friction": 9.0}, 1e-4),
    ],
)
def test_liggghts_holds_against_the_law_under_its_rules(
    liggghts, case, submodel, system, changes, width
):
    one = trial(case, submodel, system)
    told = replace(one, parameters=one.parameters.replace(**changes))
    checks = verify_trials(case, liggghts, Study("quick"), [told]).checks
    judged = [check for check in checks if check.judged]
    assert {check.verdict for check in judged} == {Verdict.PASS}
    assert all(check.tolerance <= width for check in judged)
