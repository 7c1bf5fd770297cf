"""Two spheres that meet askew, as a test of upstream's form; LAMMPS without Python."""

from dataclasses import replace

import pytest

from harness import upstream
from harness.upstream.scene import UpstreamTest

COMMANDS = """
units si
atom_style sphere
atom_modify map array sort 0 0
comm_modify vel yes
boundary f f f
region box block -1 1 -1 1 -1 1
create_box 2 box
create_atoms 1 single 0 0 -0.01005 units box
create_atoms 2 single 0.003 0 0.01005 units box
set group all diameter 0.02 density 2500
set type 1 vz 0.5
set type 2 vz -0.5 omega 5 6 7
group lower type 1
group upper type 2
pair_style granular
pair_coeff * * hertz/material 1e8 0.5 0.3 damping coeff_restitution tangential mindlin NULL 0.5 0.3
fix move all nve/sphere
neighbor 0.01 nsq
neigh_modify delay 0 every 1 check yes
timestep 2e-6
"""


def askew(*more, **replaced):
    """Return the test with commands added; ``replaced`` are the lines of a command, by its name."""
    commands, done = [], set()
    for line in filter(None, COMMANDS.splitlines()):
        word = line.split()[0]
        if word not in replaced:
            commands.append(line)
        elif word not in done:
            commands += replaced[word]
            done.add(word)
    return UpstreamTest("askew", (*commands, *more), (300, 300), judged_segment=1)


def named(test, **changes):
    return replace(test, **({"judged_segment": 0} if "segments" in changes else {}), **changes)


def run_with_newton_off(tests, lmp, **options):
    """Run tests in one of the two settings of newton: half of the runs."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(upstream, "MODES", ("off",))
        return upstream.run_upstream(tests, {"here": lmp}, **options)


@pytest.fixture(scope="session")
def lmp(lmp_binary):
    return lmp_binary
