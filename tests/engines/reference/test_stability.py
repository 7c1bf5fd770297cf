"""The bound of each integrator, against closed forms and against runs on either side of it."""

import math

import numpy as np
import pytest

from harness.cases.incline.runs import follow, run_inclines
from harness.cases.incline.system import Incline, start_in_well
from harness.engines.reference import INTEGRATORS, Reference
from harness.errors import RequestError
from harness.parameters.law import PLASTIC, SOURCE
from harness.solvers.grain.row import (
    FIXED_STEP,
    Grain,
    Row,
    advance,
    begin,
    fewest_steps_per_contact,
)

ZETAS = (0.01, 0.2, 0.7, 0.99768, 5.0)


@pytest.mark.parametrize("method", ["velocity-verlet", "mfix-euler"])
@pytest.mark.parametrize("zeta", [0.0, *ZETAS])
def test_of_velocity_verlet_and_of_mfix_s_euler_it_is_jury_s(method, zeta):
    largest = 2.0 * (math.sqrt(zeta**2 + 2.0 / 3.0) - zeta)
    found = fewest_steps_per_contact(FIXED_STEP[method].growth, zeta)
    assert found == pytest.approx(math.pi / largest, rel=1e-6)


@pytest.mark.parametrize("zeta", ZETAS)
def test_of_adams_bashforth_it_is_jury_s_for_the_cubic(zeta):
    """c < 1/2 at the root -1, and c + (c + 2 b)(c - b) > 0 for the complex pair."""

    def stable(step):
        b, c = 0.375 * step**2, 1.5 * zeta * step
        return c < 0.5 and c + (c + 2.0 * b) * (c - b) > 0.0

    largest = math.pi / fewest_steps_per_contact(FIXED_STEP["mfix-adams-bashforth"].growth, zeta)
    assert stable(largest * (1 - 1e-6))
    assert not stable(largest * (1 + 1e-6))
    assert all(stable(largest * part) for part in np.linspace(0.01, 0.99, 99))


def test_adams_bashforth_without_damping_is_unstable_at_every_step():
    assert fewest_steps_per_contact(FIXED_STEP["mfix-adams-bashforth"].growth, 0.0) == math.inf
    with pytest.raises(RequestError, match=r"mfix-adams-bashforth at damping ratio 0: .*damping"):
        run_inclines(
            Reference("mfix-adams-bashforth"),
            [Incline(contact=SOURCE.replace(restitution=1.0))],
            "passage",
        )


def test_of_rk4_it_is_the_limit_on_the_imaginary_and_on_the_real_axis():
    imaginary = fewest_steps_per_contact(FIXED_STEP["rk4"].growth, 0.0)
    assert imaginary == pytest.approx(math.pi / (2 * math.sqrt(2) / math.sqrt(1.5)), rel=1e-3)
    zeta = 50.0  # the fast rate is all but 3 zeta omega
    real = fewest_steps_per_contact(FIXED_STEP["rk4"].growth, zeta)
    assert real == pytest.approx(math.pi * 3 * zeta / 2.785293563, rel=1e-3)


@pytest.mark.parametrize("name", FIXED_STEP)
@pytest.mark.parametrize("zeta", [0.2, 0.99768, 5.0])
@pytest.mark.parametrize(("factor", "grows"), [(0.99, True), (1.01, False)])
def test_the_kernels_in_a_well_grow_below_the_bound_and_settle_above_it(name, zeta, factor, grows):
    """The grain pressed into a level well and touched: at the bound the motion changes its fate."""
    number, growth = FIXED_STEP[name]
    step = math.pi / (factor * fewest_steps_per_contact(growth, zeta))  # k = m = 1: omega = 1
    # so large a diameter that the angle of the contacts stays, and gravity that keeps them
    row = Row(1e9, 1.0, 1.0, 2.0 * zeta, False, 0.0, -1.0, math.pi)
    rest = math.sqrt(0.75) * row.diameter - 2.0 / 3.0 + 1e-4
    grain = begin(number, Grain(0.5 * row.diameter, rest, 0.0, 0.0), row)
    early = max(abs(advance(number, grain, row, step, n).vy) for n in range(1, 20))
    late = max(abs(advance(number, grain, row, step, n).vy) for n in range(1500, 1520))
    assert (late > early) is grows


@pytest.mark.parametrize(
    ("integrator", "contact", "steps"),
    [
        ("mfix-adams-bashforth", PLASTIC, 40.0),
        ("mfix-adams-bashforth", SOURCE, 6.0),
        ("rk4", PLASTIC, 24.0),
    ],
)
def test_an_unstable_step_is_refused_with_the_bound(integrator, contact, steps):
    case = Incline(contact=contact, steps_per_contact=steps)
    with Reference(integrator) as engine:
        if integrator == "rk4":  # reaches further than what every incline asks for
            assert not isinstance(run_inclines(engine, [case], "steady")[0], Exception)
            return
        with pytest.raises(RequestError, match=f"steps_per_contact = {steps:g} is unstable with"):
            run_inclines(engine, [case], "steady")
        with pytest.raises(RequestError, match="must be greater than"):
            follow(engine, case, start_in_well(case), 1.0)


def test_unknown_integrator_is_named_with_those_that_exist():
    with pytest.raises(RequestError, match=r"--integrator 'leapfrog'.*velocity-verlet.*adaptive"):
        Reference("leapfrog")
    assert len(set(INTEGRATORS)) == 5
