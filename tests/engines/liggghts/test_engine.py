"""LIGGGHTS against the reference DEM, against LAMMPS, and against the exact tower.

Its scripts state the numbers of a scene, those of LAMMPS compute them, with variables of 15 digits.
"""

import subprocess

import numpy as np
import pytest

from harness.cases.incline.runs import run_inclines
from harness.cases.incline.system import Incline
from harness.cases.tower.run import run_towers
from harness.cases.tower.system import TEMPLATE
from harness.engines.lammps.engine import Lammps
from harness.engines.liggghts.engine import Liggghts
from harness.engines.reference import Reference
from harness.errors import EngineError
from harness.parameters.law import CLIPPED, PLASTIC, SOURCE
from harness.parameters.tower import Tower
from tests.engines.tower_runs import KINDS

pytestmark = pytest.mark.live

STEPS = {SOURCE: 50.0, CLIPPED: 50.0, PLASTIC: 100.0}
CONTACTS = pytest.mark.parametrize("contact", STEPS, ids=lambda contact: contact.name)


@pytest.fixture(scope="module")
def lammps(lammps_here):  # noqa: ARG001
    with Lammps(workers=2) as engine:
        yield engine


def assert_same_run(own, theirs, margin):
    assert (own.motion, own.steps, own.touching) == (theirs.motion, theirs.steps, theirs.touching)
    assert own.margin_J == pytest.approx(theirs.margin_J, abs=margin)
    np.testing.assert_allclose(own.crests.margin_J, theirs.crests.margin_J, rtol=0, atol=margin)


@CONTACTS
def test_incline_is_lammps_to_round_off(liggghts, lammps, contact):
    cases = [
        Incline(contact=contact, steps_per_contact=STEPS[contact], angle=angle, phase=phase)
        for angle, phase in ((9.9, 0.0), (10.5, 0.3))
    ]
    runs = (run_inclines(engine, cases, "passage") for engine in (liggghts, lammps))
    for own, theirs in zip(*runs, strict=True):
        assert_same_run(own, theirs, 1e-11)
    # each shock multiplies round-off: a run over many wells agrees in its first crests
    runs = (run_inclines(engine, cases, "steady") for engine in (liggghts, lammps))
    for own, theirs in zip(*runs, strict=True):
        assert own.motion is theirs.motion
        assert own.crests.margin_J[:2] == pytest.approx(theirs.crests.margin_J[:2], abs=1e-7)


@CONTACTS
def test_path_is_the_reference_dem_to_round_off(liggghts, contact):
    case = Incline(contact=contact, steps_per_contact=STEPS[contact], angle=10.3, phase=0.3)
    (own,), (theirs,) = (
        run_inclines(engine, [case], "passage", every=10)
        for engine in (liggghts, Reference(liggghts.traits.integrator))
    )
    assert_same_run(own, theirs, 1e-13)
    for column, values in vars(theirs.trajectory).items():
        difference = np.abs(getattr(own.trajectory, column) - values).max()
        assert difference < 1e-11, column


@pytest.mark.slow
@pytest.mark.parametrize("changes", KINDS)
def test_every_kind_of_tower_is_lammps_to_round_off(liggghts, lammps, changes):
    case = Tower(height=5, law="overlap").replace(**changes)
    (own,), (theirs,) = (run_towers(e, [case], 3.0, profiles=True) for e in (liggghts, lammps))
    for values, others in zip(own.profiles, theirs.profiles, strict=True):
        np.testing.assert_allclose(values, others, rtol=0, atol=1e-12 * np.abs(others).max())


def test_a_tall_tower_is_all_in_the_box(liggghts, lammps):
    """Of more than twenty particles those at x > 20 diameters were once left out."""
    case = Tower(height=60, law="overlap")
    (own,), (theirs,) = (run_towers(e, [case], 0.2, profiles=True) for e in (liggghts, lammps))
    for values, others in zip(own.profiles, theirs.profiles, strict=True):
        np.testing.assert_allclose(values, others, rtol=0, atol=1e-12 * np.abs(others).max())


def test_a_sphere_beyond_the_box_of_a_script_is_an_error(liggghts, tmp_path):
    script = tmp_path / "tower.in"
    script.write_text(Liggghts.script(TEMPLATE).text, encoding="utf-8")
    words = [liggghts.program, "-in", str(script), "-log", "none", "-var", "reach", "0"]
    xs = ["-var", "x", "0", "1", "9"]
    said = subprocess.run([*words, *xs], cwd=tmp_path, capture_output=True).stdout
    # it ends in `quit 1`, which LIGGGHTS 3.8.0 answers with bytes that are no text
    assert b"ERROR: reach = 0 m: must be at least that of the outermost sphere: 2 of 3 are" in said


def test_run_that_leaves_its_box_costs_only_itself(liggghts):
    flung = Incline(angle=29.0, contact=PLASTIC, steps_per_contact=100.0)
    good = Incline(angle=10.3, contact=PLASTIC, steps_per_contact=100.0)
    first, lost, last = run_inclines(liggghts, [good, flung, good], "passage")
    assert first.margin_J == last.margin_J
    assert isinstance(lost, EngineError)
    assert "ERROR" in lost.log
