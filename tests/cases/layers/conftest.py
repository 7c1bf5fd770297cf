import pytest

from harness.engines.lammps.engine import Lammps


@pytest.fixture(scope="module")
def engine(lammps_here):  # noqa: ARG001
    with Lammps(workers=1) as opened:
        yield opened
