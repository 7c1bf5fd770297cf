"""Contacts with friction in codes beside LAMMPS: what each refuses, and how each holds."""

import pytest

from harness.cases.contact.submodels import ROLLING_UNDAMPED, TURNING_UNDAMPED, TWISTING_UNDAMPED
from harness.cases.contact.verification import verify_trials
from harness.cases.registry import get_case
from harness.cases.verification import Study
from harness.comparison.verdicts import Verdict
from harness.engines.registry import engine_class
from harness.engines.traits import stating
from harness.engines.yade.engine import TURNING

OBLIQUE, MOVED = get_case("oblique"), get_case("prescribed-motion")
WALL, PAIR = OBLIQUE.default, OBLIQUE.default.replace(partner="sphere")
SPRINGS = WALL.replace(damping="velocity", damping_coefficient=2.0)
TURNED = MOVED.default.replace(**TURNING_UNDAMPED[0].law)
CLIPPED = {"damping": "velocity", "clipped": "yes"}
HERTZ = {"normal": "hertz", "tangential": "mindlin"}
STATED = {
    "kratos": (OBLIQUE, WALL),
    "yade": (MOVED, TURNED),
}
"""A contact that each states, with its case; what follows are changes of it."""

REFUSED = {
    "kratos": [
        ({"damping": "velocity"}, "never attracts"),
        (
            CLIPPED | {"tangential_stiffness": 2e6},
            "DEM_D_Linear_Custom_Constants has a dashpot along the surface",
        ),
        (CLIPPED, "dashpot along the surface that is tied"),
        ({"tangential": "linear_nohistory"}, "takes tangential = none or linear_history, not"),
        (HERTZ, "mindlin_rescale/force, not mindlin"),
        ({"normal": "jkr"}, "takes normal = hooke, hertz or dmt, not jkr"),
        ({"normal": "dmt"}, "DMT takes tangential = none, not "),
        (CLIPPED | {"tangential": "none"}, ""),
        ({"normal": "hertz", "tangential": "mindlin_rescale/force"}, ""),
    ],
    "yade": [
        ({"rolling": "none", "rolling_damping": 0.5}, ""),
        ({"tangential": "linear_history_classic"}, ""),
        (CLIPPED, f"{TURNING} takes damping = none, not velocity"),
        ({"rolling_damping": 0.5}, f"{TURNING} has rolling springs without a dashpot only"),
        ({"twisting_damping": 0.5}, f"{TURNING} has twisting springs without a dashpot only"),
        ({"rolling": "none", "twisting_damping": 0.5}, "twisting springs without a dashpot only"),
        (
            {"tangential": "none"},
            "takes tangential = linear_history or linear_history_classic, not none",
        ),
        ({"twisting": "marshall"}, f"{TURNING} takes twisting = none or sds, not marshall"),
        ({"radius_2": 0.01}, "of one stiffness and limit only: of a sphere on walls, or of two"),
        ({"normal": "jkr"}, f"{TURNING} or Law2_ScGeom_MindlinPhys_Mindlin takes normal = hooke"),
    ],
}


@pytest.mark.parametrize(
    ("code", "changes", "said"),
    [(code, *row) for code, rows in REFUSED.items() for row in [({}, ""), *rows]],
)
def test_what_a_code_cannot_state_is_named(code, changes, said):
    case, parameters = STATED[code]
    values = {**case.job(parameters).values, **changes}
    reason = stating(engine_class(code).traits.contact_models, values)[1]
    assert said in reason
    assert bool(said) == bool(reason)


@pytest.mark.parametrize(
    ("code", "changes", "model"),
    [
        ("kratos", {"tangential_stiffness": 2 / 7}, "DEM_D_Linear_viscous_Coulomb"),
        ("kratos", {"tangential_stiffness": 1.333}, "DEM_D_Linear_viscous_Coulomb"),
        ("kratos", {"tangential_stiffness": 4 / 3}, "DEM_D_Linear_Custom_Constants"),
        ("kratos", {"tangential_stiffness": 10.0}, "DEM_D_Linear_Custom_Constants"),
        ("yade", {}, TURNING),
        ("yade", {"twisting": "none"}, TURNING),
        ("yade", {"rolling": "none"}, TURNING),
        ("yade", {"rolling": "none", "twisting": "none"}, "Law2_ScGeom_ViscElPhys_Basic"),
    ],
)
def test_the_model_that_states_a_contact(code, changes, model):
    case, parameters = STATED[code]
    if ratio := changes.get("tangential_stiffness"):
        stiff = parameters.replace(tangential_stiffness=ratio * parameters.normal_stiffness)
        values = case.job(stiff).values
    else:
        values = {**case.job(parameters).values, **changes}
    found, why = stating(engine_class(code).traits.contact_models, values)
    assert (found.name, why) == (model, "")


ROLLS, TWISTS, TURNS = (
    one.name for (one,) in (ROLLING_UNDAMPED, TWISTING_UNDAMPED, TURNING_UNDAMPED)
)
HELD = {
    "kratos": [
        ("oblique", "linear_history, elastic", "unequal spheres", 1.0),
        ("prescribed-motion", "linear_history, elastic", "two spheres, turned", 1.0),
        ("oblique", "linear_history, 2/7, elastic", "unequal spheres", 1.0),
        ("oblique", "mindlin_rescale/force, elastic", "wall", 1.0),
        ("spin", "mindlin_rescale/force, elastic", "frozen sphere", 1.0),
        ("head-on", "hooke, velocity, clipped", "frozen sphere", 1.0),
        ("pull-off", "dmt", "unequal spheres", 1.0),
        ("stacked", "hertz, coeff_restitution, clipped", "unequal, between plates", 1.0),
        ("prescribed-motion", "mindlin_rescale/force, elastic", "two spheres, turned", 1.0),
    ],
    "yade": [
        ("prescribed-motion", TWISTS, "two spheres, turned", 1e-6),
        ("prescribed-motion", TURNS, "unequal spheres", 1e-4),
        ("rolling-resistance", ROLLS, "wall, stands", 1e-4),
        ("twist", TWISTS, "frozen sphere, spins", 1e-4),
        ("oblique", ROLLS, "unequal spheres", 1e-4),
    ],
}
"""Case, submodel, system, and the widest tolerance that a row may have, of codes by name."""


@pytest.mark.live
@pytest.mark.slow
@pytest.mark.parametrize(
    ("code", "name", "submodel", "system", "widest"),
    [(code, *row) for code, rows in HELD.items() for row in rows],
    indirect=["code"],
)
def test_a_code_holds_against_the_law_under_its_rules(code, name, submodel, system, widest):
    case = get_case(name)
    submodels = [one for one in (*case.submodels, *case.other_submodels) if one.name == submodel]
    trials = [one for one in case.trials("default", submodels) if one.system == system]
    found = verify_trials(case, code, Study("default"), trials)
    judged = [check for check in found.checks if check.judged]
    assert {check.verdict for check in judged} == {Verdict.PASS}
    assert all(check.tolerance <= widest for check in judged)
