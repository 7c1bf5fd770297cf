from dataclasses import replace

import numpy as np
import pytest

from harness.cases.tower.film import TowerShock, row_motion, tower_film
from harness.cases.tower.run import tower
from harness.errors import RequestError
from harness.parameters.tower import Tower


def run_of(case, solver="exact", **more):
    return tower(case, solver=solver, **{"duration": 3.0, "profiles": True, **more})


@pytest.fixture(scope="module", params=["overlap", "deformable"])
def motion(request):
    run = run_of(Tower(height=4, law=request.param))
    return row_motion(run, lead=0.5, frames_per_t0=20)


def test_particles_are_drawn_where_the_run_has_them(motion):
    scene, run = TowerShock(motion), motion.run
    for frame in (0, 15, 40, motion.time.size - 1):
        scene.picture(frame)
        drawn = np.array([shape.center[1] for shape in scene._shapes])
        row = int(np.abs(run.time - motion.time[frame]).argmin())
        if motion.time[frame] >= 0:
            moved = run.profiles.displacements[row]
        else:  # the grain falls, the others wait
            t = motion.time[frame]
            moved = np.array([2.0 * t + 9.81 * t**2 / 2, 0.0, 0.0, 0.0, 0.0])
        wanted = np.arange(5) + motion.exaggeration * moved
        assert drawn == pytest.approx(wanted, abs=1e-9)


def test_what_presses_is_what_the_run_says(motion):
    scene, run = TowerShock(motion), motion.run
    for frame in np.flatnonzero(motion.time >= 0)[::7]:
        scene.show(int(frame))
        row = int(np.abs(run.time - motion.time[frame]).argmin())
        pressing = run.profiles.forces[row] > 1e-6 * run.profiles.forces.max()
        assert len(scene._bars.get_segments()) == pressing.sum()


def test_only_deformable_particles_are_shortened(motion):
    shortest = motion.drawn_widths.min()
    if motion.run.tower.law == "overlap":
        assert shortest == 1.0
        return
    # drawn boundaries of particles that press coincide, by their centres
    right = (motion.drawn_centres + motion.drawn_widths / 2)[:, :-1]
    left = (motion.drawn_centres - motion.drawn_widths / 2)[:, 1:]
    # 0.32 of a diameter at most, by a factor of one digit, which is half of what could be at least
    assert 1 - 0.32 <= shortest < 1 - 0.16
    assert np.abs(left - right)[motion.force > 0].max() < 1e-8


def test_what_shows_nothing_is_refused():
    run = run_of(Tower(height=1))
    with pytest.raises(RequestError, match="profiles=True"):
        tower_film(replace(run, profiles=None), 20)
    still = replace(run, profiles=run.profiles._replace(forces=0 * run.profiles.forces))
    with pytest.raises(RequestError, match="nothing to show"):
        tower_film(still, 20)
