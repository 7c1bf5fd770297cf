import pytest

from harness.engines.lammps.engine import Lammps


@pytest.fixture(scope="session")
def lammps(lammps_here):  # noqa: ARG001
    with Lammps(workers=1) as engine:
        yield engine
