import pytest

from harness.engines.lammps.engine import Lammps


@pytest.fixture(scope="module")
def lammps():
    with Lammps() as engine:
        yield engine
