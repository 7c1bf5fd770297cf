"""Files of places: what is read, what is refused, what a code reads back."""

import lzma

import numpy as np
import pytest

from harness.cases.bulk.places import PUBLISHED, PUBLISHED_BOX, Box, data_file, read_places
from harness.cases.penetration import CASE, Penetration, values_of
from harness.engines.contract import Job
from harness.engines.lammps.engine import Lammps
from harness.errors import RequestError

BOX = Box(0.02, 0.02, (0.0, 0.0), 0.0)
HEAD = "radius x y z\n"
ROW = "0.001 {:g} 0 0.001\n"


@pytest.fixture(autouse=True)
def own_cache(monkeypatch, tmp_path):
    monkeypatch.setenv("DEM_HARNESS_HOME", str(tmp_path / "home"))


def test_the_published_bed_has_25000_grains_that_touch_floor_and_walls():
    places = read_places(PUBLISHED, 1e-3, PUBLISHED_BOX)
    assert places.shape == (25000, 3)
    assert places.min(axis=0) == pytest.approx(1e-3, abs=2e-6)
    assert places[:, :2].max(axis=0) == pytest.approx([0.097, 0.059], abs=2e-6)


def test_places_are_those_of_the_file_seen_from_the_corner_packed_or_not(tmp_path):
    text = HEAD + ROW.format(0.002) + ROW.format(-0.004)
    plain, packed = tmp_path / "bed.txt", tmp_path / "bed.txt.xz"
    plain.write_text(text)
    packed.write_bytes(lzma.compress(text.encode()))
    for path in (plain, packed):
        places = read_places(str(path), 1e-3, BOX)
        np.testing.assert_allclose(places, [[0.012, 0.01, 0.001], [0.006, 0.01, 0.001]])


WRONG = {
    "a row cut short": (HEAD + ROW.format(0.002) + "0.001 0.004\n", "line 3: '0.001 0.004': must"),
    "a word": (ROW.format(0.002) + "0.001 a 0 0\n", "line 2: '0.001 a 0 0': must be four numbers"),
    "nothing": (HEAD, "no line of four numbers"),
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


def test_a_data_file_is_named_by_its_content():
    places = np.array([[0.012, 0.01, 0.001], [0.006, 0.01, 0.001]])
    one, same, other = (data_file(places, 1e-3, rho, BOX, 0.1) for rho in (2500, 2500, 2600))
    assert one == same != other
    assert len(list(one.parent.iterdir())) == 2  # no part of a file is left


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


def test_lammps_reads_the_places_and_drops_the_sphere_where_it_is_told(tmp_path):
    p = bed(tmp_path / "bed.txt")
    with Lammps() as engine:
        values = CASE.measure(p, engine).values
        job = Job(CASE.template, {**values_of(p), "offset": 2e-3}, sampled=True)
        (aside,) = engine.run([job])
    # nine grains of one layer that touch: twelve pairs, and the floor is no grain
    assert values["bed_coordination"] == pytest.approx(24 / 9)
    assert values["bed_solid_fraction"] == pytest.approx(
        9 * 4 / 3 * np.pi * 1e-9 / (0.018 * 0.02 * 0.002)
    )
    assert values["energy_gain_ratio"] < 1e-3
    series = aside.table(("z_m",))["z_m"]
    assert series[-1] != pytest.approx(values["final_height_m"], rel=1e-6)
