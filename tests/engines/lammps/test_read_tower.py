import pytest

from harness.cases.tower.run import read
from harness.cases.tower.system import Timing
from harness.engines.lammps.engine import Lammps
from harness.engines.output import Output, read_dump
from harness.observables.provenance import Provenance
from harness.parameters.tower import Tower

WHO = Provenance("lammps", "1 Jan 2030")
CASE = Tower(height=2, law="overlap", stiffness=1000.0, gravity=10.0, mass=2.0)


def read_tower(case, step, dump, who, profiles=False):
    """Return the run that a dump tells of."""
    table = read_dump(dump, "LAMMPS")
    timing = Timing(1.0, step, 10 * (len(table["step"]) - 1), 10, 100.0)
    return read(case, timing, Output((), who, {"series": table}), Lammps.traits, profiles)


def _dump(*snapshots):
    """Return a dump of rows (x, vx, fx) for three particles at steps 0, 10, ..."""
    text = ""
    for number, rows in enumerate(snapshots):
        text += f"ITEM: TIMESTEP\n{10 * number}\nITEM: NUMBER OF ATOMS\n3\n"
        text += "ITEM: BOX BOUNDS ss pp pp\n0 1\n0 1\n0 1\nITEM: ATOMS id x vx fx\n"
        text += "".join(f"{i} {x!r} {v!r} {f!r} \n" for i, (x, v, f) in enumerate(rows, 1))
    return text


# contact 1 pressed in by 0.1 m (100 N), contact 2 by 0.05 m (50 N), weights of 20 N
PRESSED = [(0.15, 3.0, 20.0 - 100.0), (1.05, 1.0, 20.0 + 100.0 - 50.0), (2.0, 0.0, 0.0)]
APART = [(-0.5, -1.0, 20.0), (1.0, 0.0, 20.0), (2.0, 0.0, 0.0)]


def test_every_observable_of_a_snapshot():
    run = read_tower(CASE, 0.1, _dump(PRESSED, APART), WHO, profiles=True)
    assert run.time == pytest.approx([0.0, 1.0])
    assert run.grain_force == pytest.approx([100.0, 0.0])
    assert run.base_force == pytest.approx([50.0, 0.0])
    assert run.contacts.tolist() == [2, 0]
    assert run.compression == pytest.approx([0.15, -0.5])
    assert run.compression_rate == pytest.approx([3.0, -1.0])
    assert run.kinetic_energy[0] == pytest.approx(0.5 * 2.0 * (9.0 + 1.0))
    assert run.elastic_energy[0] == pytest.approx(0.5 * 1000.0 * (0.1**2 + 0.05**2))
    assert run.gravitational_energy[0] == pytest.approx(-2.0 * 10.0 * (0.15 + 0.05))
    assert run.momentum[0] == pytest.approx(2.0 * 4.0)
    assert run.final_velocity.tolist() == [-1.0, 0.0, 0.0]
    assert run.profiles.forces[0] == pytest.approx([100.0, 50.0])
    assert run.provenance is WHO
    assert run.solver == "lammps"
