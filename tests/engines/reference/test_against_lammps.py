"""Velocity Verlet of the reference DEM against LAMMPS: same stiffness, step, contact."""

import numpy as np
import pytest

from harness.cases.incline.angle import critical_angle
from harness.cases.incline.runs import run_inclines
from harness.cases.incline.system import Incline, Motion
from harness.engines.lammps.engine import Lammps
from harness.engines.reference import Reference
from harness.parameters.law import CLIPPED, PLASTIC, SOURCE

pytestmark = pytest.mark.live


@pytest.fixture(scope="module")
def lammps(lammps_here):  # noqa: ARG001
    with Lammps() as engine:
        yield engine


@pytest.mark.parametrize("angle", [9.5, 10.0, 10.15])
def test_the_path_until_it_is_trapped(lammps, angle):
    case = Incline(angle=angle)
    (theirs,) = run_inclines(lammps, [case], "steady", every=50)
    (own,) = run_inclines(Reference(), [case], "steady", every=50)
    assert own.motion is theirs.motion is Motion.TRAPPED
    assert own.steps == theirs.steps
    rows = min(len(own.trajectory.x_m), len(theirs.trajectory.x_m))
    assert rows >= own.steps // 50
    for column in ("x_m", "y_m"):
        apart = getattr(own.trajectory, column)[:rows] - getattr(theirs.trajectory, column)[:rows]
        assert np.abs(apart).max() < 1e-6 * case.diameter
    np.testing.assert_allclose(own.crests.margin_J, theirs.crests.margin_J, atol=1e-6)
    assert own.touching == theirs.touching


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


@pytest.mark.parametrize("stiffness", [1e5, 1e6, 1e7])
@pytest.mark.parametrize(
    ("contact", "steps"),
    [(SOURCE, 50.0), (CLIPPED, 50.0), (PLASTIC, 100.0)],
    ids=lambda value: getattr(value, "name", ""),
)
def test_the_critical_angle(lammps, contact, steps, stiffness):
    case = Incline(contact=contact, steps_per_contact=steps, stiffness=stiffness)
    theirs, own = (critical_angle(case, engine=e, phases=2) for e in (lammps, Reference()))
    assert own.value_deg == pytest.approx(theirs.value_deg, abs=5e-4)
