"""MFiX itself, where ``DEM_HARNESS_MFIX`` names its solver: a drop, passages, towers of 1 to 4."""

import numpy as np
import pytest

from harness.cases.drop.case import Drop, run_drops
from harness.cases.incline.runs import run_inclines
from harness.cases.incline.system import Incline
from harness.cases.tower.run import run_towers
from harness.engines.mfix.contacts import CONTACT
from harness.engines.mfix.engine import Mfix
from harness.engines.mfix.system import REFERENCE
from harness.engines.reference import Reference
from harness.observables.tower import turnaround
from harness.parameters.tower import Tower
from harness.solvers.chain import exact

pytestmark = [pytest.mark.live, pytest.mark.slow]

SINGLE = 2.0**-23


@pytest.mark.parametrize("scheme", REFERENCE)
@pytest.mark.parametrize("restitution", [0.5, 1e-20])
def test_a_drop_is_the_reference_dem_in_its_scheme(mfix, restitution, scheme):
    contact = CONTACT.replace(restitution=restitution)
    case = Drop(contact=contact, speed=1.0, steps_per_contact=100.0, duration=4.0)
    with Mfix(program=mfix.identify().executable, scheme=scheme) as engine:
        (run,) = run_drops(engine, [case])
    (expected,) = run_drops(Reference(REFERENCE[scheme]), [case])
    assert run.path.time_s == pytest.approx(expected.path.time_s, rel=1e-9, abs=1e-12)
    assert np.abs(run.path.y_m - expected.path.y_m).max() < 4 * SINGLE
    assert np.abs(run.path.vy_m_per_s - expected.path.vy_m_per_s).max() < 1e-6


@pytest.mark.parametrize("scheme", REFERENCE)
@pytest.mark.parametrize("steps", [50.0, 400.0])
@pytest.mark.parametrize("angle", [9.5, 10.3])
def test_a_passage_is_the_reference_dem_in_its_scheme(mfix, steps, angle, scheme):
    case = Incline(angle=angle, contact=CONTACT, steps_per_contact=steps)
    with Mfix(program=mfix.identify().executable, scheme=scheme) as engine:
        (run,) = run_inclines(engine, [case], "passage")
    (expected,) = run_inclines(Reference(REFERENCE[scheme]), [case], "passage")
    assert (run.motion, run.steps) == (expected.motion, expected.steps)
    # single precision, and the first step of the row
    assert run.margin_J == pytest.approx(expected.margin_J, abs=2e-5)


@pytest.mark.parametrize("height", [1, 2, 3, 4])
@pytest.mark.parametrize("base", ["fixed", "free"])
@pytest.mark.parametrize("samples", [300, None], ids=["every tenth", "every step"])
def test_a_tower_is_the_exact_one(mfix, height, base, samples):
    case = Tower(height=height, law="overlap", base=base)
    (run,) = run_towers(mfix, [case], 3.0, samples=samples)
    expected = exact.run(case, 3.0 * case.contact_time, samples=6000)
    force = np.interp(run.time, expected.time, expected.grain_force)
    # 1000 steps a contact, first order: gravity in the first half step
    assert np.abs(run.grain_force - force).max() < 2e-4 * force.max()
    assert np.all(np.diff(run.time) > 0.0)
    # the scheme's velocities belong half a step back
    assert turnaround(run) - 0.5 * run.step == pytest.approx(
        turnaround(expected), abs=0.1 * run.step
    )
