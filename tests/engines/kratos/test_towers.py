"""Towers of Kratos against the exact solution of the overlap law."""

import numpy as np
import pytest

from harness.engines.kratos.engine import Kratos
from harness.observables.windows import impulse
from harness.parameters.tower import Tower
from harness.solvers.chain import exact
from tests.engines.tower_runs import KINDS, force_difference, run

pytestmark = [pytest.mark.live, pytest.mark.slow]

FINE = 8000.0


def tower(height, **changes):
    return Tower(height=height, law="overlap", stiffness=1e5, **changes)


@pytest.mark.parametrize("height", [1, 2, 4, 9, 19])
def test_peak_and_impulse_are_the_exact_ones(kratos, height):
    found = run(kratos, tower(height), steps_per_contact=FINE, samples=3000)
    reference = exact.run(found.tower, found.time[-1], samples=len(found.time) - 1)
    assert found.grain_force.max() == pytest.approx(reference.grain_force.max(), rel=2e-5)
    assert impulse(found) == pytest.approx(impulse(reference), rel=2e-5)


@pytest.mark.parametrize(("scheme", "order"), [("Velocity_Verlet", 2), ("Symplectic_Euler", 1)])
@pytest.mark.usefixtures("kratos_here")
def test_order_of_convergence(scheme, order):
    """Symplectic Euler is leapfrog told half a step askew: its velocities are of order 1."""
    case = tower(2)
    with Kratos(scheme=scheme) as engine:
        runs = [run(engine, case, steps_per_contact=n) for n in (500.0, 1000.0, 2000.0)]
    wanted = impulse(exact.run(case, runs[0].time[-1]))
    errors = [abs(impulse(found) / wanted - 1.0) for found in runs]
    assert np.log2(errors[0] / errors[1]) == pytest.approx(order, abs=0.2)
    assert np.log2(errors[1] / errors[2]) == pytest.approx(order, abs=0.2)


@pytest.mark.parametrize("changes", KINDS)
@pytest.mark.parametrize("scheme", ["Velocity_Verlet", "Symplectic_Euler"])
@pytest.mark.usefixtures("kratos_here")
def test_every_kind_of_tower(scheme, changes):
    case = Tower(**{"height": 3, "law": "overlap", "stiffness": 1e5, **changes})
    with Kratos(scheme=scheme) as engine:
        found = run(engine, case, steps_per_contact=2000.0)
    # a step is omega h = pi / 2000 of the peak in a scheme of order 1
    assert force_difference(found) < np.pi / 2000.0
    last = exact.run(case, found.time[-1]).final_velocity
    assert found.final_velocity == pytest.approx(last, abs=2e-3 * case.speed)
