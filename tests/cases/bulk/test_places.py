"""Files of places: what is read, what is refused, what a code reads back."""

import lzma
import re
from pathlib import Path

import numpy as np
import pytest

from harness.cases.bulk.beds import PUBLISHED
from harness.cases.bulk.drum import CASE as DRUM_CASE
from harness.cases.bulk.drum import Drum
from harness.cases.bulk.penetration import CASE, Penetration
from harness.cases.bulk.places import PUBLISHED_BOX, Box, Cylinder, read_grains
from harness.engines.base import Job
from harness.engines.lammps.engine import Lammps
from harness.engines.output import Output
from harness.engines.registry import open_engine
from harness.errors import RequestError
from tests.cases.bulk.doubles import needs


def read_places(source, radius, box):
    return read_grains(source, (("radius", radius),), box)[:, 1:]


BOX = Box(0.02, 0.02, (0.0, 0.0), 0.0)
HEAD = "radius x y z\n"
ROW = "0.001 {:g} 0 0.001\n"


def test_the_published_bed_has_25000_grains_that_touch_floor_and_walls():
    places = read_places(PUBLISHED, 1e-3, PUBLISHED_BOX)
    assert places.shape == (25000, 3)
    assert places.min(axis=0) == pytest.approx(1e-3, abs=2e-6)
    assert places[:, :2].max(axis=0) == pytest.approx([0.097, 0.059], abs=2e-6)


def test_places_are_those_of_the_file_seen_from_the_corner_packed_or_not(tmp_path):
    text = HEAD + "2\n" + ROW.format(0.002) + ROW.format(-0.004)
    plain, packed = tmp_path / "bed.txt", tmp_path / "bed.txt.xz"
    plain.write_text(text)
    packed.write_bytes(lzma.compress(text.encode()))
    for path in (plain, packed):
        places = read_places(str(path), 1e-3, BOX)
        np.testing.assert_allclose(places, [[0.012, 0.01, 0.001], [0.006, 0.01, 0.001]])


WRONG = {
    "a row cut short": (HEAD + ROW.format(0.002) + "0.001 0.004\n", "changed from 4 to 2 at row 2"),
    "the first row cut short": ("0.001 0.002\n" + ROW.format(0.006), "changed from 2 to 4 at row"),
    "a word": (ROW.format(0.002) + "0.001 a 0 0\n", "could not convert string 'a' to float64"),
    "no number": (ROW.format(0.002) + "0.001 nan 0 0\n", "must be four finite ones"),
    "three columns": ("0.001 0 0\n", "a row of 3 numbers"),
    "nothing": (HEAD, "no row of four numbers"),
    "another radius": ("0.002 0 0 0.002\n", "grain 1 has the radius 0.002 m: must be radius"),
    "beyond a wall": (ROW.format(0.002) + ROW.format(0.0095), "grain 2 at (0.0195, 0.01, 0.001)"),
    "below the floor": ("0.001 0 0 0.0005\n", "must be 0.0009 m from the walls of the box"),
    "an overlap": (ROW.format(0.002) + ROW.format(0.0035), "grains 1 and 2 are 0.0015 m apart"),
}  # fmt: skip


@pytest.mark.parametrize(("text", "words"), WRONG.values(), ids=WRONG)
def test_a_bad_file_is_refused_in_one_line_that_names_file_and_row(text, words, tmp_path):
    path = tmp_path / "bed.txt"
    path.write_text(text)
    with pytest.raises(RequestError) as refused:
        read_places(str(path), 1e-3, BOX)
    assert words in str(refused.value)
    assert str(refused.value).startswith(f"places {path}")
    assert "\n" not in str(refused.value)


def test_a_file_that_is_not_there_and_a_broken_one_are_refused(tmp_path):
    broken = tmp_path / "bed.xz"
    broken.write_bytes(b"nothing packed")
    for path in (tmp_path / "none.txt", broken):
        with pytest.raises(RequestError, match="cannot be read"):
            read_places(str(path), 1e-3, BOX)


def bed(path, **changes):
    """Return a few grains in a square, with a sphere above them."""
    grid = [(x, y) for x in (-2e-3, 0.0, 2e-3) for y in (-2e-3, 0.0, 2e-3)]
    path.write_text("".join(f"0.001 {x} {y} 0.001\n" for x, y in grid))
    values = {
        "places": str(path), "length": 0.018, "width": 0.02, "start_height": 0.008,
        "settle_time": 0.0, "duration": 0.05, **changes,
    }  # fmt: skip
    return Penetration(**values)


def test_a_sphere_that_starts_in_the_bed_and_a_box_without_a_size_are_refused(tmp_path):
    with pytest.raises(RequestError, match=r"start_height = 0.005 m: .* at least 0.006"):
        CASE.job(bed(tmp_path / "bed.txt", start_height=0.005))
    with pytest.raises(RequestError, match=r"length = 0 m, width = 0.02 m: must be those of"):
        bed(tmp_path / "bed.txt", length=0.0)
    with pytest.raises(RequestError, match=r"length = 0.1 m, width = 0 m: must be 0 without"):
        Penetration(length=0.1)
    with pytest.raises(RequestError, match=r"offset = 0.006 m: .* must be within 0.005"):
        bed(tmp_path / "bed.txt", offset=0.006)


def test_lammps_reads_the_places_and_drops_the_sphere_at_its_offset(tmp_path):
    p = bed(tmp_path / "bed.txt")
    with Lammps() as engine:
        moved = Job(CASE.template, {**p.values, "offset": 2e-3}, sampled=True)
        found, aside = engine.run([CASE.job(p), moved])
        values = CASE.measure(p, found)
    # nine grains of one layer that touch: twelve pairs, and the floor is no grain
    assert values["bed_coordination"] == pytest.approx(24 / 9)
    assert values["bed_solid_fraction"] == pytest.approx(
        9 * 4 / 3 * np.pi * 1e-9 / (0.018 * 0.02 * 0.002)
    )
    assert values["energy_gain_ratio"] < 1e-3
    series = aside.table(("z_m",))["z_m"]
    assert series[-1] != pytest.approx(values["final_height_m"], rel=1e-6)


DRUM = {"drum_radius": 0.014, "drum_length": 0.0105, "settle_time": 0.0, "turn": 1.0}
LARGE, SMALL = "0.002 {:g} 0 -0.01\n", "0.001 {:g} 0 -0.01\n"
WRONG_DRUM = {
    "another radius": (LARGE.format(0) + "0.0015 0.004 0 0\n", "must be large_radius = 0.002 m or"),
    "beyond the end": (LARGE.format(0) + "0.001 0 0.0045 0\n", "grain 2 at (0, 0.0045, 0) m: must"),
    "beyond the drum": (
        LARGE.format(0.008),
        "must be 0.0018 m from the walls of the drum, 0.014 m",
    ),
    "a deep overlap": (
        LARGE.format(0) + SMALL.format(0.0025),
        "must be 0.0029 m, an overlap of 0.1",
    ),
    "a kind is not there": (LARGE.format(0), "no grain of small_radius = 0.001 m"),
    "a row cut short": (LARGE.format(0) + "0.001 0.004\n", "changed from 4 to 2 at row 2"),
}


@pytest.mark.parametrize(("text", "words"), WRONG_DRUM.values(), ids=WRONG_DRUM)
def test_a_bad_file_of_a_drum_is_refused(text, words, tmp_path):
    path = tmp_path / "drum.txt"
    path.write_text(text)
    p = Drum(places=str(path), **DRUM)
    with pytest.raises(RequestError, match=re.escape(words)):
        DRUM_CASE.job(p)


def test_the_published_drum_has_8000_large_and_30000_small_grains_that_touch_it():
    p = DRUM_CASE.presets[PUBLISHED]
    assert (p.counts[0], p.counts[1]) == (8000, 30000)
    walls = Cylinder(p.drum_radius, p.drum_length)
    for places, radius in zip(p.bed, (p.large_radius, p.small_radius), strict=True):
        assert walls.gap(places).min() == pytest.approx(radius, abs=3e-6)
    table = Path(DRUM_CASE.job(p).values["places"]).read_text("utf-8").partition("Atoms")[2]
    types = [int(line.split()[1]) for line in table.splitlines() if line]
    assert (types.count(1), types.count(2)) == (8000, 30000)


@pytest.mark.parametrize("code", ["lammps", "liggghts", "yade", "kratos"])
@pytest.mark.live
@pytest.mark.slow
def test_a_code_reads_the_drum_of_a_file(code, tmp_path):
    """Grains that touch nothing fall as one: h = g (n dt)^2/2, to a step."""
    needs(code)
    path = tmp_path / "drum.txt"
    rows = [LARGE.format(0), SMALL.format(-0.004), SMALL.format(0.004)]
    path.write_text("".join(row.replace("-0.01", "0.005") for row in rows))
    p = Drum(places=str(path), **DRUM)
    with open_engine(code) as engine:
        (output,) = engine.run([DRUM_CASE.job(p)])
        assert isinstance(output, Output), output
    table = output.table(("step", "x_m", "y_m", "z_m"))
    np.testing.assert_allclose(sorted(table["x_m"][0]), [-0.004, 0.0, 0.004], atol=1e-9)
    assert table["x_m"][0][0] == pytest.approx(0.0, abs=1e-9)  # large ones come first
    fall = 0.5 * p.gravity * (p.step_size * p.steps) ** 2
    np.testing.assert_allclose(table["z_m"][-1], 0.005 - fall, atol=2.0 / p.steps * fall)
