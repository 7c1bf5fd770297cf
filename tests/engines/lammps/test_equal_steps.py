"""LAMMPS at equal steps: scenes of all laws and walls, held against the reference to 1e-9."""

import math
import shutil
import sys
from pathlib import Path

import numpy as np
import pytest

from harness.engines.base import scene_job
from harness.engines.lammps.engine import Lammps
from harness.engines.lammps.scene import rules, variations
from harness.errors import EngineError
from harness.model.conventions import Faults
from harness.model.law import COEFFICIENTS
from harness.solvers import reference
from tests.engines.lammps.scenes import (
    LAWS,
    LINEAR,
    PLACES,
    SCENES,
    SYSTEMS,
    W,
    in_other_units,
    off_by,
)

pytestmark = pytest.mark.live
TOLERANCE = 1e-9  # of the size that a quantity has in its scene
LMP = shutil.which("lmp", path=str(Path(sys.executable).parent)) or shutil.which("lmp") or ""


VARIED = SYSTEMS["spheres"](LAWS["jkr"])
IN_OTHER_UNITS = in_other_units()


def known_defects(name, scene):
    """Return the switches of the known defects that a scene shows, as the wheel has them."""
    law, walls = scene.law, "walls" if scene.law.interface == "old" else "all"
    faults = Faults(
        tsuji_effective_mass=law.damping == "tsuji",
        marshall_without_radius=law.twisting == "marshall",
        twisting_limit_by_rate=True,
        cap_without_radius=walls if "classic" in law.tangential else "none",
        tangential_radius=walls if law.tangential == "linear_history_classic" else "none",
        mdr_damping_interchanged=True,
        cylinder_shear=(-3.0 * W, 0.0, 0.0) if name == "drum" else (0.0, 0.0, 0.0),
        longest_neck=0.0 if name == "bowl, jkr" else None,
    )
    if law.normal == "mdr" and law.surface_energy:
        adhesion = {"mdr_sticking_share": 0.99, "mdr_newton_error": 1e-10}
        return faults.replace(**adhesion, mdr_parts_at_zero=True)
    mixed = scene.law_of(1, 2)
    if mixed.two_moduli and len(scene.bodies) == 2:  # mindlin takes the mixed E* for E
        nu = math.prod(row[1] for row in mixed.materials) ** 0.5
        mixed_shear = mixed.moduli[0] / (4.0 * (2.0 - nu) * (1.0 + nu))
        return faults.replace(shear_factor=mixed_shear / mixed.moduli[1])
    return faults


def difference(scene, theirs, ours):
    """Return the largest difference of free bodies, over the size of each quantity."""
    free = [bool(scene.segments) or body.motion == "free" for body in scene.bodies]
    r = max(body.radius for body in scene.bodies)
    off = [np.abs(theirs.position - ours.position)[:, free].max() / r]
    for linear, angular, lever in (("velocity", "angular_velocity", r), ("force", "torque", 1 / r)):
        levers = {linear: 1.0, angular: lever}
        size = max(k * np.abs(getattr(ours, n)[:, free]).max() for n, k in levers.items()) or 1.0
        for name, k in levers.items():
            off.append(
                k * np.abs(getattr(theirs, name) - getattr(ours, name))[:, free].max() / size
            )
    if ours.temperature is not None:
        spread = np.ptp(ours.temperature)
        off.append(np.abs(theirs.temperature - ours.temperature).max() / spread)
    return float(np.max(off))


@pytest.fixture(scope="module")
def outcomes():
    """Run all scenes and variations, in processes of many each."""
    jobs = {name: scene_job(scene) for name, scene in SCENES.items()}
    jobs |= {row.name: scene_job(VARIED, variation=row.name) for row in variations(VARIED)}
    jobs["other units"] = scene_job(IN_OTHER_UNITS, units="lj")
    with Lammps(lmp=LMP, workers=2) as engine:
        return dict(zip(jobs, engine.motions([*jobs.values()]), strict=True))


def holds(name, motion):
    scene = SCENES[name]
    ours = reference.run(scene, rules(scene), known_defects(name, scene))
    return difference(scene, motion, ours) < TOLERANCE


@pytest.mark.parametrize("name", LAWS)
def test_equal_steps_of_a_law(name, outcomes):
    for system in SYSTEMS:
        scene = f"{name}, {system}"
        assert holds(scene, outcomes[scene]), system


@pytest.mark.parametrize("name", PLACES)
def test_equal_steps_at_walls_and_of_several_bodies(name, outcomes):
    assert holds(name, outcomes[name])


def sees(name, part, outcomes):
    """Return whether a coefficient off by a millionth shows in any system of a law."""
    law = off_by(name, part)
    for system in SYSTEMS:
        scene, motion = SCENES[f"{name}, {system}"], outcomes[f"{name}, {system}"]
        other = scene.replace(law=law)
        ours = reference.run(other, rules(scene), known_defects(name, other))
        if difference(scene, motion, ours) > TOLERANCE:
            return True
    return False


@pytest.mark.parametrize("name", LAWS)
def test_coefficients_off_by_a_millionth(name, outcomes):
    parts = [part for part in COEFFICIENTS if getattr(LAWS[name], part) not in (None, 0.0)]
    blind = {part for part in parts if not sees(name, part, outcomes)}
    assert blind <= {"bulk_share"}  # a threshold: no motion shows that it is off by so little


def test_numbers_in_other_units(outcomes):
    scene, ours = IN_OTHER_UNITS, reference.run(IN_OTHER_UNITS, rules(IN_OTHER_UNITS))
    assert difference(scene, outcomes["other units"], ours) < TOLERANCE


@pytest.mark.parametrize("row", variations(VARIED), ids=lambda row: row.name)
def test_variation(row, outcomes):
    faults = known_defects(row.name, row.scene)
    if row.variation.coefficients == "mixed":  # mindlin takes the mixed E* for E
        faults = faults.replace(shear_factor=0.5 / (1.0 - row.scene.law.poisson_ratio**2))
    ours = reference.run(row.scene, rules(row.scene), faults)
    assert difference(row.scene, outcomes[row.name], ours) < TOLERANCE


FAULTS = {  # what a stand-in does to an input, or to samples, and the words of the error
    "coefficient": ("sed -i 's/ 100000.0 / 100000.1 /' in.lmp", "", ""),
    "columns": ("", r"sed -i -E 's/^([0-9]+) (\S+) (\S+) /\1 \3 \2 /' motion.dump", ""),
    "sample": ("", "sed -i '/^7$/,$d' motion.dump", "wrote a dump that cannot be read"),
    "body": ("", "sed -i '$d' motion.dump", "wrote a dump that cannot be read"),
    "NaN": ("", "sed -i '$s/ [^ ]*$/ nan/' motion.dump", "not finite (NaN) at step 60"),
    "no file": ("", "rm -f motion.dump", "it is cut"),
    "none": ("", "", ""),
    "lost atom": ("sed -i 's/ 1000000000/ 1/; s/ vx -*[0-9.]* / vx 1e9 /' in.lmp", "", "lost an"),
    "none after a crash": ("", "", ""),  # in the next process
}  # fmt: skip


@pytest.fixture(scope="module")
def faulty(tmp_path_factory):
    """Run a batch of one scene, of which a stand-in of LAMMPS spoils each copy in another way."""
    stand_in = tmp_path_factory.mktemp("faults") / "lmp"
    before, after = (
        [f"[ ! -d {k} ] || (cd {k}; {row[part] or ':'})" for k, row in enumerate(FAULTS.values())]
        for part in (0, 1)
    )
    # after a crash the folders are counted anew: that process spoils nothing
    again = f'[ ! -d 0 ] || mkdir {stand_in}.ran 2>/dev/null || exec {LMP} "$@"'
    run = [f'{LMP} "$@"', "code=$?"]
    lines = ["#!/bin/sh", again, *before, *run, *after, "exit $code", ""]
    stand_in.write_text("\n".join(lines))
    stand_in.chmod(0o755)
    jobs = [scene_job(SYSTEMS["spheres"](LINEAR))] * len(FAULTS)
    with Lammps(lmp=str(stand_in), workers=1) as engine:
        return dict(zip(FAULTS, engine.motions(jobs), strict=True))


@pytest.mark.parametrize("name", FAULTS)
def test_planted_fault(name, faulty):
    message, scene = FAULTS[name][2], SYSTEMS["spheres"](LINEAR)
    if message:
        assert isinstance(faulty[name], EngineError)
        assert message in str(faulty[name])
    else:
        off = difference(scene, faulty[name], reference.run(scene))
        assert (off < TOLERANCE) == name.startswith("none")
