"""Contacts with friction: what Kratos can be told of them, and Kratos itself."""

import pytest

from harness.cases.contact.verification import verify_trials
from harness.cases.registry import get_case
from harness.cases.verification import Study
from harness.comparison.verdicts import Verdict
from harness.engines.kratos.engine import CONTACTS
from harness.engines.traits import stating

OBLIQUE = get_case("oblique")


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"tangential_stiffness": 2e6}, ""),
        ({"damping": "velocity"}, "never attracts"),
        (
            {"damping": "velocity", "clipped": "yes", "tangential_stiffness": 2e6},
            "DEM_D_Linear_Custom_Constants has a dashpot along the surface",
        ),
        ({"damping": "velocity", "clipped": "yes"}, "dashpot along the surface that is tied"),
        ({"tangential": "linear_nohistory"}, "takes tangential = none or linear_history, not"),
        ({"normal": "hertz", "tangential": "mindlin"}, "mindlin_rescale/force, not mindlin"),
        ({"normal": "jkr"}, "takes normal = hooke, hertz or dmt, not jkr"),
        ({"normal": "dmt"}, "DMT takes tangential = none, not "),
        ({}, ""),
        ({"damping": "velocity", "clipped": "yes", "tangential": "none"}, ""),
        ({"normal": "hertz", "tangential": "mindlin_rescale/force"}, ""),
    ],
)
def test_what_kratos_cannot_be_told_is_named(changes, said):
    reason = stating(CONTACTS, {**OBLIQUE.job(OBLIQUE.default).values, **changes})[1]
    assert said in reason
    assert bool(said) == bool(reason)


@pytest.mark.parametrize(
    ("ratio", "law"),
    [
        (2.0 / 7.0, "DEM_D_Linear_viscous_Coulomb"),
        (1.333, "DEM_D_Linear_viscous_Coulomb"),
        (4.0 / 3.0, "DEM_D_Linear_Custom_Constants"),
        (10.0, "DEM_D_Linear_Custom_Constants"),
    ],
)
def test_springs_that_no_material_has_are_told(ratio, law):
    told = OBLIQUE.default.replace(tangential_stiffness=ratio * OBLIQUE.default.normal_stiffness)
    model, why = stating(CONTACTS, OBLIQUE.job(told).values)
    assert (model.name, why) == (law, "")


@pytest.mark.live
@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "submodel", "system"),
    [
        ("oblique", "linear_history, elastic", "unequal spheres"),
        ("slip-to-roll", "linear_history, elastic", "wall"),
        ("prescribed-motion", "linear_history, elastic", "two spheres, turned"),
        ("oblique", "linear_history, 2/7, elastic", "unequal spheres"),
        ("oblique", "mindlin_rescale/force, elastic", "wall"),
        ("spin", "mindlin_rescale/force, elastic", "frozen sphere"),
        ("head-on", "hooke, velocity, clipped", "frozen sphere"),
        ("head-on", "dmt", "wall"),
        ("pull-off", "dmt", "unequal spheres"),
        ("stacked", "hertz, coeff_restitution, clipped", "unequal, between plates"),
        ("prescribed-motion", "linear_history, 2/7, elastic", "two spheres"),
        ("prescribed-motion", "mindlin_rescale/force, elastic", "two spheres, turned"),
    ],
)
def test_kratos_holds_against_the_law_under_its_rules(kratos, name, submodel, system):
    case = get_case(name)
    submodels = [one for one in (*case.submodels, *case.other_submodels) if one.name == submodel]
    trials = [one for one in case.trials("default", submodels) if one.system == system]
    found = verify_trials(case, kratos, Study("default"), trials)
    judged = {check.verdict for check in found.checks} - {Verdict.FINDING}
    assert judged == {Verdict.PASS}
