"""Files of scenes and samples: lost samples, NaN; scenes that no code states."""

import json
import re
import shutil
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from harness.engines.base import scene_job
from harness.engines.kratos.engine import FAULTS, Kratos
from harness.engines.liggghts.engine import SAMPLES, Liggghts
from harness.engines.scenes import PARTS, read_motion
from harness.engines.yade.engine import Yade
from harness.errors import EngineNaNError, EngineOutputError, Unsupported
from harness.model.scene import Scene, Stage, Wall, sphere
from harness.solvers import reference
from tests.engines.struck import (
    ROLLS,
    SPRING,
    STRUCK,
    STRUCK_ELASTIC,
    TWISTS,
    error,
    struck_floor,
    struck_pair,
)
from tests.solvers.reference.scenes import DAMPED, DMT, HERTZ, HOOKE, LINEAR, RHO, R, climbing

CODES = {"liggghts": Liggghts, "yade": Yade, "kratos": Kratos}
ALL = pytest.mark.parametrize("code", CODES)
RECORDED = {
    "liggghts": ("struck.dump", STRUCK),
    "yade": ("struck.json", STRUCK),
    "kratos": ("struck.json", STRUCK_ELASTIC),
}


def test_script_has_the_scene_as_json_with_its_law():
    scene = struck_floor(HERTZ)
    with Kratos() as engine:
        text = engine.scene_script(scene_job(scene))
        (row,) = json.loads(re.search(r"^SCENES = r'''(.*)'''", text, re.MULTILINE)[1])
        assert row.pop("code") == engine.scene_words(scene)
    assert Scene(**row) == scene


def recorded(code, folder):
    """Copy what a code once wrote to a folder as its output; return the file and its scene."""
    name, scene = RECORDED[code]
    path = folder / ("0.json" if name.endswith(".json") else SAMPLES)
    shutil.copy(Path(__file__).parent / code / "recorded" / name, path)
    return path, scene


def read(code, folder, scene):
    if code == "liggghts":
        with Liggghts(sys.executable) as engine:
            return engine.read_samples(folder, scene)
    return read_motion(code, folder, 0, scene)


@ALL
def test_recorded_motion_is_the_reference_s(code, tmp_path):
    _, scene = recorded(code, tmp_path)
    rules, faults = CODES[code].rules(scene), FAULTS if code == "kratos" else None
    motion = read(code, tmp_path, scene)
    assert error(scene, motion, rules, faults) < 1e-9
    interchanged = replace(motion, velocity=motion.force, force=motion.velocity)
    assert error(scene, interchanged, rules, faults) > 0.1


def spoil(code, path, fault):
    """Plant a fault in what a code wrote."""
    text = path.read_text()
    if code == "liggghts":
        spoiled = {
            "lost sample": lambda: text[: text.rindex("ITEM: TIMESTEP")],
            "lost body": lambda: text.rstrip("\n").rpartition("\n")[0],
            "NaN": lambda: text.rstrip().rpartition(" ")[0] + " nan\n",
            "letters": lambda: text.rstrip().rpartition(" ")[0] + " 1e\n",
            "columns": lambda: text.replace("omegax", "angmomx"),
        }[fault]()  # fmt: skip
    else:
        table = json.loads(text)
        if fault == "lost sample":
            table = {name: rows[:-1] for name, rows in table.items()}
        elif fault == "lost body":
            table |= {name: [sample[:1] for sample in table[name]] for name in PARTS}
        elif fault == "NaN":
            table["torque"][-1][0][0] = float("nan")
        elif fault == "letters":
            table["torque"][-1][0][0] = "1e"
        else:
            table["omega"] = table.pop("angular_velocity")
        spoiled = json.dumps(table)
    assert spoiled != text
    path.write_text(spoiled)


@ALL
@pytest.mark.parametrize("fault", ["lost sample", "lost body", "NaN", "letters", "columns"])
def test_spoiled_output_is_refused(code, fault, tmp_path):
    path, scene = recorded(code, tmp_path)
    spoil(code, path, fault)
    with pytest.raises(EngineNaNError if fault == "NaN" else EngineOutputError):
        read(code, tmp_path, scene)


def written(path, scene, **changes):
    """Write what Yade or Kratos would write of a scene with stages, and return the reference."""
    motion = reference.run(scene)
    steps = (scene.every * np.arange(len(motion))).tolist()
    table = {"step": steps, "stages": motion.stages.tolist()}
    table |= {part: getattr(motion, part).tolist() for part in PARTS}
    (path / "0.json").write_text(json.dumps({**table, **changes}))
    return motion


STAGED = climbing((0.1, 0.0), (0.15, 0.0))


def test_motion_of_stages_ends_where_the_last_one_does(tmp_path):
    expected = written(tmp_path, STAGED)
    motion = read_motion("Yade", tmp_path, 0, STAGED)
    assert len(motion) == 21 < STAGED.steps / STAGED.every
    assert np.array_equal(motion.stages, expected.stages)


@pytest.mark.parametrize(
    ("stages", "error"),
    [
        ([], EngineOutputError),
        ([[0.0] * 6, [200.0] * 6], EngineOutputError),
        ([[50.0] * 7, [200.0] * 7], EngineOutputError),
        ([[0.0] * 7, [200.0] + [float("nan")] * 6], EngineNaNError),
    ],
)
def test_spoiled_stages_are_refused(tmp_path, stages, error):
    written(tmp_path, STAGED, stages=stages)
    with pytest.raises(error):
        read_motion("Yade", tmp_path, 0, STAGED)


def test_pair_that_a_scene_keeps_apart_must_not_meet(tmp_path):
    bodies = tuple(
        sphere(R, RHO, position=(x, 0.0, 0.0), velocity=(v, 0.0, 0.0))
        for x, v in ((0.0, 1.0), (2.1 * R, 0.0), (4.2 * R, 0.0))
    )
    scene = Scene(bodies=bodies, step=1e-4, steps=400, every=10, pairs=((1, 2),))
    assert CODES["liggghts"].rules(scene.replace(pairs=((0, 1), (1, 2))))
    table = {
        "step": list(range(0, 401, 10)),
        **{part: np.zeros((41, 3, 3)).tolist() for part in PARTS},
    }
    (tmp_path / "0.json").write_text(json.dumps(table))
    with pytest.raises(EngineOutputError, match="bodies 0 and 1 touch"):
        read_motion("Yade", tmp_path, 0, scene)


PLAIN = struck_floor(HOOKE)
REFUSED = {
    "drag": PLAIN.replace(drag=1.0),
    "along x alone": PLAIN.replace(period=(None, 1.0, None)),
    "no walls beside periodic": PLAIN.replace(period=(1.0, None, None)),
    "starts within one period": struck_pair(HOOKE).replace(
        period=(0.05, None, None), bodies=(sphere(R, RHO), sphere(R, RHO, position=(0.06, 0, 0)))
    ),
    "between stages": PLAIN.replace(stages=(Stage(place=1.0, floor=0.0),), setups=(10,)),
    "one law": PLAIN.replace(laws={(1, 2): HERTZ}),
    "all bodies": struck_pair(HOOKE).replace(pairs=()),
    "one material": PLAIN.replace(law=HERTZ.replace(partner_youngs_modulus=1e9)),
    "no heat": PLAIN.replace(law=HOOKE.replace(heat="area", conductance=1.0)),
    "one contact interface": PLAIN.replace(law=HOOKE.replace(interface="old")),
    "all axes": PLAIN.replace(bodies=(PLAIN.bodies[0].replace(axes=(True, True, False)),)),
    "solid spheres": PLAIN.replace(bodies=(PLAIN.bodies[0].replace(inertia=1e-6),)),
}
WALLS = {
    "tilted": Wall(direction=(0.0, 0.1, 1.0)),
    "moving": Wall(velocity=(0.0, 0.0, 0.1)),
    "oscillating": Wall(amplitude=(0.0, 0.0, 1e-4), frequency=10.0),
    "sliding": Wall(surface_velocity=(0.1, 0.0, 0.0)),
    "curved": Wall(shape="sphere", radius=10.0 * R, hollow=True),
}


@ALL
def test_scene_that_no_code_states(code):
    for reason, scene in REFUSED.items():
        with pytest.raises(Unsupported, match=reason):
            CODES[code].rules(scene)
    for wall in WALLS.values():
        with pytest.raises(Unsupported, match="planes at rest across an axis"):
            CODES[code].rules(PLAIN.replace(walls=(wall,)))


ROLLING = HOOKE.replace(**SPRING, **ROLLS, rolling_stiffness=2e4)
RESTITUTION = {"damping": "coeff_restitution", "restitution": 0.5, "clipped": True}
EACH = {**RESTITUTION, "partner_restitution": 0.9}
JKR = HERTZ.replace(normal="jkr", surface_energy=0.1)
TSUJI = HERTZ.replace(damping="tsuji", restitution=0.5)
FRICTION_OF_EACH = HOOKE.replace(**SPRING, partner_friction=0.1)
MIXES_NONE, ATTRACTS = "of each pair, and mixes none", "never attracts"
SETS_UP_ONCE = "sets no forces up again"
DAMPED_MINDLIN = HERTZ.replace(**RESTITUTION, tangential="mindlin", tangential_damping=0.5)
BY_CODE = {
    "liggghts": [
        (HERTZ.replace(tangential="mindlin/force"), "takes tangential = .* mindlin_classic"),
        (TSUJI, "takes damping = none or viscoelastic"),
        (FRICTION_OF_EACH, MIXES_NONE),
        (JKR, "takes normal = hertz, not jkr"),
        (DAMPED_MINDLIN, "no tangential dashpot but of 0.907485213"),
        (HOOKE.replace(**SPRING, **ROLLS, rolling_stiffness=900.0), "k_n mu_r"),
        (HOOKE.replace(**SPRING, **TWISTS, twisting_stiffness=1.0), "resist rolling as well"),
        (ROLLING.replace(**TWISTS, twisting_stiffness=3.0), "rolling or twisting, not both"),
        (LINEAR.replace(twisting="marshall"), "takes twisting = none or sds, not marshall"),
    ],
    "kratos": [
        (struck_pair(HOOKE.replace(**DAMPED)), ATTRACTS),
        (PLAIN.replace(setups=(10,)), SETS_UP_ONCE),
        (LINEAR.replace(clipped=True), "tied to the normal one, and limited twice"),
        (HERTZ.replace(tangential="mindlin"), "takes tangential = none or mindlin_rescale/force"),
        (TSUJI, "none or coeff_restitution, not tsuji"),
        (FRICTION_OF_EACH, MIXES_NONE),
        (JKR, "takes normal = dmt, not jkr"),
    ],
    "yade": [
        (struck_pair(HOOKE.replace(**DAMPED)), ATTRACTS),
        (PLAIN.replace(setups=(10,)), SETS_UP_ONCE),
        (HERTZ.replace(tangential="mindlin"), "tangential = none or mindlin/force"),
        (HOOKE.replace(tangential="linear_history_classic"), "linear_history, not"),
        (ROLLING.replace(rolling_damping=0.1), "without a"),
        (DMT.replace(tangential="mindlin/force"), "has dmt without dashpot and friction only"),
        (JKR, "not jkr"),
        (struck_pair(ROLLING).replace(walls=(Wall(),)), "has one R"),
        (HOOKE.replace(**EACH), "of two free spheres without friction"),
        (struck_pair(HERTZ.replace(**EACH)), MIXES_NONE),
    ],
}


@ALL
def test_law_or_scene_that_a_code_cannot_state(code):
    for asked, reason in BY_CODE[code]:
        with pytest.raises(Unsupported, match=reason):
            CODES[code].rules(asked if isinstance(asked, Scene) else struck_floor(asked))
