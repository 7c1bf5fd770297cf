"""The deformable law as LAMMPS's external force: its conditions, and Newton's third law."""

from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from harness.engines.lammps.inprocess import DeformableLaw, ExternalForce, row_force
from harness.solvers.chain import contact_forces

STIFFNESS, DIAMETER = 1e6, 1.0
LAMMPS = SimpleNamespace(numpy=SimpleNamespace(extract_atom=lambda _: np.zeros((9, 3))))


def _positions(overlaps):
    return DIAMETER * np.arange(len(overlaps) + 1) - np.concatenate([[0.0], np.cumsum(overlaps)])


@settings(deadline=None)
@given(st.lists(st.floats(-1e-3, 1e-3), min_size=1, max_size=30))
def test_the_conditions_hold_and_the_chain_solver_agrees(overlaps):
    x, n = _positions(overlaps), len(overlaps)
    overlap = DIAMETER - np.diff(x)
    force = DeformableLaw(n, STIFFNESS).forces(overlap)
    matrix = np.eye(n) + 0.5 * np.eye(n, k=1) + 0.5 * np.eye(n, k=-1)
    gap = matrix @ force / STIFFNESS - overlap
    scale = max(np.abs(overlap).max(), 1e-15)
    assert gap.min() >= -1e-9 * scale
    assert force.min() >= -1e-9 * scale * STIFFNESS
    assert abs(force @ gap) <= 1e-9 * STIFFNESS * scale**2
    other = contact_forces(x, DIAMETER, STIFFNESS)
    # positions resolve eps of the row's length; T is as ill conditioned as the row is long
    resolution = 8 * np.finfo(float).eps * n * (n + 1) ** 2 * STIFFNESS
    np.testing.assert_allclose(force, other, atol=max(resolution, 1e-9 * STIFFNESS * scale))


def test_overlaps_of_exactly_zero():
    # SciPy's NNLS returns a wrong contact set here: particles of a tower in free fall
    displacement = np.array([7.5446685e-4, 1.9666804e-5, *[7.3209345e-7] * 7, 7.2303354e-7, 0.0])
    overlap = -np.diff(displacement)
    force = DeformableLaw(10, STIFFNESS).forces(overlap)
    assert force[0] == pytest.approx(STIFFNESS * overlap[0], rel=1e-9)
    assert np.all(force[1:9] <= 1e-9 * force[0])


def test_the_last_set_of_contacts_does_not_decide_the_next():
    law, rng = DeformableLaw(8, STIFFNESS), np.random.default_rng(3)
    for _ in range(200):
        overlap = rng.normal(0, 1e-3, 8)
        fresh = DeformableLaw(8, STIFFNESS).forces(overlap)
        np.testing.assert_allclose(law.forces(overlap), fresh, atol=1e-9 * STIFFNESS)


def test_called_by_lammps_it_orders_by_id_and_obeys_newton():
    force = ExternalForce(row_force(3, STIFFNESS, DIAMETER))
    x = np.zeros((4, 3))
    x[:, 0] = _positions([1e-3, 5e-4, -1e-3])
    f, g = np.full((4, 3), np.nan), np.full((4, 3), np.nan)
    force(LAMMPS, 0, 4, np.array([1, 2, 3, 4]), x, f)
    shuffled = np.array([2, 0, 3, 1])
    force(LAMMPS, 0, 4, np.array([1, 2, 3, 4])[shuffled], x[shuffled], g)
    np.testing.assert_array_equal(g, f[shuffled])
    assert f[:, 0].sum() == pytest.approx(0.0, abs=1e-9)
    assert np.all(f[:, 1:] == 0.0)


def test_positions_that_are_not_numbers_stop_the_run():
    force = ExternalForce(row_force(2, STIFFNESS, DIAMETER))
    x = np.array([[0.0, 0, 0], [np.nan, 0, 0], [2.0, 0, 0]])
    f = np.zeros((3, 3))
    force(LAMMPS, 0, 3, np.array([1, 2, 3]), x, f)
    assert np.isnan(f[:, 0]).all()
    assert force.failure
