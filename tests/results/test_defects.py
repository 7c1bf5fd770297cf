"""Entries of known defects: where they act, what is refused, and what a switch is in a scene."""

import dataclasses
import math

import numpy as np
import pytest

from harness.errors import RequestError
from harness.model.conventions import Faults, Rules
from harness.model.scene import Scene, Segment, Wall, sphere
from harness.results.defects import VALUES, KnownDefect, Trial, explanation, first_difference
from harness.results.rows import Row
from harness.solvers import reference
from tests.solvers.reference.scenes import HERTZ, HOOKE, JKR, LINEAR, MINDLIN, ROLLS, R, impact

ENTRY = {"name": "weak", "engine": "code", "cases": ["head-on"], "laws": ["hertz, *"],
         "systems": ["wall"], "since": "28 Mar 2023", "until": "22 Jul 2025",
         "cause": "the dashpot has half of its mass", "upstream": "issue 1"}  # fmt: skip
WEAK = KnownDefect(**ENTRY, faults={"tsuji_effective_mass": True})
OTHER = KnownDefect(**{**ENTRY, "name": "other"}, faults={"marshall_without_radius": True})
TSUJI = HERTZ.replace(damping="tsuji", restitution=0.5)
SCENE = impact(TSUJI, (0.1, 0.0, -0.3), 50, every=5)


# ---- where it acts

ROW = Row(case="head-on", setup="hertz, tsuji, wall", quantity="v", engine="code",
          version="2 Aug 2023")  # fmt: skip
ANYWHERE = {"laws": ["*"], "systems": ["*"]}
TWO_RANKS = {"variations": ["two ranks*"]}


@pytest.mark.parametrize(
    ("entry", "fields", "acts"),
    [
        ({}, {}, True),
        ({}, {"version": "28 Mar 2023", "check": "restarted"}, True),
        *(({}, {"version": version}, True) for version in (
            "22 Jul 2025 - Update 4", "2023.8.2.3.1")),
        *(({}, {"version": version}, False) for version in (
            "23 Jun 2022", "10 Dec 2025", "unknown")),
        *(({}, {"setup": setup}, False) for setup in (
            "hooke, wall", "hertz, tsuji, bowl", "hertz, tsuji, wall, stands", "plastic")),
        ({}, {"engine": "lammps"}, False),
        ({}, {"case": "bounce"}, False),
        (ANYWHERE, {"setup": "plastic"}, True),
        (TWO_RANKS, {"check": ""}, False),
        (TWO_RANKS, {"check": "two ranks, newton on"}, True),
        (TWO_RANKS, {"check": "periodic"}, False),
        ({"until": "22 Jul 2025 Update 0"}, {"version": "22 Jul 2025"}, True),
        ({"until": "22 Jul 2025 Update 0"}, {"version": "22 Jul 2025 - Update 1"}, False),
    ],
)  # fmt: skip
def test_rows_and_releases_in_which_it_acts(entry, fields, acts):
    row = dataclasses.replace(ROW, **fields)
    assert KnownDefect(**ENTRY | entry, error="NaN").concerns(row) is acts


# ---- entries that are refused


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        ({}, "needs one of"),
        ({"fit": "setup_torque", "error": "NaN"}, "needs one of"),
        ({"largest": 10.0, "error": "NaN"}, "largest: goes with undetermined alone"),
        ({"fit": "spring"}, "fit = 'spring': must be"),
        ({"faults": {"tsuji": True}}, "tsuji: no such parameter of Faults"),
        ({"faults": {"tsuji_effective_mass": "half"}}, "tsuji_effective_mass = 'half': must be"),
        ({"faults": {"tsuji_effective_mass": "thin_skin"}}, "= 'thin_skin': must be"),
        ({"law": {"clipped": 3}}, r"law\.clipped = 3: must be true or false"),
        ({"rules": {"wall_lever": "arm"}}, "wall_lever = 'arm': must be 'radius'"),
        ({"law": {"friction": [1]}}, r"law\.friction = \[1\]: must be a number"),
        ({"law": {"normal": "hertzian"}}, "'hertzian': must be a number or one of hooke"),
        ({"submodels": ["hertz"], "error": "NaN"}, "submodels"),
    ],
)
def test_an_entry_without_a_meaning_is_refused(wrong, words):
    with pytest.raises(RequestError, match=words):
        KnownDefect(**ENTRY, **wrong)


# ---- values of a scene, by second routes


def test_values_by_name_against_numbers():
    material = {"youngs_modulus": 1e8, "poisson_ratio": 0.3}
    scene = impact(MINDLIN.replace(**material), (0.0, 0.0, -0.1))
    right, wrong = 1e8 / (2 * 0.91), 1e8 / (2 * 0.7)
    assert VALUES["normal_modulus_factor"](scene) == pytest.approx(wrong / right)
    right, wrong = 8 * (1e8 / 4) / (1.7 * 1.3), 1e8 / 4 * 1.7 * 1.3
    assert VALUES["shear_modulus_factor"](scene) == pytest.approx(wrong / right)
    # one material twice: 1 / (2 (1 - nu^2)) of G*, as the entry says
    assert VALUES["mixed_shear_factor"](scene) == pytest.approx(1 / (2 * 0.91))
    assert VALUES["mixed_normal_stiffness"](scene) == pytest.approx(4 / 3 * 1e8 / (2 * 0.91))
    assert VALUES["mixed_tangential_stiffness"](scene) == pytest.approx(8 * 1e8 / 4 / 1.7 / 1.3)
    plain = impact(HOOKE, (0.0, 0.0, -0.1))  # no material, no moduli
    for name in ("normal_modulus_factor", "shear_modulus_factor", "mixed_shear_factor"):
        assert VALUES[name](plain) == 1.0
    assert [VALUES["mixed_damping"](one) for one in (plain, SCENE)] == ["none", "velocity"]


def test_the_skin_is_half_of_the_longest_neck():
    """By the tension as a function of the contact radius, whose largest value ends a contact."""
    scene = impact(JKR.replace(surface_energy=0.01), (0.0, 0.0, -0.1), partner="sphere")
    modulus, radius, gamma = scene.law.moduli[0], 0.5 * R, 0.01
    a = min((a * 1e-7 for a in range(1, 4000)), key=lambda a: 4 * modulus * a**3 / (3 * radius)
            - math.sqrt(16 * math.pi * gamma * modulus * a**3))  # fmt: skip
    neck = math.sqrt(4 * math.pi * gamma * a / modulus) - a**2 / radius
    assert VALUES["thin_skin"](scene) == pytest.approx(0.5 * neck, rel=1e-2)


def test_the_surface_of_a_turning_cylinder():
    turning = Wall(shape="cylinder", radius=0.05, hollow=True, spin=(0.0, 0.0, 4.0))
    scene = SCENE.replace(walls=(Wall(), turning))
    assert VALUES["shear_along_x"](scene) == (-0.2, 0.0, 0.0)


# ---- a run is explained


def moving(scene, *, rules=None, **faults):
    return reference.run(scene, rules, Faults(**faults))


def trial(observed, scene=SCENE, rules=None):
    """Return a run whose rows hold where no sample differs."""
    declared = rules or Rules()

    def holds(motions):
        return all(first_difference(s, observed, m) == len(observed) for s, m in motions.items())

    return Trial({scene: declared}, holds, observed)


def test_of_defects_that_act_together_all_that_are_needed_are_returned():
    law = HERTZ.replace(damping="tsuji", restitution=0.5, tangential="mindlin", friction=0.3)
    scene = impact(law, (0.1, 0.0, -0.3), 50, every=5, spin=(3.0, -5.0, 8.0))
    soft = KnownDefect(**{**ENTRY, "name": "soft"}, faults={"shear_factor": 0.5})
    observed = moving(scene, tsuji_effective_mass=True, shear_factor=0.5)
    assert explanation((soft, WEAK, OTHER), trial(observed, scene)) == (soft, WEAK)
    assert explanation((soft, OTHER), trial(observed, scene)) == ()


def test_a_law_may_be_switched():
    scene = impact(LINEAR, (0.1, 0.0, -0.3), 50, every=5)
    defect = KnownDefect(**ENTRY, law={"tangential_damping": 0.0, "friction": "tangential_damping"})
    other = scene.replace(law=LINEAR.replace(tangential_damping=0.0, friction=0.5))
    assert explanation((defect,), trial(moving(other), scene)) == (defect,)


def test_a_switch_that_leaves_no_motion_explains_nothing():
    broken = KnownDefect(**ENTRY, law={"youngs_modulus": -1.0})
    assert explanation((broken,), trial(moving(SCENE))) == ()


# ---- unknowns

SPIN = (3.0, -5.0, 8.0)
ROLLING = impact(LINEAR.replace(**ROLLS), (0.1, 0.0, -0.3), 60, every=3, spin=SPIN)
REVERSED = KnownDefect(**ENTRY, fit="torsion_reversed_at")
TORQUE = KnownDefect(**ENTRY, fit="setup_torque")


@pytest.mark.parametrize("steps", [(12,), (11, 12), (12, 21, 30)])
def test_reversals_are_fitted_and_all_other_samples_agree(steps):
    observed = moving(ROLLING, torsion_reversed_at=steps)
    assert explanation((REVERSED,), trial(observed, ROLLING)) == (REVERSED,)
    observed.angular_velocity[-1] *= 1.0 + 1e-6
    assert explanation((REVERSED,), trial(observed, ROLLING)) == ()


@pytest.mark.parametrize("off", [0.0, 1e-6])
def test_each_side_of_a_boundary_may_turn_a_copy_of_the_spring_of_its_own(off):
    """Until both bodies are on one side again, where one copy is left."""
    bodies = tuple(sphere(R, 2500.0, position=(0.0, 0.0, z)) for z in (0.99 * R, -R))
    turns = Segment(steps=40, velocities=((0.0, 0.0, 0.0),) * 2,
                    angular_velocities=((0.01, 0.0, 0.0), (0.0, 0.0, 0.0)))  # fmt: skip
    law = LINEAR.replace(**{**ROLLS, "rolling_friction": 1e3})
    scene = Scene(bodies=bodies, law=law, step=1e-6, steps=40, every=4, segments=(turns,))

    first, second = (moving(scene, torsion_reversed_at=(step,)) for step in (26, 17))
    torque = second.torque.copy()
    torque[:8, 0] = first.torque[:8, 0]
    torque[-1, 0, 0] *= 1.0 + off
    observed = dataclasses.replace(second, torque=torque)

    def holds(motions):
        (motion,) = motions.values()
        return bool(np.abs(motion.torque - torque).max() < 1e-9 * np.abs(torque).max())

    assert np.abs(first.torque - second.torque)[:8, 0].max() > 1e-3 * np.abs(torque).max()
    run = Trial({scene: Rules()}, holds, observed)
    assert (explanation((REVERSED,), run) == (REVERSED,)) is (off == 0.0)


def test_the_torque_of_the_setup_is_fitted_on_the_first_sample_alone():
    observed = moving(ROLLING, setup_torque=(1e-4, 0.0, 2e-4))
    assert explanation((TORQUE,), trial(observed, ROLLING)) == (TORQUE,)
    observed.angular_velocity[1:] += 1e-4
    assert explanation((TORQUE,), trial(observed, ROLLING)) == ()
