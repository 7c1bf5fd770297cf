"""The reader, on VTP files in MFiX's form that are made from MFiX's recorded paths."""

import math
import re

import numpy as np
import pytest

from harness.cases.grain import path_in
from harness.cases.incline.system import start_in_well
from harness.cases.incline.verification import START_SPEED, STIFFNESS, case_at, recorded_path
from harness.engines.mfix.system import path_table, read_frame, read_frames
from harness.errors import EngineNaNError, EngineOutputError

ROWS = 300
SINGLE = 2.0**-23


@pytest.fixture(scope="module")
def recorded():
    return recorded_path(50, 10.20)


@pytest.fixture
def stated(incline_of):
    """Return the recorded run as a scene and as MFiX's system."""
    case = case_at(10.20, STIFFNESS, 50)
    return incline_of(case, start_in_well(case, START_SPEED), 8, 45.0, 20)


@pytest.fixture
def system(stated):
    return stated[1]


@pytest.fixture
def read_path(stated):
    """Return the function that reads the grain's path from frames."""
    scene, system = stated
    return lambda frames: path_in(path_table(system, scene, frames))


@pytest.fixture
def written(recorded, system, write_vtp, tmp_path):
    """Return a folder with the recorded path as frames, the grain at a place that changes.

    The first frame has the whole row; later ones have a stranger before the grain or after.
    """
    path, (x0, y0) = recorded, system.origin
    for row in range(ROWS):
        place = (x0 + path.x_m[row], y0 + path.y_m[row], 0.0)
        velocity = (path.vx_m_per_s[row], path.vy_m_per_s[row], 0.0)
        others = [(99.0, (1.0, 5.0, 0.0))]
        if row == 0:
            others = [(i, (s.x, s.y, 0.0)) for i, s in enumerate(system.held, 2)]
        at = len(others) if row % 2 else 0
        points = [place for _, place in others]
        points.insert(at, place)
        velocities = [(0.0, 0.0, 0.0)] * len(others)
        velocities.insert(at, velocity)
        ids = [(float(number),) for number, _ in others]
        ids.insert(at, (1.0,))
        content = write_vtp(
            20 * row * system.step, points, {"Velocity": velocities, "Particle_ID": ids}
        )
        (tmp_path / f"GRAIN_{row:04d}.vtp").write_bytes(content)
    return tmp_path


def test_the_path_that_was_written_is_read_by_its_global_id(read_path, recorded, system, written):
    path, expected = read_path(read_frames(written, "GRAIN")), recorded
    assert path.time_s == pytest.approx(20 * system.step * np.arange(ROWS), rel=1e-14)
    for name, size in (("x_m", 15.0), ("y_m", 2.0), ("vx_m_per_s", 2.0), ("vy_m_per_s", 2.0)):
        apart = np.abs(getattr(path, name) - getattr(expected, name)[:ROWS]).max()
        assert apart <= size * SINGLE, name


def test_frames_beyond_9999_come_in_the_order_of_their_times(read_path, written):
    frames = read_frames(written, "GRAIN")
    (written / "GRAIN_0299.vtp").rename(written / "GRAIN_10000.vtp")
    (written / "GRAIN_0298.vtp").rename(written / "GRAIN_9999.vtp")
    assert [f.time for f in read_frames(written, "GRAIN")] == [f.time for f in frames]
    assert len(read_path(frames).time_s) == ROWS


@pytest.mark.parametrize("left", [0.0, 0.05, 0.3, 0.6, 0.9, 0.99])
def test_a_file_that_is_cut_is_named(written, left):
    content = (written / "GRAIN_0007.vtp").read_bytes()
    (written / "GRAIN_0007.vtp").write_bytes(content[: int(left * len(content))])
    with pytest.raises(EngineOutputError, match=r"GRAIN_0007\.vtp"):
        read_frames(written, "GRAIN")


def test_a_block_of_another_size_is_named(written):
    content = (written / "GRAIN_0007.vtp").read_bytes()
    with pytest.raises(EngineOutputError, match="x with coordinates cut short"):
        read_frame(content.replace(b"\n _\0\0\0\x18", b"\n _\0\0\0\x0c"), "x")


def test_the_grain_that_left_the_box_ends_its_path(read_path, written, system, write_vtp):
    for row in range(200, ROWS):
        content = write_vtp(
            20 * row * system.step,
            [(1.0, 5.0, 0.0)],
            {"Velocity": [(0.0,) * 3], "Particle_ID": [(99.0,)]},
        )
        (written / f"GRAIN_{row:04d}.vtp").write_bytes(content)
    assert len(read_path(read_frames(written, "GRAIN")).time_s) == 200


@pytest.mark.parametrize("missing", [0, 1, 150])
def test_a_frame_that_is_missing_is_told(read_path, written, missing):
    (written / f"GRAIN_{missing:04d}.vtp").unlink()
    with pytest.raises(EngineOutputError, match="frames that are not every 20 steps"):
        read_path(read_frames(written, "GRAIN"))


def test_no_frames_are_told(read_path, tmp_path):
    with pytest.raises(EngineOutputError, match="wrote no particles"):
        read_path(read_frames(tmp_path, "GRAIN"))


def test_a_held_sphere_that_moved_is_told(read_path, written, system, write_vtp):
    moved = system.held[0]
    frame = {"Velocity": [(0.0,) * 3] * 2, "Particle_ID": [(1.0,), (2.0,)]}
    last = f"GRAIN_{ROWS - 1:04d}.vtp"
    time = 20 * (ROWS - 1) * system.step
    places = [(3.0, 1.4, 0.0), (moved.x, moved.y, 0.0)]
    (written / last).write_bytes(write_vtp(time, places, frame))
    read_path(read_frames(written, "GRAIN"))
    places[1] = (moved.x, moved.y - 1e-3, 0.0)
    (written / last).write_bytes(write_vtp(time, places, frame))
    with pytest.raises(EngineOutputError, match="moved a sphere that is to be held"):
        read_path(read_frames(written, "GRAIN"))


@pytest.mark.parametrize("value", [math.nan, math.inf])
def test_what_is_no_number_is_told(read_path, written, system, write_vtp, value):
    frame = {"Velocity": [(0.0, value, 0.0)], "Particle_ID": [(1.0,)]}
    content = write_vtp(20 * 9 * system.step, [(3.0, 1.4, 0.0)], frame)
    (written / "GRAIN_0009.vtp").write_bytes(content)
    with pytest.raises(EngineNaNError, match="not numbers"):
        read_path(read_frames(written, "GRAIN"))


def test_frames_without_ids_are_told(read_path, written):
    path = written / "GRAIN_0000.vtp"
    path.write_bytes(path.read_bytes().replace(b"Particle_ID", b"Particle_XX"))
    with pytest.raises(EngineOutputError, match="without their global ids"):
        read_path(read_frames(written, "GRAIN"))


def test_of_frames_at_one_time_the_last_counts(read_path, written):
    """Of the same time, from the same file with the grain elsewhere."""
    first = read_path(read_frames(written, "GRAIN"))
    early = (written / "GRAIN_0100.vtp").read_bytes()
    clock = re.search(rb"<!-- Time.*-->", early)[0]
    late = (written / "GRAIN_0299.vtp").read_bytes()
    (written / "GRAIN_10000.vtp").write_bytes(
        re.sub(rb"<!-- Time.*-->", lambda _: clock, late, count=1)
    )
    path = read_path(read_frames(written, "GRAIN"))
    assert len(path.time_s) == ROWS
    assert path.x_m[100] == first.x_m[299]
    assert path.x_m[101] == first.x_m[101]
