import numpy as np
import pytest

from harness.cases.tower.run import run_towers
from harness.engines.lammps.engine import Lammps
from harness.errors import RequestError
from harness.observables.tower import first_contact_end, impulse
from harness.parameters.tower import Tower
from harness.solvers.chain import exact
from tests.engines.tower_runs import KINDS, force_difference, run

pytestmark = pytest.mark.live


@pytest.fixture(scope="module")
def lammps():
    with Lammps() as engine:
        yield engine


@pytest.mark.parametrize("height", [1, 2, 5, 10, 19])
def test_overlap_law_meets_the_exact_solution(lammps, height):
    case = Tower(height=height, law="overlap")
    found = run(lammps, case)
    assert force_difference(found) < 1e-5
    assert impulse(found) == pytest.approx(impulse(exact.run(case, found.time[-1])), rel=1e-5)


@pytest.mark.parametrize("height", [1, 3, 19])
def test_deformable_law_as_an_external_force_meets_the_exact_solution(lammps, height):
    assert force_difference(run(lammps, Tower(height=height))) < 1e-4


@pytest.mark.parametrize("changes", KINDS)
def test_every_kind_of_tower(lammps, changes):
    case = Tower(height=4, law="overlap").replace(**changes)
    assert force_difference(run(lammps, case)) < 2e-5


def test_the_error_falls_with_the_square_of_the_step(lammps):
    errors = [
        force_difference(run(lammps, Tower(height=3, law="overlap"), steps_per_contact=n))
        for n in (250, 500, 1000, 2000)
    ]
    order = np.polyfit(np.log([250, 500, 1000, 2000]), -np.log(errors), 1)[0]
    assert 1.7 < order < 2.3


def test_the_bessel_limit_of_a_tall_tower(lammps):
    # the reflection from the base comes back after two passages: 40 contacts are enough
    tall = run(lammps, Tower(height=40, law="overlap", gravity=0.0), samples=6000)
    end = first_contact_end(tall)
    lost = 2.0 - np.interp(end, tall.time, tall.grain_velocity)
    assert lost / 4.0 == pytest.approx(0.5661397, abs=1e-5)


def test_unequal_particles_are_refused(lammps):
    with pytest.raises(RequestError, match="one number each"):
        run_towers(lammps, [Tower(height=1, mass=(1.0, 2.0))], 3.0)


def test_an_executable_refuses_the_deformable_law(lmp):
    with Lammps(lmp=lmp) as engine:
        with pytest.raises(RequestError, match="in-process only"):
            run_towers(engine, [Tower()], 3.0)
        (run,) = run_towers(engine, [Tower(height=2, law="overlap")], 3.0)
        assert run.provenance.how == "executable"


def test_in_process_and_executable_give_the_same_series(lammps, lmp):
    case = Tower(height=5, law="overlap")
    with Lammps(lmp=lmp) as engine:
        (other,) = run_towers(engine, [case], 3.0)
    np.testing.assert_array_equal(run(lammps, case).grain_force, other.grain_force)
