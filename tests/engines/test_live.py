"""Codes that take scenes against the reference DEM and the exact tower, where they are."""

import os
import subprocess
import sys

import numpy as np
import pytest

from harness.cases.drop.case import Drop, run_drops
from harness.cases.incline.angle import critical_angle
from harness.cases.incline.runs import run_inclines
from harness.cases.incline.system import Incline, Motion
from harness.cases.tower.run import run_towers, tower
from harness.engines.liggghts.engine import ALONE
from harness.engines.programs import fresh_folder
from harness.engines.reference import Reference
from harness.observables.tower import impulse
from harness.parameters.law import CLIPPED, PLASTIC, SOURCE
from harness.parameters.tower import Tower
from harness.theory.incline import critical_angle as closed_form
from harness.workflows.engine_status import generated_inputs
from tests.engines.tower_runs import KINDS, force_difference

pytestmark = pytest.mark.live

CODES = ("liggghts", "yade", "kratos")
ALL = pytest.mark.parametrize("code", CODES, indirect=True)
YADE = pytest.param("yade", marks=pytest.mark.slow)
QUICK = pytest.mark.parametrize("code", ["lammps", "liggghts", "kratos", YADE], indirect=True)
HALF = CLIPPED.replace(name="half", restitution=0.5, damping_ratio=None)
CLIPPED_SOURCE = SOURCE.replace(name="source, clipped", tail="clipped")
SMALL = {"diameter": 0.37, "density": 2500.0, "gravity": 3.7}


def reference_of(engine):
    return Reference(engine.traits.integrator)


def assert_same_paths(path, expected, case):
    """Compare paths step by step, to round-off."""
    rows = path.time_s.size
    scale = max(1.0, float(np.abs(expected.speed_m_per_s).max()))
    for name, values in vars(expected).items():
        unit = {"t": 1.0, "v": scale}.get(name[0], case.diameter)
        np.testing.assert_allclose(getattr(path, name), values[:rows], rtol=0, atol=1e-10 * unit)


DROPS = [
    Drop(contact=HALF, speed=1.0, sideways=0.3, gap=1.5e-3, gravity=9.81, duration=5.0),
    Drop(contact=CLIPPED_SOURCE, speed=1.0, gap=1.5e-3, gravity=9.81, duration=5.0),
    Drop(contact=PLASTIC, speed=1.0, gap=0.01, duration=5.0, steps_per_contact=200.0),
    Drop(contact=CLIPPED, gravity=9.81, sideways=0.5, gap=-1e-4, steps_per_contact=200.0),
    Drop(
        contact=CLIPPED.replace(effective_mass="half"),
        diameter=3e-3,
        density=2500.0,
        gravity=9.81,
        gap=1e-6,
        steps_per_contact=100.0,
    ),
]


@QUICK
def test_drops_are_the_reference_s_step_by_step(code):
    runs = zip(run_drops(code, DROPS), run_drops(reference_of(code), DROPS), strict=True)
    for case, (ours, theirs) in zip(DROPS, runs, strict=True):
        assert_same_paths(ours.path, theirs.path, case)


PASSAGES = [
    Incline(contact=PLASTIC, angle=9.7, stiffness=1e5, steps_per_contact=50.0),
    Incline(contact=PLASTIC, angle=10.5, stiffness=1e5, steps_per_contact=50.0, phase=0.7),
    Incline(contact=PLASTIC, angle=10.5, steps_per_contact=200.0, phase=0.3, **SMALL),
    Incline(contact=CLIPPED, angle=12.0, stiffness=1e5),
    Incline(contact=PLASTIC, angle=12.0, stiffness=1e5, steps_per_contact=200.0, time_limit=0.1),
]
STEADY = [
    Incline(contact=PLASTIC, angle=15.0, stiffness=1e5, steps_per_contact=50.0, spheres=4, wells=7),
    Incline(contact=PLASTIC, angle=10.0, stiffness=1e5, steps_per_contact=50.0),
    Incline(contact=PLASTIC, angle=12.0, stiffness=1e5, steps_per_contact=50.0, time_limit=1.01),
]


@pytest.mark.parametrize(("route", "cases"), [("passage", PASSAGES), ("steady", STEADY)])
@QUICK
def test_inclines_are_the_reference_s_step_by_step(code, route, cases):
    ours = run_inclines(code, cases, route, every=7)
    theirs = run_inclines(reference_of(code), cases, route, every=7)
    assert {run.motion for run in theirs} == set(Motion)
    for case, run, reference in zip(cases, ours, theirs, strict=True):
        assert run.motion is reference.motion
        assert (run.steps, run.touching) == (reference.steps, reference.touching)
        # each shock multiplies round-off: it may even begin a step later
        width = 1e-10 if route == "passage" else 1e-6
        if route == "passage":
            assert_same_paths(run.trajectory, reference.trajectory, case)
        assert run.margin_J == pytest.approx(reference.margin_J, abs=width * case.weight_energy)
        assert run.crests.time_s == pytest.approx(reference.crests.time_s, rel=1e-14)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("contact", "stiffness", "steps"),
    # of a run's every step it is seen above: here it is the search that ends at the same angle
    [(SOURCE, 1e5, 50.0), (CLIPPED, 1e5, 50.0), (PLASTIC, 1e5, 50.0), (PLASTIC, 1e6, 200.0)],
    ids=lambda value: getattr(value, "name", None),
)
@ALL
def test_a_critical_angle_is_the_reference_s(code, contact, stiffness, steps):
    case = Incline(contact=contact, stiffness=stiffness, steps_per_contact=steps)
    if reason := code.traits.refuses_contact(contact):
        pytest.skip(reason)
    ours, theirs = (critical_angle(case, engine=e, phases=2) for e in (code, reference_of(code)))
    assert ours.value_deg == pytest.approx(theirs.value_deg, abs=1e-8)
    if contact is PLASTIC:
        assert abs(ours.value_deg - closed_form()) < 0.02 * (1e5 / stiffness) ** 0.5


@pytest.mark.slow
@pytest.mark.parametrize("height", [1, 4, 19])
@ALL
def test_a_tower_is_the_exact_one_in_second_order(code, height):
    case, errors = Tower(height=height, law="overlap", stiffness=1e5), []
    for steps in (500.0, 8000.0):
        (run,) = run_towers(code, [case], 3.0, steps_per_contact=steps, samples=3000)
        errors.append(force_difference(run))
    truth = tower(case, solver="exact", duration=3.0, samples=3000)
    assert run.grain_force.max() == pytest.approx(truth.grain_force.max(), rel=2e-5)
    assert impulse(run) == pytest.approx(impulse(truth), rel=2e-5)
    # where in a step a contact parts jitters about the second order
    assert np.log2(errors[0] / errors[1]) / 4.0 == pytest.approx(2.0, abs=0.3)


@pytest.mark.slow
@pytest.mark.parametrize("changes", KINDS)
@ALL
def test_every_kind_of_tower_is_the_exact_one(code, changes):
    case = Tower(**{"height": 4, "law": "overlap", "stiffness": 1e5, **changes})
    (run,) = run_towers(code, [case], 3.0, steps_per_contact=2000.0)
    # a step is omega h = pi / 2000 of the peak in a scheme of order 1
    assert force_difference(run) < np.pi / 2000.0
    last = tower(case, solver="exact", duration=3.0).final_velocity
    assert run.final_velocity == pytest.approx(last, abs=2e-3 * case.speed)


@pytest.mark.slow
@ALL
def test_a_preloaded_tower_below_a_grain_that_rests_stays_at_rest(code):
    case = Tower(height=5, start="preloaded", speed=0.0, law="overlap", stiffness=1e5)
    (run,) = run_towers(code, [case], 0.01, steps_per_contact=500.0, profiles=True)
    # nothing holds the grain yet: it falls freely, and the particles below do not feel it yet
    assert run.grain_velocity[1] == pytest.approx(9.81 * run.time[1], rel=1e-3)
    weights = 9.81 * np.arange(1, 5)
    assert run.profiles.forces[0] == pytest.approx([0.0, *weights], abs=1e-9)


COMMANDS = {
    "liggghts": (["liggghts", "-log", "none", "-in"], {**os.environ, **ALONE}),
    "yade": (["yade", "-n", "-x"], {"PATH": "/usr/bin:/bin"}),
    "kratos": ([sys.executable], dict(os.environ)),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", ["drop", "incline", "tower"])
@ALL
def test_a_script_runs_alone_and_writes_its_table(code, name):
    script = f"{name}.{code.extension}"
    with fresh_folder() as folder:
        (folder / script).write_text(generated_inputs(code.name)[script])
        words, environment = COMMANDS[code.name]
        done = subprocess.run(
            [*words, script],
            cwd=folder,
            env={**environment, "HOME": str(folder)},
            capture_output=True,
            text=True,
            errors="replace",  # LIGGGHTS prints memory that it did not set
            check=True,
        )
        assert "RESULT verdict = finished\n" in done.stdout
        rows = (folder / f"{name}.csv").read_text("utf-8").splitlines()
    assert len(rows) > 10
