"""The reference DEM as an engine: routes, adaptive against fixed steps, what it refuses."""

import math
from dataclasses import replace

import numpy as np
import pytest

from harness.cases.drop.case import Drop
from harness.cases.drop.case import scene_of as drop_scene
from harness.cases.drop.case import values_of as drop_values
from harness.cases.incline.angle import critical_angle
from harness.cases.incline.runs import follow, run_inclines, scene_from
from harness.cases.incline.system import Incline, Motion, Start, scene_of, start_in_well, values_of
from harness.cases.tower import system as tower
from harness.cases.tower.system import timing_of
from harness.engines.reference import INTEGRATORS, Reference
from harness.errors import EngineNaNError, EngineTimeoutError, RequestError
from harness.parameters.law import CLIPPED, PLASTIC, SOURCE
from harness.parameters.plane_scene import Stage
from harness.parameters.tower import Tower


@pytest.mark.parametrize("contact", [SOURCE, CLIPPED, PLASTIC], ids=lambda c: c.name)
def test_adaptive_is_where_rk4_goes_with_ever_smaller_steps(contact):
    """A change of contacts falls anywhere in a step: first order across it, the finest to 1e-5."""
    case = Incline(angle=10.2, contact=contact, stiffness=1e5)
    (exact,) = run_inclines(Reference("adaptive"), [case], "passage")
    fine = [case.replace(steps_per_contact=steps) for steps in (400.0, 6400.0)]
    coarse, finest = (
        abs(run.margin_J - exact.margin_J) / case.weight_energy
        for run in run_inclines(Reference("rk4"), fine, "passage")
    )
    assert finest < 2e-5
    assert finest < coarse


def test_without_a_step_the_source_s_angle_is_above_the_closed_form():
    """About 10.26 deg at k = 1e6 N/m: the attractive tail holds back the contact being left."""
    found = critical_angle(Incline(), engine=Reference("adaptive"), phases=1)
    assert found.value_deg == pytest.approx(10.26, abs=0.015)
    assert found.provenance.integrator == "adaptive"


@pytest.mark.parametrize("integrator", ["velocity-verlet", "adaptive"])
def test_fates_of_the_steady_route(integrator):
    cases = [Incline(angle=angle, contact=PLASTIC, stiffness=1e5) for angle in (8.0, 10.6)]
    cases = [case.replace(steps_per_contact=100.0, wells=2) for case in cases]
    low, high = run_inclines(Reference(integrator), cases, "steady")
    assert low.motion is Motion.TRAPPED
    assert low.margin_J < 0.0
    assert high.motion is Motion.MOVES_ON
    assert len(high.crests.time_s) == 2
    assert np.all(high.crests.margin_J > 0.0)
    assert high.touching


def test_a_run_cut_off_by_time_is_undecided():
    case = Incline(time_limit=0.1)
    (run,) = run_inclines(Reference(), [case], "steady")
    assert run.motion is Motion.UNDECIDED
    assert run.time_s == pytest.approx(0.1 / math.sqrt(9.81), abs=case.step)


def test_samples_are_every_so_many_steps():
    case = Incline(angle=10.6, wells=1)
    (fixed,) = run_inclines(Reference(), [case], "steady", every=100)
    (free,) = run_inclines(Reference("adaptive"), [case], "steady", every=100)
    for run in (fixed, free):
        steps = run.trajectory.time_s / case.step
        np.testing.assert_allclose(steps, 100.0 * np.arange(len(steps)), rtol=1e-9)
    rows = min(len(fixed.trajectory.x_m), len(free.trajectory.x_m))
    np.testing.assert_allclose(fixed.trajectory.x_m[:rows], free.trajectory.x_m[:rows], atol=0.02)


ARRAYS = ("position", "velocity", "mass", "diameter", "fixed")


def scene(**changes):
    """Return the scene of a passage, changed."""
    built = scene_of(values_of(Incline(), "passage"))
    arrays = {name: changes.pop(name) for name in ARRAYS if name in changes}
    return replace(built.with_spheres(**arrays), **changes)


@pytest.mark.parametrize(
    ("height", "said"),
    [(1, "it writes no forces"), (2, "it moves one particle, the first, not 2")],
)
def test_a_tower_is_refused(height, said):
    case = Tower(height=height, law="overlap")
    job = tower.job_of(case, timing_of(case, 3.0, None, None))
    assert Reference().refuses(job) == said
    with pytest.raises(RequestError, match=f"engine 'reference' cannot run 'tower': {said}"):
        Reference().run([job])


def moved(row, by):
    position = scene().position.copy()
    position[row] += by
    return position


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"fixed": np.arange(10) == 0}, "moves one particle, the first, not 9"),
        ({"diameter": np.array([0.5, *[1.0] * 9])}, "have one diameter"),
        ({"period": None}, "several fixed spheres must be an endless row"),
        ({"period": 10.0}, "touch in an endless row"),
        ({"position": moved(3, (0.0, 1e-6))}, "touch in an endless row"),
        ({"position": moved(3, (1e-6, 0.0))}, "touch in an endless row"),
        ({"velocity": np.full((10, 2), math.nan)}, "three finite numbers"),
        ({"every": -1}, "must be at least 0"),
        ({"steps": 0}, "must be at least 1"),
        ({"steps": 10**16}, r"must be at most 1e\+15"),
    ],
)
def test_a_scene_that_the_kernels_do_not_state_is_refused(changes, said):
    with pytest.raises(RequestError, match=said):
        Reference().run_scenes([scene(**changes)])


@pytest.mark.parametrize("integrator", ["velocity-verlet", "adaptive"])
def test_stages_leave_the_start_and_their_ends(integrator):
    case = Incline(angle=10.6, wells=2)
    built = scene_of(values_of(case, "steady"))
    (output,) = Reference(integrator).run_scenes([built])
    table = output.table(("time_s", "step", "x_m"))
    assert table["time_s"].shape == (3,)
    assert table["step"][0] == table["time_s"][0] == 0.0
    assert np.all(table["x_m"][1:] > [stage.place for stage in built.stages])
    (sampled,) = Reference(integrator).run_scenes([replace(built, every=7)])
    for name, column in sampled.tables["stages"].items():
        np.testing.assert_array_equal(column, output.tables["series"][name])


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_a_row_that_begins_elsewhere_is_the_same_row(integrator):
    """Places and energies of stages count from the scene's origin, wherever the row is."""
    here = scene(every=10, steps=2000)
    dx, dy = 0.25, -2.0
    lifted = -(here.gravity[0] * dx + here.gravity[1] * dy) * here.mass[0]
    stages = tuple(Stage(s.place + dx, s.floor + lifted) for s in here.stages)
    there = scene(every=10, steps=2000, position=here.position + np.array([dx, dy]), stages=stages)
    a, b = (Reference(integrator).run_scenes([s])[0].tables for s in (here, there))
    for table in ("series", "stages"):
        assert len(a[table]["x_m"]) == len(b[table]["x_m"])
        np.testing.assert_allclose(b[table]["x_m"] - dx, a[table]["x_m"], atol=1e-9)
        np.testing.assert_allclose(b[table]["y_m"] - dy, a[table]["y_m"], atol=1e-9)


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_one_sphere_has_no_neighbours(integrator):
    """A grain that slides off it sideways falls where the next one of a row would stop it."""
    drop = Drop(speed=0.5, sideways=2.0, gravity=9.81, steps_per_contact=100.0)
    built = replace(drop_scene(drop_values(drop)), steps=60_000, every=0)
    (output,) = Reference(integrator).run_scenes([built])
    end = {name: column[-1] for name, column in output.tables["series"].items()}
    assert end["time_s"] == pytest.approx(60_000 * drop.step)
    assert end["x_m"] > 1.0
    assert end["y_m"] < 0.0


@pytest.mark.parametrize("integrator", ["velocity-verlet", "mfix-euler", "rk4"])
def test_an_overflow_is_an_error_that_names_nan(integrator):
    case = Incline()
    with pytest.raises(EngineNaNError, match="NaN"):
        follow(Reference(integrator), case, Start(0.5, 0.5, 1e308, 1e308), 100 * case.step)


@pytest.mark.parametrize("integrator", ["velocity-verlet", "adaptive"])
def test_a_run_that_takes_too_long_is_given_up(integrator):
    case = Incline(stiffness=1e12, steps_per_contact=1e4, angle=0.0)
    engine = Reference(integrator, seconds=0.2)
    (found,) = engine.run_scenes([scene_from(case, Start(0.5, 2.0, 0.0, 0.0))])
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
        follow(Reference(), Incline(), start, duration, every=every)


def test_the_start_in_a_well_does_not_feel_its_last_digit():
    """It touches both spheres: the one behind shall not pull because of a rounding."""
    case = Incline(angle=0.0)
    path = follow(Reference(), case, start_in_well(case), case.step)
    assert path.vx_m_per_s[1] == pytest.approx(path.vx_m_per_s[0], rel=1e-3)
