"""Scripts that bring LAMMPS into trouble."""

import pytest

from harness.engines.scripts import Script

HEAD = """
units si
atom_style sphere
boundary f f f
region box block 0 1 0 1 0 1
create_box 1 box
"""

LOST = """
create_atoms 1 single 0.5 0.5 0.5
set group all diameter 0.1 density 1
velocity all set 10 0 0
pair_style granular
pair_coeff * * hooke 1000.0 1.0 damping velocity tangential linear_nohistory 0.0 0.0
comm_modify vel yes
fix integrate all nve/sphere
thermo 10
timestep 0.01
run 1000
"""


DONE = 'print "RESULT verdict = moves_on"\n'


@pytest.fixture(scope="session")
def lost_atom():
    return Script("lost.in", HEAD + LOST + DONE, frozenset())


@pytest.fixture(scope="session")
def runaway_memory():
    return Script(
        "runaway.in",
        HEAD.replace("0 1", "0 400") + "lattice sc 1\n" + "create_atoms 1 box\n" + DONE,
        frozenset(),
    )


@pytest.fixture(scope="session")
def suicide():
    """Return a function that makes a script in which LAMMPS is killed by a signal."""
    return lambda signal: Script(
        "suicide.in", f"shell 'kill -{signal} $PPID'\n" + DONE, frozenset()
    )
