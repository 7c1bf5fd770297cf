"""The reference DEM as an engine: routes, adaptive against fixed steps, what it refuses."""

import math

import numpy as np
import pytest

from harness.cases.incline.critical_angles import critical_angle
from harness.cases.incline.parameters import Incline
from harness.cases.incline.result import Motion
from harness.cases.incline.routes import Start, start_in_well
from harness.engines.reference.engine import Reference
from harness.engines.registry import open_engine
from harness.errors import EngineNaNError, EngineTimeoutError, RequestError
from harness.parameters.contact import CLIPPED, PLASTIC, SOURCE
from harness.parameters.tower import Tower


@pytest.mark.parametrize("contact", [SOURCE, CLIPPED, PLASTIC], ids=lambda c: c.name)
def test_adaptive_is_where_rk4_goes_with_ever_smaller_steps(contact):
    """A change of contacts falls anywhere in a step: first order across it, the finest to 1e-5."""
    case = Incline(angle=10.2, contact=contact, stiffness=1e5)
    (exact,) = Reference("adaptive").inclines([case], "passage")
    fine = [case.replace(steps_per_contact=steps) for steps in (400.0, 6400.0)]
    coarse, finest = (
        abs(run.margin_J - exact.margin_J) / case.weight_energy
        for run in Reference("rk4").inclines(fine, "passage")
    )
    assert finest < 2e-5
    assert finest < coarse


def test_without_a_step_the_source_s_angle_is_above_the_closed_form():
    """About 10.26 deg at k = 1e6 N/m: the attractive tail holds back the contact being left."""
    found = critical_angle(Incline(), engine=Reference("adaptive"), phases=1)
    assert found.value_deg == pytest.approx(10.26, abs=0.015)
    assert found.provenance.integrator == "adaptive"


def test_adaptive_ignores_the_step():
    runs = [
        Reference("adaptive").inclines([Incline(steps_per_contact=steps)], "passage")[0]
        for steps in (50.0, 80.0)
    ]
    assert runs[0].margin_J == pytest.approx(runs[1].margin_J, abs=1e-9)


@pytest.mark.parametrize("integrator", ["velocity-verlet", "adaptive"])
def test_fates_of_the_steady_route(integrator):
    cases = [Incline(angle=angle, contact=PLASTIC, stiffness=1e5) for angle in (8.0, 10.6)]
    cases = [case.replace(steps_per_contact=100.0, wells=2) for case in cases]
    low, high = Reference(integrator).inclines(cases, "steady")
    assert low.motion is Motion.TRAPPED
    assert low.margin_J < 0.0
    assert high.motion is Motion.MOVES_ON
    assert len(high.crests.time_s) == 2
    assert np.all(high.crests.margin_J > 0.0)
    assert high.touching


def test_a_run_cut_off_by_time_is_undecided():
    case = Incline(time_limit=0.1)
    (run,) = Reference().inclines([case], "steady")
    assert run.motion is Motion.UNDECIDED
    assert run.time_s == pytest.approx(0.1 / math.sqrt(9.81), abs=case.step)


def test_samples_are_every_so_many_steps():
    case = Incline(angle=10.6, wells=1)
    (fixed,) = Reference().inclines([case], "steady", every=100)
    (free,) = Reference("adaptive").inclines([case], "steady", every=100)
    for run in (fixed, free):
        steps = run.trajectory.time_s / case.step
        np.testing.assert_allclose(steps, 100.0 * np.arange(len(steps)), rtol=1e-9)
    rows = min(len(fixed.trajectory.x_m), len(free.trajectory.x_m))
    np.testing.assert_allclose(fixed.trajectory.x_m[:rows], free.trajectory.x_m[:rows], atol=0.02)


def test_towers_are_refused():
    with pytest.raises(RequestError, match="states the incline only"):
        Reference().towers([Tower(height=2)], 3.0)


@pytest.mark.parametrize("integrator", ["velocity-verlet", "mfix-euler", "rk4"])
def test_an_overflow_is_an_error_that_names_nan(integrator):
    case = Incline()
    with pytest.raises(EngineNaNError, match="NaN"):
        Reference(integrator).follow(case, Start(0.5, 0.5, 1e308, 1e308), 100 * case.step)


def test_an_overflow_leaves_the_other_runs_alone():
    start = Start(0.5, 0.5, 1e308, 1e308)
    (failed,) = Reference().inclines([Incline()], "steady", start=start)
    assert isinstance(failed, EngineNaNError)


@pytest.mark.parametrize("integrator", ["velocity-verlet", "adaptive"])
def test_a_run_that_takes_too_long_is_given_up(integrator):
    case = Incline(stiffness=1e12, steps_per_contact=1e4, angle=0.0)
    engine = Reference(integrator, seconds=0.2)
    (found,) = engine.inclines([case], "steady", start=Start(0.5, 2.0, 0.0, 0.0))
    assert isinstance(found, EngineTimeoutError)


@pytest.mark.parametrize(
    ("start", "duration", "every", "words"),
    [
        (Start(0.5, math.nan, 0.0, 0.0), 1.0, 1, "finite numbers"),
        (Start(0.5, 0.9, 0.0, 0.0), 0.0, 1, "greater than 0"),
        (Start(0.5, 0.9, 0.0, 0.0), math.inf, 1, "greater than 0"),
        (Start(0.5, 0.9, 0.0, 0.0), 1.0, 0, "at least 1 step"),
    ],
)
def test_bad_requests(start, duration, every, words):
    with pytest.raises(RequestError, match=words):
        Reference().follow(Incline(), start, duration, every=every)


def test_options_of_another_engine_are_refused():
    with pytest.raises(RequestError, match=r"--lmp 'lmp' is an option of --engine lammps"):
        open_engine("reference", lmp="lmp")
    with pytest.raises(RequestError, match=r"--integrator 'rk4' is an option of --engine ref"):
        open_engine("lammps", integrator="rk4")
    with open_engine("reference", integrator="rk4") as engine:
        assert engine.identify().integrator == "rk4"


def test_the_start_in_a_well_does_not_feel_its_last_digit():
    """It touches both spheres: the one behind shall not pull because of a rounding."""
    case = Incline(angle=0.0)
    path = Reference().follow(case, start_in_well(case), case.step)
    assert path.vx_m_per_s[1] == pytest.approx(path.vx_m_per_s[0], rel=1e-3)
