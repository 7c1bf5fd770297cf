"""What MFiX is given and leaves: inputs against the recorded ones, frames in its form."""

import math
from pathlib import Path

import numpy as np
import pytest

from harness.engines.mfix.scenes import (
    LEAST_RESTITUTION,
    Frame,
    motion,
    read_frame,
    read_frames,
    rules,
    system_of,
)
from harness.engines.scenes import decided, stages_of
from harness.errors import EngineNaNError, EngineOutputError, Unsupported
from harness.model.law import Law, damping_ratio
from harness.model.scene import Stage
from harness.solvers import reference
from tests.engines.mfix.stand_in import read_keywords, vtp
from tests.engines.test_plane_scenes import drop, tower
from tests.solvers.reference.scenes import climbing, on_row

RECORDED = Path(__file__).parent / "recorded"
SOURCE = damping_ratio(LEAST_RESTITUTION)
LAW = Law.linear(1e6, SOURCE, False)
HALF = Law.linear(1e6, damping_ratio(0.5), False)
CHANGED = {
    *("RUN_NAME", "DESCRIPTION", "TSTOP"),
    # the recorded runs had routines of their own, with switches, for output and to freeze the row
    *("CALL_USR", *(f"C({i})" for i in range(1, 8))),
    # a grain that crosses would count twice: so the row is as long as it needs, and so is the box
    *("CYCLIC_X", "PARTICLES", "XLENGTH", "IMAX", "IC_X_E(1)"),
}
# of the outlet that holds the row, of the output, and of the search for neighbours
ADDED = ("BC_", "DESGRIDSEARCH_", "VTK_", "WRITE_VTK_FILES", "TIME_DEPENDENT_FILENAME")


def source_row(angle=10.2, factor=50.0, wells=8, seconds=45.0, stiffness=1e6, gravity=9.81):
    """Return the row of the source: its start, and its step over the contact time of m/2."""
    omega = math.sqrt(2.0 * stiffness * (1.0 - SOURCE**2))
    scene = on_row(stiffness, angle=angle, ratio=SOURCE, clipped=False, motion="held", wells=wells,
                   step=math.pi / omega / factor, every=20)  # fmt: skip
    tilt, steps = math.radians(angle), math.ceil(seconds / scene.step)
    pull = (gravity * math.sin(tilt), -gravity * math.cos(tilt), 0.0)
    return scene.replace(steps=steps, gravity=pull)


def rows_of(system):
    text = system.inputs["particle_input.dat"].replace("d", "e")
    return np.array([[float(word) for word in line.split()] for line in text.splitlines()])


def test_every_keyword_of_the_recorded_input_is_stated_but_for_those_reviewed():
    recorded = read_keywords((RECORDED / "mfix_quartier.dat").read_text(encoding="utf-8"))
    gx, gy = recorded["GRAVITY_X"], recorded["GRAVITY_Y"]
    scene = source_row(math.degrees(math.atan2(gx, -gy)), recorded["DTSOLID_FACTOR"],
                       stiffness=recorded["KN"], gravity=math.hypot(gx, gy))  # fmt: skip
    generated = read_keywords(system_of(scene, 10**5, "EULER").inputs["mfix.dat"])
    for key in recorded.keys() - CHANGED:
        value = recorded[key]
        number = isinstance(value, float)
        assert generated[key] == (pytest.approx(value, rel=1e-11) if number else value), key
    cells = [generated[f"{a}LENGTH"] / generated[f"DESGRIDSEARCH_{i}MAX"] for a, i in ("XI", "YJ")]
    assert min(cells) >= 2.4 * generated["D_P0(1)"]
    assert all(key.startswith(ADDED) for key in generated.keys() - recorded.keys())
    assert {key for key in CHANGED if generated.get(key) == recorded[key]} == set()


@pytest.mark.parametrize(("scheme", "average"), [("EULER", 1.0), ("ADAMS_BASHFORTH", 0.5)])
def test_a_held_sphere_is_at_its_place_after_the_first_step(scheme, average):
    """By the schemes: x + h (v + h a), and x + h/2 (v + v + h a)."""
    scene = drop(HALF, "held", 9.81)
    grain = scene.bodies[0].replace(position=(0.0, 1.0 - 1e-3, 0.0), velocity=(0.0, -1.0, 0.0))
    system = system_of(scene.replace(bodies=(grain, scene.bodies[1])), 100, scheme)
    assert f"DES_INTG_METHOD = '{scheme}'" in system.inputs["mfix.dat"]
    acceleration = -9.81 - (1e6 * 1e-3 + HALF.dashpot(0.5, 1.0, 0.0) * 1.0)
    moved = rows_of(system)[1, 5] + average * scene.step * acceleration
    assert moved == pytest.approx(0.0, abs=1e-9 * abs(acceleration) * scene.step)


@pytest.mark.parametrize("ratio", [SOURCE, damping_ratio(0.5), 0.0])
def test_restitution_and_step_are_those_of_the_dashpot(ratio):
    """MFiX has eta by ln e and m/2, and takes its step from the damped contact time."""
    scene = drop(Law.linear(1e6, ratio, False), "held")
    values = system_of(scene, 100, "EULER").keywords()
    logarithm = math.log(values["restitution"])
    eta = -2.0 * math.sqrt(0.5e6) * logarithm / math.hypot(math.pi, logarithm)
    assert eta == pytest.approx(scene.law.dashpot(0.5, 1.0, 0.0), rel=1e-12, abs=1e-12)
    time = math.pi / math.sqrt(2e6 - eta**2)
    assert scene.step * values["factor"] == pytest.approx(time, rel=1e-10)


def three(*positions, **changes):
    """Return a column of three with other places, or other properties of the last."""
    scene = tower(Law(normal_stiffness=1e6), 2)
    bodies = list(scene.bodies)
    for number, place in enumerate(positions):
        bodies[number] = bodies[number].replace(position=(place, 0.0, 0.0))
    bodies[-1] = bodies[-1].replace(**changes)
    return scene.replace(bodies=tuple(bodies), pairs=None)


REFUSED = [
    (drop(HALF), "effective mass half, motion = held"),
    (drop(HALF.replace(clipped=True), "held"), "keeps the attractive tail"),
    (drop(Law.linear(1e6, 0.999, False), "held"), "damping ratios up to 0.997"),
    (drop(HALF.replace(tangential="linear_history"), "held"), "takes tangential = none"),
    (drop(HALF, "held").replace(step=3e-4), "DTSOLID_FACTOR of 10 or more.*at most"),
    (three().replace(steps=10**6), "writes at most 100000 files"),
    (three(mass=2.0), "one diameter and one mass"),
    (three(0.0, 2.5, 1.25), "must come in order"),
    (three(motion="free"), "must be fixed"),
    (source_row().replace(stages=()), "stages that give its end"),
    (source_row().replace(period=(10.5, None, None)), "row is of touching spheres"),
    (source_row().replace(period=(None, None, None)), "stages are those of a row"),
]  # fmt: skip


@pytest.mark.parametrize(("scene", "reason"), REFUSED)
def test_scene_that_mfix_cannot_state(scene, reason):
    with pytest.raises(Unsupported, match=reason):
        rules(scene)


# ---- stages, by looks at a path


@pytest.mark.parametrize(
    ("stages", "steps"),
    [(((0.1, 0.0), (0.15, 0.0)), 1000), (((0.1, 0.0), (9.0, 1.1)), 1000), (((9.0, 0.0),), 333)],
)
def test_stages_are_those_of_the_reference(stages, steps):
    scene = climbing(*stages, steps=steps).replace(every=1)
    path = reference.run(scene.replace(stages=()))
    x, v = path.position[:, 0, :2], path.velocity[:, 0, :2]
    found = stages_of(scene, np.arange(len(path)), x, v)
    expected = reference.run(scene).stages
    assert found[:, :6] == pytest.approx(expected[:, :6])
    assert decided(scene, found)
    cut = int(expected[-1, 0]) - 20
    assert not decided(scene, stages_of(scene, np.arange(cut), x[:cut], v[:cut]))


# ---- frames

ROWS = 60


def test_recorded_frames_are_read():
    """As MFiX 21.3.2 wrote them: four spheres on a held one, step 3 of the clock."""
    grains = read_frame((RECORDED / "GRAIN_0003.vtp").read_bytes(), "GRAIN_0003.vtp")
    forces = read_frame((RECORDED / "FORCE_0003.vtp").read_bytes(), "FORCE_0003.vtp")
    assert set(grains.arrays) >= {"coordinates", "Velocity", "Particle_ID"}
    assert sorted(grains.arrays["Particle_ID"][:, 0]) == [1.0, 2.0, 3.0, 4.0]
    assert forces.arrays["FORCE_CHAIN_FN"].shape == forces.arrays["coordinates"].shape
    assert (forces.arrays["FORCE_CHAIN_FN"][:, 1] > 0.0).all()  # on the sphere above
    assert grains.time > 0.0


@pytest.fixture
def frames(tmp_path):
    """Return system, states (ROWS, 4) and a folder with them, the grain at a place that changes."""
    scene = source_row().replace(stages=(Stage(place=99.0, floor=-1e9),))
    system = system_of(scene, scene.steps, "EULER")
    assert system.every == 10
    states = np.random.default_rng(1).uniform(1.0, 2.0, (ROWS, 4))
    for number, (x, y, vx, vy) in enumerate(states):
        # the first frame has the whole row; the order in a file changes
        rows = [(2.0 + i, *place, 0.0, 0.0) for i, place in enumerate(system.places[1:])]
        rows = [(1.0, x, y, vx, vy), *(rows if number == 0 else [(199.0, 1.0, 5.0, 0.0, 0.0)])]
        table = np.array(rows[::-1] if number % 2 else rows)
        fields = {"Velocity": table[:, 3:], "Particle_ID": table[:, :1]}
        content = vtp(10 * number * scene.step, table[:, 1:3], fields)
        (tmp_path / f"GRAIN_{number:04d}.vtp").write_bytes(content)
    return system, states, tmp_path


def read(system, folder):
    return motion(system, read_frames(folder, "GRAIN"), [])


def test_the_path_that_was_written_is_read_by_its_global_id(frames):
    system, states, folder = frames
    (folder / "GRAIN_0059.vtp").rename(folder / "GRAIN_10000.vtp")
    found = read(system, folder)
    expected = states[::2][:28]  # each 20th step, to the last look, at step 550
    assert found.time == pytest.approx(20 * np.arange(28) * system.scene.step)
    assert np.abs(found.position[:, 0, :2] - expected[:, :2] + system.origin).max() < 2.0**-22
    assert np.abs(found.velocity[:, 0, :2] - expected[:, 2:]).max() < 2.0**-22
    assert np.isnan(found.force[:, :, 0]).all()


@pytest.mark.parametrize(
    ("left", "end", "reason"),
    [
        (1, None, "lost a mobile sphere: 1 of 6 frames"),
        (0, None, "lost a mobile sphere: 0 of 6 frames"),
        (6, 3, "ended at step 2 of"),
    ],
)
def test_a_lost_mobile_sphere_or_an_early_end_is_named(left, end, reason):
    """Of a column whose second sphere is in so many frames."""
    scene = three().replace(steps=4)
    system = system_of(scene, scene.steps, "EULER")
    frames = []
    for step in range(system.steps + 1):
        ids = np.arange(1.0, 3.0)[: 2 if step < left else 1, None]
        arrays = {"coordinates": system.places[: len(ids)], "Velocity": np.zeros((len(ids), 2))}
        frames.append(Frame(step * scene.step, {**arrays, "Particle_ID": ids}))
    with pytest.raises(EngineOutputError, match=reason):
        motion(system, frames[:end], [])


def edit(number, change):
    def damage(folder):
        path = folder / f"GRAIN_{number:04d}.vtp"
        path.write_bytes(change(path.read_bytes()))

    return damage


SIZE = b"\n _\0\0\0\x18"
DAMAGES = [
    (edit(7, lambda text: text[: len(text) // 2]), EngineOutputError, r"GRAIN_0007\.vtp"),
    (edit(7, lambda text: text.replace(SIZE, b"\n _\0\0\0\x0c")), EngineOutputError, "cut short"),
    (edit(7, lambda text: text.replace(b"Particle_ID", b"Particle_XX")), EngineOutputError, "ids"),
    (edit(7, lambda text: text.replace(SIZE, SIZE + b"\x7f\x80\0\0")), EngineNaNError, "not num"),
    (lambda folder: (folder / "GRAIN_0030.vtp").unlink(), EngineOutputError, "not every 10"),
]


@pytest.mark.parametrize(("damage", "error", "reason"), DAMAGES)
def test_a_damaged_frame_is_named(frames, damage, error, reason):
    system, _, folder = frames
    damage(folder)
    with pytest.raises(error, match=reason):
        read(system, folder)
