"""Columns: at rest, under both laws, in two codes, and as the incline for one particle."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from harness.cases.columns.case import CASE
from harness.cases.columns.system import (
    Columns,
    crest_energy,
    critical_angle,
    loaded,
    run_columns,
    scene_of,
    sinking,
    start_load,
    start_of,
    values_of,
)
from harness.cases.incline import system
from harness.cases.incline.system import Incline
from harness.cases.source_angles import impulse_ratio, source_angles
from harness.cases.verification import Study
from harness.comparison.verdicts import Verdict, missing_from
from harness.engines.lammps.engine import Lammps
from harness.engines.reference import Reference
from harness.errors import RequestError
from harness.parameters.law import PLASTIC
from harness.parameters.tower import LAWS
from harness.solvers.chain.forces import contact_forces
from harness.solvers.grain.columns import accelerate, compress, held_of
from harness.solvers.grain.row import Grain, row_of
from harness.theory.incline import critical_angle as closed_form

SOFT = Columns(n=5, contact=PLASTIC, steps_per_contact=100.0, stiffness=1e5)


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("n", [1, 2, 5])
def test_columns_start_at_rest(law, n):
    case = SOFT.replace(law=law, n=n)
    scene = scene_of(values_of(case, "steady"))
    row, held = row_of(scene), held_of(scene, row_of(scene))
    held.awake[:] = True
    away = Grain(0.5 * case.diameter, 3.0 * case.diameter, 0.0, 0.0)
    along, normal = accelerate(away, 0.0, 0.0, row, held)
    assert (along, normal) == scene.gravity
    # k / m times the rounding of places of some diameters
    assert np.abs(held.a).max() < case.stiffness / case.mass * n * 1e-15


@pytest.mark.parametrize("law", LAWS)
def test_a_passage_starts_with_the_first_column_in_balance(law):
    case = SOFT.replace(law=law)
    scene = scene_of(values_of(case, "passage"))
    row, held = row_of(scene), held_of(scene, row_of(scene))
    x, y = scene.position[0]
    accelerate(Grain(x, y, 0.0, 0.0), 0.0, 0.0, row, held._replace(damping=0.0))
    assert held.awake.tolist() == [True, False, False, False]
    assert np.abs(held.a).max() < case.stiffness / case.mass * 1e-14


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("n", [1, 2, 3, 9])
def test_the_energy_of_a_load_is_the_work_it_does(law, n):
    case = SOFT.replace(law=law, n=n)
    force, beta = start_load(case)
    whole = loaded(case, force, beta)
    assert sinking(case, force, beta)[0] - sinking(case)[0] == pytest.approx(whole.sunk, abs=1e-16)
    parts = np.linspace(0.0, force, 21)
    at = [loaded(case, f, beta) for f in parts]
    way = np.diff([p.overlap for p in at]) + np.cos(beta) * np.diff([p.sunk for p in at])
    work = float(np.sum(0.5 * (parts[1:] + parts[:-1]) * way))
    assert whole.energy == pytest.approx(work, rel=1e-9)


def test_the_deformable_column_at_rest_has_the_closed_form():
    case = SOFT.replace(law="deformable", angle=0.0)
    pressed = case.mass * case.gravity / case.stiffness
    n = case.n
    own = [2 * i for i in range(1, n - 1)] + [(3 * (n - 1) - 1) / 2]
    depth = [sum(own[j:]) * pressed for j in range(n)]
    assert sinking(case) == pytest.approx(depth, abs=1e-17)


@pytest.mark.parametrize("route", ["passage", "steady"])
@pytest.mark.parametrize("law", LAWS)
def test_one_particle_starts_as_the_incline(route, law):
    case = SOFT.replace(n=1, law=law, phase=0.3)
    same = {name: getattr(case, name) for name in Incline.model_fields}
    incline = Incline(**same)
    assert start_of(case, route).state() == pytest.approx(
        system.start_of(incline, route).state(), rel=1e-12, abs=1e-15
    )
    springs = 0.5 * (case.mass * case.gravity) ** 2 / case.stiffness
    assert crest_energy(case) == pytest.approx(system.crest_energy(incline) - springs, rel=1e-14)


# below half the reach, which the chain solver refuses: a sum of places may round beyond it
@given(st.lists(st.floats(-1.0, 1.0 - 1e-12), min_size=1, max_size=9))
def test_the_kernel_finds_the_contacts_of_the_chain_solver(overlaps):
    overlap = np.array(overlaps)
    press, work = np.empty(overlap.size), np.zeros((4, overlap.size))
    assert compress(overlap, np.ones(overlap.size, dtype=np.bool_), press, work)
    places = np.concatenate([[0.0], np.cumsum(2.0 - overlap)])
    expected = contact_forces(places, 2.0, 1.0)
    assert press == pytest.approx(expected, abs=1e-12)


@pytest.fixture(scope="module")
def lammps():
    with Lammps(workers=1) as engine:
        yield engine


def test_lammps_is_the_incline_for_one_particle_and_the_reference_dem_above(lammps):
    found = CASE.verification.run(lammps, Study(level="quick"))
    assert missing_from(found.checks, CASE.verification.planned("quick", lammps)) == []
    assert {check.verdict for check in found.checks} == {Verdict.PASS}, found.checks


def test_another_coefficient_is_seen(lammps):
    """What the comparison of two codes would miss, it could not vouch for."""
    case = SOFT.replace(n=3, angle=10.6)
    (run,) = run_columns(lammps, [case], "passage")
    (other,) = run_columns(Reference(), [case.replace(inside="elastic")], "passage")
    assert abs(run.margin - other.margin) > 1e-4


def test_damped_columns_hardly_lower_the_angle_and_elastic_ones_raise_it():
    engine = Reference()
    damped = critical_angle(SOFT, engine)
    assert closed_form() - 0.05 < damped.value_deg < closed_form()
    elastic = SOFT.replace(inside="elastic", angle=closed_form())
    (run,) = run_columns(engine, [elastic], "passage")
    assert run.motion == "trapped"


def test_the_sources_angles_are_those_of_its_impulse_ratio():
    assert impulse_ratio(2, "overlap") == pytest.approx(0.626299, abs=2e-6)
    angles = source_angles(2, "overlap")
    assert angles["lost"] < closed_form() < angles["kept"]


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ({"n": 0}, r"n = 0"),
        ({"n": 40, "stiffness": 1e4}, r"too soft for columns of n = 40.* must be at least"),
        ({"steps_per_contact": 62.0}, r"steps_per_contact = 62 is unstable"),
        ({"law": "wet"}, r"law = 'wet'"),
    ],
)
def test_what_columns_cannot_be_is_refused(changes, told):
    with pytest.raises(RequestError, match=told):
        SOFT.replace(**changes)


def test_other_integrators_say_why_they_cannot():
    job = CASE.job(SOFT)
    assert "velocity-verlet only" in Reference("rk4").refuses(job)
    assert Reference().refuses(job) == ""
