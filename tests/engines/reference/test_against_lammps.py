"""Velocity Verlet of the reference DEM against LAMMPS, with the tail that other codes lack."""

import numpy as np
import pytest

from harness.cases.drop.case import Drop, run_drops
from harness.cases.incline.runs import run_inclines
from harness.cases.incline.system import Incline
from harness.engines.lammps.engine import Lammps
from harness.engines.reference import Reference
from harness.parameters.law import CLIPPED, PLASTIC, SOURCE

pytestmark = pytest.mark.live


@pytest.fixture(scope="module")
def lammps(lammps_here):  # noqa: ARG001
    with Lammps() as engine:
        yield engine


@pytest.mark.parametrize("effective_mass", ["full", "half"])
@pytest.mark.parametrize(
    ("contact", "steps"),
    [(SOURCE, 50.0), (CLIPPED, 50.0), (PLASTIC, 100.0)],
    ids=lambda value: getattr(value, "name", ""),
)
def test_the_passage_with_either_mass(lammps, contact, steps, effective_mass):
    case = Incline(
        contact=contact.replace(effective_mass=effective_mass),
        steps_per_contact=steps,
        angle=10.3,
        phase=0.3,
    )
    (theirs,), (own,) = (
        run_inclines(engine, [case], "passage") for engine in (lammps, Reference())
    )
    assert (own.motion, own.steps) == (theirs.motion, theirs.steps)
    assert own.margin_J == pytest.approx(theirs.margin_J, abs=1e-9)


def test_drops_with_the_attractive_tail(lammps):
    cases = [
        Drop(contact=SOURCE, speed=1.0, gap=0.01, duration=5.0, steps_per_contact=200.0),
        Drop(contact=SOURCE, gravity=9.81, sideways=0.5, gap=-1e-4, steps_per_contact=200.0),
    ]
    for theirs, own in zip(run_drops(lammps, cases), run_drops(Reference(), cases), strict=True):
        scale = max(1.0, float(np.abs(own.path.speed_m_per_s).max()))
        for name, unit in (("time_s", 1.0), ("y_m", 1.0), ("vy_m_per_s", scale)):
            a, b = getattr(theirs.path, name), getattr(own.path, name)
            assert np.abs(a - b).max() < 1e-12 * unit
