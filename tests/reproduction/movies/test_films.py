import gzip
import io
import subprocess
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from harness.cases.incline.system import Crests, Incline, InclineRun, Motion
from harness.observables.provenance import Provenance
from harness.observables.reference import Trajectory
from harness.parameters.tower import Tower
from harness.report.film import FRAME_MS, gif
from harness.reproduction.movies import (
    INCLINE_COLUMNS,
    PAIR,
    ROW_COLUMNS,
    InclineMotion,
    Motions,
    RowCollision,
    films,
    row_dump,
    row_motion,
)
from harness.reproduction.movies import motions as reproduced_motions

pytestmark = pytest.mark.slow

ENGINE = Provenance("lammps", "1 Jan 2030")
COMMITTED = Path(__file__).parents[3] / "reports" / "reproduction" / "movies"


def thin(motion, every):
    arrays = ("time", "displacement", "velocity", "force")
    return replace(motion, **{name: getattr(motion, name)[::every] for name in arrays})


def made_up(angle, end, motion):
    time = np.linspace(0, end, 300)
    path = Trajectory(time, 0.5 + 0.7 * time, 0.9 + 0 * time, 0.7 + 0 * time, np.sin(time))
    crests = Crests(np.arange(1, end), np.ones(len(np.arange(1, end))))
    return InclineRun(
        Incline(angle=angle), motion, 0.0, True, crests, end, 300, 0.1, ENGINE, path
    )  # fmt: skip


@pytest.fixture(scope="module")
def motions():
    plan = {"lead": 0.3, "duration": 1.2, "frames_per_t0": 10}
    below, above = made_up(10.1, 5.0, Motion.TRAPPED), made_up(10.3, 8.0, Motion.MOVES_ON)
    return Motions(
        row_motion("two-particles", "Two", PAIR, **plan),
        row_motion("three-particles", "Three", PAIR.replace(height=2), **plan),
        thin(row_motion("shock-down-the-tower", "Tower", Tower(height=5), **plan), 2),
        InclineMotion("incline", "Incline", "words", (below, above), np.linspace(0, 8, 12)),
    )


@pytest.fixture(scope="module")
def made(motions):
    return {film.name: film for film in films(motions)}


NAMES = ("two-particles", "three-particles", "incline", "shock-down-the-tower")


def by_name(motions, name):
    shown = (motions.pair, motions.triple, motions.tower, motions.incline)
    return next(motion for motion in shown if motion.name == name)


@pytest.mark.parametrize("name", NAMES)
def test_the_gif_has_every_frame_and_loops(motions, made, name):
    film = made[name]
    with Image.open(io.BytesIO(film.gif)) as image:
        assert image.info["loop"] == 0
        shown, last = [], None
        for frame in range(image.n_frames):
            image.seek(frame)
            shown.append(image.info["duration"])
            last = np.asarray(image.convert("RGB"))
    # two frames that look the same are one that is shown for longer
    assert sum(shown) == FRAME_MS * (by_name(motions, name).time.size - 1) + 1500
    assert len(shown) > 0.7 * by_name(motions, name).time.size
    assert (last[5, 5] == 255).all()  # opaque: readable on a dark page
    assert last.shape[1] == 880


@pytest.mark.parametrize("name", NAMES)
def test_film_and_still_agree(made, name):
    """What the GIF's deltas add up to is the picture itself, but for the palette."""
    with Image.open(io.BytesIO(made[name].still)) as still:
        wanted = np.asarray(still.convert("RGB")).astype(int)
    with Image.open(io.BytesIO(made[name].gif)) as image:
        nearest = np.inf
        for frame in range(image.n_frames):
            image.seek(frame)
            shown = np.asarray(image.convert("RGB")).astype(int)
            nearest = min(nearest, np.abs(shown - wanted).mean())
    assert nearest < 0.5


def test_the_same_motions_are_the_same_bytes(motions, made):
    scene, film = RowCollision(motions.pair), made["two-particles"]
    assert gif(scene.picture, scene.frames) == film.gif
    assert row_dump(motions.pair) == film.dump


@pytest.mark.slow  # of the committed ones it is seen below
def test_the_largest_movie_is_below_a_megabyte():
    """The one of three particles has the most that moves."""
    scene = RowCollision(reproduced_motions(None).triple)
    assert 50 < scene.frames < 200
    assert len(gif(scene.picture, scene.frames)) < 1e6


def test_the_committed_movies_are_below_a_megabyte():
    committed = list(COMMITTED.glob("*.gif"))
    assert len(committed) == len(NAMES)
    assert max(path.stat().st_size for path in committed) < 1e6


def test_what_is_not_there_is_left_out(motions, monkeypatch):
    monkeypatch.setattr("harness.report.film.gif", lambda *_: b"")
    names = [film.name for film in films(replace(motions, incline=None))]
    assert names == [name for name in NAMES if name != "incline"]


def test_the_palette_keeps_the_common_colours():
    def picture(frame):
        image = np.full((40, 60, 3), 255, dtype=np.uint8)
        image[10:20, frame : frame + 10] = (213, 94, 0)
        image[30:, :, 0] = np.arange(60) * 4  # a ramp of more colours than are kept
        return image

    with Image.open(io.BytesIO(gif(picture, 5))) as image:
        image.seek(4)
        shown = np.asarray(image.convert("RGB"))
    assert (shown[:10] == 255).all()
    assert (shown[10:20, 4:14] == (213, 94, 0)).all()
    assert (shown[10:20, :4] == 255).all()  # where it was before


def snapshots(text):
    """Return time and atoms of each snapshot, by a reader of its own."""
    units, *rest = text.split("ITEM: TIME\n")
    assert units == "ITEM: UNITS\nsi\n"
    for step, part in enumerate(rest):
        lines = part.splitlines()
        assert lines[1:3] == ["ITEM: TIMESTEP", str(step)]
        count = int(lines[4])
        assert lines[3] == "ITEM: NUMBER OF ATOMS"
        assert lines[5] == "ITEM: BOX BOUNDS ff ff ff"
        names = tuple(lines[9].removeprefix("ITEM: ATOMS ").split())
        atoms = np.array([line.split() for line in lines[10:]], dtype=float)
        assert len(atoms) == count
        yield float(lines[0]), dict(zip(names, atoms.T, strict=True)), lines[6:9]


@pytest.mark.parametrize("name", ["two-particles", "three-particles", "shock-down-the-tower"])
def test_the_dump_of_a_row_holds_the_motion(motions, made, name):
    motion = by_name(motions, name)
    found = list(snapshots(gzip.decompress(made[name].dump).decode()))
    assert len(found) == motion.time.size
    down = name == "shock-down-the-tower"
    axis, sign = ("z", -1) if down else ("x", 1)
    mass = 1.0
    for frame, (time, atoms, bounds) in enumerate(found):
        assert tuple(atoms) == ROW_COLUMNS
        # seven digits are written
        assert time == pytest.approx(motion.time[frame], rel=1e-6)
        assert atoms["v_displacement"] == pytest.approx(motion.displacement[frame], rel=1e-6)
        assert atoms[f"v{axis}"] == pytest.approx(sign * motion.velocity[frame], rel=1e-6)
        # drawn: position of the touching row and the displacement, exaggerated alike
        index = np.arange(motion.run.tower.particles)
        drawn = sign * (index + motion.exaggeration * atoms["v_displacement"])
        assert atoms[axis] == pytest.approx(drawn, rel=1e-5, abs=1e-5)
        widths = 1 - motion.exaggeration * atoms["v_deformation"]
        assert atoms[f"shape{axis}"] == pytest.approx(widths, rel=1e-5)
        assert atoms["v_contact_force"][-1] == 0
        inside = 1e6 * atoms["v_deformation"]
        shared = atoms["v_contact_force"] + np.append(0, atoms["v_contact_force"][:-1])
        assert shared == pytest.approx(inside, rel=1e-5, abs=1e-3 * mass)
        assert atoms[f"f{axis}"].sum() == pytest.approx(0, abs=1e-2)
        low, high = map(float, bounds["xyz".index(axis)].split())
        assert (low < atoms[axis]).all()
        assert (atoms[axis] < high).all()


def test_the_dump_of_the_incline_holds_both_paths(motions, made):
    motion = motions.incline
    found = list(snapshots(gzip.decompress(made["incline"].dump).decode()))
    assert len(found) == motion.time.size
    for lane, run in enumerate(motion.runs):
        path = motion.path(run)
        for frame, (_, atoms, _) in enumerate(found):
            assert tuple(atoms) == INCLINE_COLUMNS
            grain = (atoms["type"] == 2) & (atoms["mol"] == lane + 1)
            assert grain.sum() == 1
            assert atoms["x"][grain] == pytest.approx(path.x_m[frame], rel=1e-6)
            assert atoms["y"][grain] == pytest.approx(3 * (1 - lane) + path.y_m[frame], rel=1e-6)
            assert atoms["vx"][grain] == pytest.approx(path.vx_m_per_s[frame], rel=1e-6)


def test_round_off_changes_no_dump(motions, made):
    random = np.random.default_rng(5)

    def perturbed(motion):
        def off(values):
            return values + 1e-15 * np.abs(values).max() * random.uniform(-1, 1, values.shape)

        arrays = ("displacement", "velocity", "force")
        return replace(motion, **{name: off(getattr(motion, name)) for name in arrays})

    for motion in (motions.pair, motions.triple, motions.tower):
        assert row_dump(perturbed(motion)) == made[motion.name].dump


def test_a_dump_says_nothing_of_when_it_was_made(made):
    # bytes 4 to 7 of gzip are the time
    assert all(film.dump[4:8] == bytes(4) for film in made.values())


@pytest.mark.live
@pytest.mark.parametrize("name", NAMES)
def test_lammps_reads_the_dump_back(made, lmp, tmp_path, name):
    text = gzip.decompress(made[name].dump).decode()
    *_, (_, wanted, bounds) = snapshots(text)
    step = text.count("ITEM: TIMESTEP") - 1
    (tmp_path / "motion.dump").write_text(text)
    (tmp_path / "in.lmp").write_text(
        "units si\natom_style sphere\nboundary f f f\n"
        f"region space block {' '.join(bounds)}\ncreate_box 3 space\n"
        f"read_dump motion.dump {step} x y z vx vy vz box yes add yes\n"
        "write_dump all custom back.dump id type x y z vx vy vz modify sort id "
        'format float "%.9g"\n'
    )
    subprocess.run(
        [lmp, "-in", "in.lmp", "-log", "none"], cwd=tmp_path, check=True, timeout=60,
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
    )  # fmt: skip
    back = (tmp_path / "back.dump").read_text().splitlines()
    names = back[8].split()[2:]
    atoms = dict(zip(names, np.array([row.split() for row in back[9:]], float).T, strict=True))
    for column in names:
        assert atoms[column] == pytest.approx(wanted[column], rel=1e-6, abs=1e-12)
