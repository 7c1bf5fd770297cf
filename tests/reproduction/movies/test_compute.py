"""What happens in the motions, by laws that the runs do not use."""

import math

import numpy as np
import pytest

from harness.cases.incline.system import Motion
from harness.errors import EngineCrashError
from harness.parameters.tower import Tower
from harness.reproduction.movies import PAIR, contact_changes, motions, row_motion
from harness.solvers.chain.forces import compressions
from tests.reproduction.doubles import FateEngine


@pytest.fixture(scope="module")
def found():
    return motions(None)


@pytest.fixture(params=["pair", "triple", "tower"], scope="module")
def motion(request, found):
    return getattr(found, request.param)


def test_boundaries_of_neighbours_coincide_in_contact_and_never_overlap(motion):
    rounding = 50 * np.finfo(float).eps * motion.run.tower.particles
    assert motion.gap.min() > -rounding
    pressed = motion.force > 0
    assert pressed.any()
    assert np.abs(motion.gap[pressed]).max() < rounding


def test_boundaries_coincide_as_drawn(motion):
    right = (motion.drawn_centres + motion.drawn_widths / 2)[:, :-1]
    left = (motion.drawn_centres - motion.drawn_widths / 2)[:, 1:]
    # the rounding of positions in the row, exaggerated
    rounding = motion.exaggeration * 50 * np.finfo(float).eps * motion.run.tower.particles
    assert (left - right).min() > -rounding
    assert np.abs(left - right)[motion.force > 0].max() < rounding


def test_compressions_from_the_centres_are_those_of_the_forces(motion):
    run = motion.run
    after = motion.time >= 0
    rows = np.abs(run.time[:, None] - motion.time[after]).argmin(axis=0)
    # positions of up to 20 m carry compressions; T has a smallest eigenvalue of about 5 / n^2
    n = run.tower.particles
    width = 1e6 * 20 * np.finfo(float).eps * n**2
    touching = np.arange(n)
    for frame, row in zip(np.flatnonzero(after), rows, strict=True):
        swept = 1e6 * compressions(touching + motion.displacement[frame], 1.0)
        assert motion.force[frame] == pytest.approx(swept, abs=width)
        assert motion.force[frame] == pytest.approx(run.profiles.forces[row], abs=width)


def test_frames_are_equally_far_apart_and_show_the_approach(motion):
    steps = np.diff(motion.time)
    assert steps == pytest.approx(np.full(steps.size, steps[0]), rel=1e-6)
    before = motion.time < 0
    assert before.sum() > 3
    assert (motion.force[before] == 0).all()
    assert (motion.displacement[before, 1:] == 0).all()
    # positions are those that the velocities sum to
    moved = np.trapezoid(motion.velocity[before, 0], motion.time[before])
    ends = motion.displacement[before, 0]
    assert ends[-1] - ends[0] == pytest.approx(moved, rel=1e-9)


@pytest.mark.parametrize("name", ["pair", "triple"])
def test_free_rows_keep_momentum_and_energy(found, name):
    motion = getattr(found, name)
    v, tower = motion.velocity, motion.run.tower
    assert v.sum(axis=1) == pytest.approx(np.full(len(v), tower.speed), rel=1e-12)
    # U = k/2 c . T c, with T = tridiag(1/2, 1, 1/2)
    c = motion.force / 1e6
    beside = (c[:, 1:] * c[:, :-1]).sum(axis=1)
    energy = 0.5 * (v**2).sum(axis=1) + 0.5 * 1e6 * ((c**2).sum(axis=1) + beside)
    assert energy == pytest.approx(np.full(len(v), 2.0), rel=1e-9)


def test_the_pair_is_harmonic(found):
    end, closed = contact_changes(found.pair.run)[-1]
    assert closed == ()
    # a sample is 1 / 1760 t0
    assert end == pytest.approx(1 / math.sqrt(2), abs=1e-3)
    assert found.pair.run.deformations.max() == pytest.approx(2 * math.sqrt(0.5e-6), rel=1e-5)
    assert "touch for 0.707 t0" in found.pair.sentence
    assert found.pair.sentence.count("1.41 mm") == 1


def test_the_second_joins_the_story_of_three(found):
    changes = contact_changes(found.triple.run)[1:]
    assert [closed for _, closed in changes] == [(1, 2), (2,), (1, 2), (1,), ()]
    for time, _ in changes:
        assert f"{time:.2f} t0" in found.triple.sentence
    assert "-0.37, 0.46, 1.91" in found.triple.sentence  # the closed form of physics, N = 3
    assert found.triple.run.final_velocity / 2 == pytest.approx(
        [-0.185761, 0.230611, 0.955150], abs=1e-6
    )


def test_contacts_of_the_triple_do_not_depend_on_the_sampling(found):
    finer = row_motion(
        "three-particles", "", PAIR.replace(height=2), lead=0.1, duration=1.75, frames_per_t0=150
    )
    times = [time for time, _ in contact_changes(finer.run)]
    assert times == pytest.approx([t for t, _ in contact_changes(found.triple.run)], abs=1e-3)


def test_the_base_of_the_tower_stays_and_the_shock_reaches_it(found):
    tower = found.tower
    assert (tower.displacement[:, -1] == 0).all()
    strongest = tower.force.argmax(axis=1)
    assert strongest[tower.time > 0][3] == 0
    assert (strongest == tower.run.tower.height - 1).any()
    assert tower.exaggeration == 100


def test_a_particle_without_width_is_refused(found):
    pair = found.pair
    with pytest.raises(ValueError, match="exaggeration"):
        type(pair)(**{**vars(pair), "exaggeration": 1e3})


def test_the_exaggeration_follows_the_deformation():
    softer = row_motion(
        "two-particles", "", Tower(height=1, base="free", gravity=0.0, stiffness=1e4),
        lead=0.1, duration=1.0, frames_per_t0=20,
    )  # fmt: skip
    assert softer.exaggeration == 20


def test_without_an_engine_or_with_a_dead_one_the_rest_is_there(found, monkeypatch):
    assert found.incline is None
    assert found.missing == "no engine"
    monkeypatch.setattr("harness.reproduction.movies.row_motion", lambda *_, **__: None)
    left = motions(FateEngine([EngineCrashError("signal 11")] * 2))
    assert left.incline is None
    assert left.missing == "crashed: signal 11"


@pytest.mark.live
def test_the_grain_is_trapped_below_and_moves_on_above(lammps_here, monkeypatch):  # noqa: ARG001
    from harness.engines.registry import open_engine

    monkeypatch.setattr("harness.reproduction.movies.row_motion", lambda *_, **__: None)
    with open_engine() as engine:
        incline = motions(engine).incline
    below, above = incline.runs
    assert below.motion is Motion.TRAPPED
    assert above.motion is Motion.MOVES_ON
    assert "10.20 deg it is trapped after 6 crests" in incline.sentence
    path = incline.path(above)
    # a row of the path is 50 steps of 63 us
    assert np.abs(path.time_s - incline.time).max() < 0.0032
    assert path.x_m[-1] == pytest.approx(above.trajectory.x_m[-1])
