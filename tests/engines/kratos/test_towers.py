"""Towers of Kratos's other integrator against the exact solution of the overlap law."""

import numpy as np
import pytest

from harness.engines.kratos.engine import Kratos
from harness.observables.tower import impulse
from harness.parameters.tower import Tower
from harness.solvers.chain import exact
from tests.engines.tower_runs import KINDS, force_difference, run

pytestmark = [pytest.mark.live, pytest.mark.slow]

SCHEME = "Symplectic_Euler"


def tower(height, **changes):
    return Tower(height=height, law="overlap", stiffness=1e5, **changes)


@pytest.mark.usefixtures("kratos_here")
def test_order_of_convergence():
    """Symplectic Euler is leapfrog told half a step askew: its velocities are of order 1."""
    case = tower(2)
    with Kratos(scheme=SCHEME) as engine:
        runs = [run(engine, case, steps_per_contact=n) for n in (500.0, 1000.0, 2000.0)]
    wanted = impulse(exact.run(case, runs[0].time[-1]))
    errors = [abs(impulse(found) / wanted - 1.0) for found in runs]
    assert np.log2(errors[0] / errors[1]) == pytest.approx(1.0, abs=0.2)
    assert np.log2(errors[1] / errors[2]) == pytest.approx(1.0, abs=0.2)


@pytest.mark.parametrize("changes", KINDS)
@pytest.mark.usefixtures("kratos_here")
def test_every_kind_of_tower(changes):
    case = Tower(**{"height": 3, "law": "overlap", "stiffness": 1e5, **changes})
    with Kratos(scheme=SCHEME) as engine:
        found = run(engine, case, steps_per_contact=2000.0)
    # a step is omega h = pi / 2000 of the peak in a scheme of order 1
    assert force_difference(found) < np.pi / 2000.0
    last = exact.run(case, found.time[-1]).final_velocity
    assert found.final_velocity == pytest.approx(last, abs=2e-3 * case.speed)
