"""Columns: at rest, under both laws, in two programs, and as the incline for one particle."""

import math
from dataclasses import replace

import numpy as np
import pytest

from harness.cases.bench import Bench
from harness.cases.checks import run_checks, selected
from harness.cases.incline.columns import (
    CASE,
    SOURCE_ANGLES,
    Columns,
    job_of,
    run_at_equal_steps,
    scene_of,
    sinking,
)
from harness.cases.incline.runs import Fate, loaded, read, start_load
from harness.cases.tower.impulse import source_angles
from harness.results.rows import Verdict
from harness.solvers import chain_stepped, reference
from harness.theory.chain import LAWS
from harness.theory.incline import critical_angle as rigid_angle
from tests.cases.common import assert_refused, verdicts
from tests.cases.scene_faults import coefficient, scaled
from tests.engine_doubles import FewDigits, Twin

SOFT = Columns(n=5, stiffness=1e5)
OWN = Bench(None)


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("n", [2, 5])
def test_columns_start_at_rest(law, n):
    case = SOFT.replace(law=law, n=n)
    scene = scene_of(case, "steady")
    overlap = case.diameter + np.diff([body.position[1] for body in scene.bodies[1 : n + 1]])
    press = np.arange(n) * case.weight * math.cos(case.tilt) / case.stiffness
    coupled = 0.5 * (np.eye(n, k=1) + np.eye(n, k=-1)) if law == "deformable" else 0.0
    assert ((np.eye(n) + coupled) @ press)[1:] == pytest.approx(overlap, abs=1e-15)


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("n", [1, 2, 3, 9])
def test_the_energy_of_a_load_is_its_work(law, n):
    case = SOFT.replace(law=law, n=n)
    force, phi = start_load(case)
    beta = phi - case.tilt
    whole, top = loaded(case, force, beta), sinking(case, force, force * math.cos(beta))[0]
    assert top - sinking(case)[0] == pytest.approx(whole.sunk, abs=1e-16)
    parts = np.linspace(0.0, force, 21)
    at = [loaded(case, f, beta) for f in parts]
    way = np.diff([p.overlap for p in at]) + np.cos(beta) * np.diff([p.sunk for p in at])
    work = float(np.sum(0.5 * (parts[1:] + parts[:-1]) * way))
    assert whole.energy == pytest.approx(work, rel=1e-9)


@pytest.mark.parametrize("inside", ["damped", "elastic"])
def test_both_laws_are_one_for_columns_of_one_and_differ_above(inside):
    """The chain's program and the reference share no code: of one particle they are equal."""
    for n, equal in ((1, True), (2, False)):
        case = Columns(n=n, stiffness=1e4, angle=10.6, inside=inside)
        stages = chain_stepped.run_columns(scene_of(case), n)
        found = reference.run(scene_of(case)).stages
        assert bool(np.abs(stages - found).max() < 1e-11) is equal


def test_damped_columns_hardly_lower_the_angle_and_elastic_ones_raise_it():
    for law in LAWS:
        case = SOFT.replace(law=law)
        damped = CASE.critical_angle(case, OWN, starts=2)
        assert rigid_angle() - 0.06 < damped.value < rigid_angle()
        elastic = case.replace(inside="elastic", angle=rigid_angle())
        assert run_at_equal_steps(OWN, elastic).fate is Fate.TRAPPED


def test_the_angles_of_the_source_are_those_of_towers():
    for (law, height), angles in SOURCE_ANGLES.items():
        assert angles == pytest.approx(source_angles(height, law), rel=1e-12)


def test_findings_against_the_source():
    rows = run_checks("columns", selected("columns", CASE.own_checks(), "quick"), OWN)
    assert {row.verdict for row in rows} == {Verdict.FINDING}
    assert len(rows) == 4
    assert all(abs(row.value - 10.196) < 2e-3 for row in rows)


# ---- an engine


def rows_of(engine):
    return run_checks("columns", list(CASE.checks(engine)), Bench(engine))


def test_a_right_engine_passes_also_with_few_digits_and_lacks_the_deformable_law():
    rows = rows_of(Twin())
    lacking = [row for row in rows if "deformable" in row.setup]
    assert verdicts(lacking) == {Verdict.NOT_TESTED}
    assert verdicts(row for row in rows if row not in lacking) == {Verdict.PASS}
    assert Verdict.FAIL not in verdicts(rows_of(FewDigits()))


def inner(**changes):
    """Return a fault of the law within columns."""
    return lambda scene: scene.replace(laws={(1, 1): scene.law.replace(**changes)})


FAULTS = {
    "stiffness off by 1e-6": coefficient("normal_stiffness", 1 + 1e-6),
    "dashpot off by 1e-6": coefficient("damping_coefficient", 1 + 1e-6),
    "no dashpots within": inner(damping="none"),
    "softer within": inner(normal_stiffness=2000.002),
    "gravity off by 1e-6": scaled("gravity", 1 + 1e-6),
    "step off by 1e-6": scaled("step", 1 + 1e-6),
    "columns that move sideways": lambda s: s.replace(
        bodies=tuple(body.replace(axes=(True, True, False)) for body in s.bodies)
    ),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_planted_faults(fault):
    engine = Twin(lambda scene: FAULTS[fault](scene) if scene.pairs else scene)
    setup = "overlap law, damped, n = 3, k = 2e3 N/m"
    assert [row.verdict for row in rows_of(engine) if row.setup == setup] == [Verdict.FAIL]


def test_a_path_off_the_inclines_is_seen():
    longer = scaled("step", 1 + 1e-9)
    row = rows_of(Twin(lambda s: longer(s) if s.law.damping == "velocity" else s))[0]
    assert (row.quantity, row.verdict) == ("path_difference_m", Verdict.FAIL)


@pytest.mark.parametrize("fault", ["step", "samples"])
def test_a_fault_that_both_paths_share_is_seen(fault):
    def late(_, motion):
        chosen = np.maximum(np.arange(len(motion)) - 1, 0)
        return replace(motion, position=motion.position[chosen], velocity=motion.velocity[chosen])

    engine = Twin(scaled("step", 1 + 1e-9)) if fault == "step" else Twin(change_motion=late)
    row = rows_of(engine)[0]
    assert (row.quantity, row.verdict) == ("path_difference_m", Verdict.FAIL)


def test_two_paths_that_are_equal_as_neither_moves_are_a_failure():
    row = rows_of(Twin(change_motion=lambda _, m: replace(m, position=0.0 * m.position)))[0]
    assert (row.quantity, row.verdict) == ("path_difference_m", Verdict.FAIL)


def test_the_quantities_of_a_run_and_the_search():
    bench = Bench(Twin())
    measured = CASE.measure(SOFT, bench.output(CASE.job(SOFT)))
    assert set(measured) < {quantity.name for quantity in CASE.quantities}
    assert CASE.reference(SOFT, bench) == pytest.approx(measured)
    assert CASE.exact(SOFT)["critical_angle_deg"] == pytest.approx(10.2078, abs=1e-4)
    assert CASE.exact(SOFT.replace(inside="elastic")) == {}
    found = CASE.search(["critical_angle_deg"], SOFT, bench, starts=2)
    assert found["critical_angle_deg"].value == pytest.approx(10.18, abs=0.03)


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"n": 0}, r"n = 0"),
        ({"n": 40, "stiffness": 1e4}, r"too soft for columns of n = 40.* must be at least"),
        ({"stiffness": 100.0}, r"too soft"),
        ({"steps_per_contact": 62.0}, r"steps_per_contact = 62 is unstable"),
        ({"law": "wet"}, r"law = 'wet'"),
    ],
)
def test_bad_parameters(changes, said):
    assert_refused(said, SOFT.replace, **changes)


@pytest.mark.live
def test_lammps_is_the_incline_for_one_particle_and_equal_in_steps_above(lammps):
    rows = rows_of(lammps)
    assert verdicts(rows) == {Verdict.PASS}, rows
    assert len(rows) == 5


@pytest.mark.live
def test_a_run_cut_off_behind_the_first_top_is_undecided(lammps):
    case = Columns(angle=20.0, time_limit=1e-3)
    run = read(case, "passage", Bench(lammps).output(job_of(case)))
    assert run.fate is Fate.UNDECIDED
    assert run.touching
