"""Contacts that resist rolling and twisting: what Yade can be told of them, and Yade itself."""

import ast
import math
from types import SimpleNamespace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from harness.cases.contact import motion as template
from harness.cases.contact.motion import followed, motion_of, powers_of, rules_of
from harness.cases.contact.submodels import ROLLING_UNDAMPED, TURNING_UNDAMPED, TWISTING_UNDAMPED
from harness.cases.contact.verification import verify_trials
from harness.cases.registry import get_case
from harness.cases.verification import Study
from harness.comparison.verdicts import Verdict
from harness.engines.yade.engine import Yade

MOVED = get_case("prescribed-motion")
(TURNS,) = TURNING_UNDAMPED
WALL = MOVED.default.replace(**TURNS.law)
PAIR = WALL.replace(partner="sphere", partner_radius=0.02)
HELD = {"rolling_friction": 10.0, "twisting_friction": 1.0, "friction": 1e3}
"""Nothing slides."""


def test_springs_that_turn_have_an_error_of_first_order():
    slides = MOVED.default.replace(tangential="none", friction=None, tangential_damping=None)
    assert powers_of(MOVED.job(WALL), Yade.traits) == (1.0,)
    assert powers_of(MOVED.job(slides), Yade.traits) == ()


def stated_by_the_script(job):
    """Return the materials of two bodies in contact, as the script makes them, without Yade."""
    text = Yade.script(template.TEMPLATE).text
    tree = ast.parse(text)
    (own,) = [n for n in tree.body if isinstance(n, ast.ClassDef) and n.name == "Turning"]
    known = {"math": math, "CohFrictMat": SimpleNamespace}
    exec(compile(ast.Module([own], []), "contacts.py", "exec"), known)
    bodies = 2 if "radius_2" in job.values else 1
    told = SimpleNamespace(**{"radius_2": 0.0, **job.values, "bodies": bodies})
    spheres, walls = known["Turning"](told).materials()
    return (spheres[0], spheres[-1] if bodies > 1 else walls[0])


def contact_of(first, second, radii):
    """Return what Ip2_CohFrictMat_CohFrictMat_CohFrictPhys makes of two materials.

    As its documentation and CohesiveFrictionalContactLaw.cpp have it: harmonic means of young times
    radius, of that times poisson, and of the alphas; the smaller one of eta times radius.
    """
    bodies = [*zip((first, second), radii, strict=True)]

    def mean(*values):
        return 2.0 / sum(1.0 / value for value in values)

    k_t = mean(*(one.young * r * one.poisson for one, r in bodies))
    return {
        "kn": mean(*(one.young * r for one, r in bodies)),
        "ks": k_t,
        "kr": radii[0] * radii[1] * k_t * mean(first.alphaKr, second.alphaKr),
        "ktw": radii[0] * radii[1] * k_t * mean(first.alphaKtw, second.alphaKtw),
        "roll": min(one.etaRoll * r for one, r in bodies),
        "twist": min(one.etaTwist * r for one, r in bodies),
        "friction": math.tan(min(first.frictionAngle, second.frictionAngle)),
    }


@pytest.mark.parametrize("parameters", [WALL, PAIR, PAIR.replace(partner_radius=0.01)])
def test_materials_of_a_contact_make_the_coefficients_of_the_law(parameters):
    # a box has the radius of the sphere that touches it
    radii = (parameters.radius, parameters.second_radius if parameters is not WALL else 0.01)
    found = contact_of(*stated_by_the_script(MOVED.job(parameters)), radii)
    reduced = parameters.reduced_radius
    assert found == pytest.approx(
        {
            "kn": parameters.normal_stiffness,
            "ks": parameters.tangential_stiffness,
            "kr": parameters.rolling_stiffness * reduced**2,
            "ktw": parameters.twisting_stiffness,
            "roll": parameters.rolling_friction * reduced,
            "twist": parameters.twisting_friction,
            "friction": parameters.friction,
        },
        rel=1e-14,
    )


def test_a_resistance_that_is_left_out_has_neither_stiffness_nor_limit():
    for (one,), kind in ((ROLLING_UNDAMPED, "Ktw"), (TWISTING_UNDAMPED, "Kr")):
        materials = stated_by_the_script(MOVED.job(MOVED.default.replace(**one.law)))
        other = {"Ktw": "etaTwist", "Kr": "etaRoll"}[kind]
        assert {getattr(m, f"alpha{kind}") for m in materials} == {0.0}
        assert {getattr(m, other) for m in materials} == {0.0}


def moved(yade, *asked):
    """Return the motions of parameters in Yade, with those of the law under its rules."""
    outputs = yade.run([MOVED.job(one) for one in asked])
    rules = rules_of(MOVED.job(asked[0]), yade.traits)
    scenes = [MOVED.scene(one) for one in asked]
    found = [motion_of(*pair) for pair in zip(outputs, scenes, strict=True)]
    return [*zip(found, scenes, strict=True)], rules


@pytest.mark.live
@pytest.mark.slow
def test_torques_are_those_that_the_coefficients_ask_for(yade):
    """Elastic and at the limit, by hand: what is left of a torque without that of the friction."""
    asked = [one.replace(**held) for one in (WALL, PAIR) for held in (HELD, {"turn": 0.05})]
    runs, _ = moved(yade, *asked)
    for one, (motion, _) in zip(asked, runs, strict=True):
        ends = [-3, -1]  # a piece has a sample in its middle, too
        x, left = motion.position[ends], (1.0 - one.lift) * one.overlap
        normal = x[:, 0] - x[:, 1] if one.partner == "sphere" else np.tile([0.0, 0.0, 1.0], (2, 1))
        normal /= np.linalg.norm(normal, axis=1)[:, None]
        arm = -(one.radius - 0.5 * left) * normal  # to half the overlap
        moment = motion.torque[ends, 0] - np.cross(arm, motion.force[ends, 0])
        reduced, load = one.reduced_radius, one.normal_stiffness * left
        expected = (
            -one.rolling_stiffness * reduced**2 * one.turn,
            -one.twisting_stiffness * one.turn,
        )
        if one.turn == 0.05:
            expected = -one.rolling_friction * reduced * load, -one.twisting_friction * load
        # the sheared pair turns about axes that are 7e-4 off its normal
        # Yade's mean spin has turned the springs of rolling forth and back: of the angle's square
        turned = 0.5 * one.twist_forth  # the mean of the sphere and the wall at rest
        rel = 1e-7 + turned**2 if one.partner == "wall" else 1e-3
        # rolled; then twisted
        assert_allclose((moment[0, 0], moment[1] @ normal[1]), expected, rtol=rel)


@pytest.mark.live
@pytest.mark.slow
@pytest.mark.parametrize("base", [WALL, PAIR], ids=["wall", "pair"])
def test_the_mean_spin_turns_the_springs_of_rolling(yade, base):
    one = base.replace(**HELD, turn=0.3)
    rungs = [one.replace(steps_per_contact=n) for n in (100, 200, 400)]
    runs, rules = moved(yade, *rungs)
    errors, others = [], []
    for motion, scene in runs:
        for kept, told in ((errors, rules), (others, rules.replace(spring_spin="none"))):
            expected = followed(scene, told).motion.torque[-1, 0, 0]
            kept.append(float(motion.torque[-1, 0, 0] / expected - 1.0))
    # an angle a a step lengthens the spring by a^2 / 2: of n steps that turn by half of 0.3 in all
    assert_allclose(errors, [0.15**2 / 2.0 / n for n in (100, 200, 400)], rtol=0.02)
    assert max(others) < -0.01


@pytest.mark.live
@pytest.mark.slow
@pytest.mark.parametrize(
    "coefficient",
    ["rolling_stiffness", "rolling_friction", "twisting_stiffness", "twisting_friction"],
)
def test_a_coefficient_that_is_off_by_a_percent_is_seen(yade, coefficient):
    class Planted(Yade):
        def settings(self, job):
            return {**super().settings(job), coefficient: 1.01 * job.values[coefficient]}

    free = "friction" in coefficient
    told = {"turn": 0.05} if free else HELD
    trials = [t for t in MOVED.trials("default", [TURNS]) if t.system == "wall"]
    trials = [type(t)(t.submodel, t.system, t.parameters.replace(**told)) for t in trials]
    with Planted(workers=1) as planted:
        wrong = verify_trials(MOVED, planted, Study("default"), trials).checks
    right = verify_trials(MOVED, yade, Study("default"), trials).checks
    kind = coefficient.partition("_")[0]
    failed = {c.name.rpartition(": ")[2] for c in wrong if c.verdict is Verdict.FAIL}
    shown = {"rolling_ratio", "held_ratio"} if kind == "rolling" else {"twisting_ratio"}
    assert shown <= failed
    assert all(name.startswith((kind, "held")) for name in failed)
    assert Verdict.FAIL not in {check.verdict for check in right}
