"""Parameters of bulk cases: refusals, steps, files of places, energies of beds at rest."""

import lzma
import math
import re
import subprocess
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq

from harness.cases.bulk import beds, drum
from harness.cases.bulk.beds import PUBLISHED, RAYLEIGH_SHARE, Box, Places, Sphere, find_contacts
from harness.engines.lammps.engine import Lammps
from harness.engines.output import results_in
from harness.engines.registry import engine_class
from harness.errors import RequestError
from tests.cases.bulk.doubles import CASES, SMALL, needs, run

APART = "scatter = 0.3: grains overlap at the start; must be at most 0."
WRONG = [
    ("silo", {"orifice_radius": 0.03}, "orifice_radius = 0.03 m: must be less than silo_radius ="),
    ("silo", {"radius": 0.03}, "silo_radius = 0.024 m: no grain of radius = 0.03 m finds room"),
    ("drum", {"large_layers": -5}, "large_layers = -5: no large grain finds room in the drum"),
    ("drum", {"large_layers": 9}, "small_layers = 4: no small grain finds room in the drum"),
    ("penetration", {"start_height": 0.02}, "start_height = 0.02 m: the sphere overlaps the"),
    ("penetration", {"steel_radius": 0.013, "start_height": 0.1}, "must be at most 0.012"),
    ("penetration", {"offset": 0.012}, "offset = 0.012 m: the sphere is in a wall; must be within"),
    ("penetration", {"places": "bed.txt", "width": 0.02}, "length = 0 m, width = 0.02 m: must be"),
    ("penetration", {"length": 0.1}, "length = 0.1 m, width = 0 m: must be 0 without"),
    ("heap", {"dispersity": 0.5}, "grains overlap at the start"),
    ("heap", {"width": 2, "spacing": 3.0}, "width = 2: no grain finds room between the sides"),
    *((name, {"scatter": 0.3}, APART) for name in CASES),
    *((name, {"step_size": 1e-4}, "step_size = 0.0001 s: must be at most") for name in CASES),
]


@pytest.mark.parametrize(("name", "changes", "words"), WRONG)
def test_what_cannot_be_simulated_is_refused_in_one_line(name, changes, words):
    with pytest.raises(RequestError) as refused:
        CASES[name].default.replace(**changes)
    assert words in str(refused.value)
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize("name", CASES)
def test_each_value_of_a_script_has_its_meaning_beside_it(name):
    template = CASES[name].template
    for code in ("lammps", "liggghts", "yade", "kratos"):
        text = engine_class(code).script(template).text
        for value in template.variants[""]:
            meaning = re.escape(template.about[value])
            line = rf'^(variable {value} +index .*|    "{value}": .*,)  +# {meaning}$'
            absent = value == "rolling_friction" and code in ("yade", "kratos")
            assert bool(re.search(line, text, re.M)) is not absent, (code, value)


@pytest.mark.parametrize("code", ["yade", "kratos"])
@pytest.mark.parametrize(("name", "preset"), [("drum", "slow"), ("heap", "small")])
def test_codes_that_do_not_resist_rolling_refuse_it(code, name, preset):
    engine = engine_class(code).__new__(engine_class(code))
    case = CASES[name]
    p = case.presets[preset]
    assert engine.refuses(case.job(p)).endswith(
        f"has no variable 'rolling_friction' (rolling_friction = {p.rolling_friction})"
    )
    assert not engine.refuses(case.job(p.replace(rolling_friction=0.0)))


# ---- published systems


def test_published_silos_have_a_hundred_thousand_grains_and_walls_of_45_deg():
    for name in (PUBLISHED, f"{PUBLISHED}-wide"):
        p = CASES["silo"].presets[name]
        assert p.grains == pytest.approx(1e5, rel=0.01)
        assert p.silo_radius - p.orifice_radius == pytest.approx(p.cone_height)


def test_froude_number_filling_and_numbers_of_the_drum_are_the_published_ones():
    p = drum.Drum()
    assert p.speed**2 * p.drum_radius == pytest.approx(2.0**2 * 0.1, rel=2e-3)
    assert p.counts[1] / p.counts[0] == pytest.approx(30000 / 8000, rel=0.06)
    solid = 4 / 3 * math.pi * (8000 * 8 + 30000) * 1e-9
    share = sum(p.of_each("mass") / p.of_each("density")) / p.drum_radius**2 / p.drum_length
    assert share == pytest.approx(solid / (0.01 * 0.06), rel=0.06)


def test_the_mean_mass_of_a_heap_is_that_of_an_even_range_of_diameters():
    p = CASES["heap"].default
    mean = p.grain.mass * np.mean(np.linspace(0.85, 1.15, 100_001) ** 3)
    assert p.weight / (p.grains * p.gravity) == pytest.approx(mean, rel=1e-5)


# ---- files of places

BED = ("penetration", {"length": 0.02, "width": 0.02, "start_height": 0.008, "settle_time": 0.0})
DRUM = ("drum", {"drum_radius": 0.014, "drum_length": 0.0105, "settle_time": 0.0, "turn": 1.0})
HEAD, ROW = "radius x y z\n", "0.001 {:g} 0 0.001\n"
LARGE, SMALL_ROW = "0.002 {:g} 0 -0.01\n", "0.001 {:g} 0 -0.01\n"
WRONG_FILES = {  # case, text, words of the error
    "a row cut short": (BED, HEAD + ROW.format(0.002) + "0.001 0.004\n", "from 4 to 2 at row 2"),
    "a word": (BED, ROW.format(0.002) + "0.001 a 0 0\n", "could not convert string 'a'"),
    "no number": (BED, ROW.format(0.002) + "0.001 nan 0 0\n", "must be four finite ones"),
    "nothing": (BED, HEAD, "must be four finite ones"),
    "another radius": (BED, "0.002 0 0 0.002\n", "grain 1 has the radius 0.002 m: must be radius"),
    "a wall": (BED, ROW.format(0.002) + ROW.format(0.0095), "grain 2 at (0.0195, 0.01, 0.001)"),
    "below the floor": (BED, "0.001 0 0 0.0005\n", "must be 0.0009 m from the walls"),
    "an overlap": (BED, ROW.format(0.002) + ROW.format(0.0035), "1 and 2 are 0.0015 m apart"),
    "a sphere in it": (BED, "0.001 0 0 0.005\n", "start_height = 0.008 m: the sphere overlaps"),
    "two radii": (DRUM, "0.0015 0.004 0 0\n", "must be large_radius = 0.002 m or small_radius"),
    "an end": (DRUM, LARGE.format(0) + "0.001 0 0.0045 0\n", "grain 2 at (0, 0.0045, 0) m: must"),
    "a drum": (DRUM, LARGE.format(0.008) + SMALL_ROW.format(0), "must be 0.0018 m from the walls"),
    "one kind": (DRUM, LARGE.format(0), "no grain of small_radius = 0.001 m"),
}


@pytest.mark.parametrize(("system", "text", "words"), WRONG_FILES.values(), ids=WRONG_FILES)
def test_a_bad_file_is_refused_in_one_line_that_names_what_is_wrong(system, text, words, tmp_path):
    (name, changes), path = system, tmp_path / "bed.txt"
    path.write_text(text)
    p = CASES[name].default.replace(places=str(path), **changes)
    with pytest.raises(RequestError, match=rf"^[^\n]*{re.escape(words)}[^\n]*$"):
        CASES[name].job(p)


def test_a_file_that_is_not_there_and_a_broken_one_are_refused(tmp_path):
    (tmp_path / "broken.xz").write_bytes(b"nothing packed")
    for name in ("none.txt", "broken.xz"):
        p = CASES["penetration"].default.replace(places=str(tmp_path / name), **BED[1])
        with pytest.raises(RequestError, match="cannot be read"):
            CASES["penetration"].job(p)


def test_places_are_those_of_the_file_seen_from_the_corner_packed_or_not(tmp_path):
    text = HEAD + "2\n" + ROW.format(0.002) + ROW.format(-0.004)
    (tmp_path / "bed.txt").write_text(text)
    (tmp_path / "bed.txt.xz").write_bytes(lzma.compress(text.encode()))
    kinds = (("radius", CASES["penetration"].default.grain),)
    for path in tmp_path.iterdir():
        (places,) = beds.read_places(Places(str(path), Box(0.02, 0.02), kinds))
        np.testing.assert_allclose(places, [[0.012, 0.01, 0.001], [0.006, 0.01, 0.001]])


def test_the_published_beds_touch_their_walls():
    p = CASES["penetration"].presets[PUBLISHED]
    (places,) = beds.read_places(p._file)
    assert places.shape == (25000, 3)
    assert places.min(axis=0) == pytest.approx(1e-3, abs=2e-6)
    assert places[:, :2].max(axis=0) == pytest.approx([0.097, 0.059], abs=2e-6)
    p = CASES["drum"].presets[PUBLISHED]
    assert p.counts == (8000, 30000)
    for places, kind in zip(beds.read_places(p._file), p.kinds, strict=True):
        assert p._file.walls.gap(places).min() == pytest.approx(kind.radius, abs=3e-6)
    table = Path(CASES["drum"].job(p).values["places"]).read_text("utf-8").partition("Atoms")[2]
    types = [int(line.split()[1]) for line in table.splitlines() if line]
    assert (types.count(1), types.count(2)) == (8000, 30000)


@pytest.mark.live
def test_lammps_reads_the_places_and_drops_the_sphere_at_its_offset(lammps, tmp_path):
    path, case, grid = tmp_path / "bed.txt", CASES["penetration"], (-2e-3, 0.0, 2e-3)
    path.write_text("".join(f"0.001 {x} {y} 0.001\n" for x in grid for y in grid))
    p = case.default.replace(places=str(path), **BED[1], duration=0.05)
    first, second = lammps.run([case.job(p), case.job(p.replace(offset=2e-3))])
    values = case.measure(p, first)
    # nine grains of one layer that touch: twelve pairs, and the floor is no grain
    assert values["bed_coordination"] == pytest.approx(24 / 9)
    volume = 9 * 4 / 3 * np.pi * 1e-9
    assert values["bed_solid_fraction"] == pytest.approx(volume / (0.02 * 0.02 * 0.002))
    assert values["energy_gain_ratio"] < 1e-3
    height = second.table(("z_m",))["z_m"][-1]
    assert height != pytest.approx(values["final_height_m"], rel=1e-6)


@pytest.mark.parametrize("code", ["lammps", "liggghts", "yade", "kratos"])
@pytest.mark.live
@pytest.mark.slow
def test_a_code_reads_the_drum_of_a_file(code, tmp_path):
    """Grains that touch nothing fall as one: h = g (n dt)^2/2, to a step."""
    needs(code)
    path, case = tmp_path / "drum.txt", CASES["drum"]
    path.write_text("0.002 0 0 0.005\n0.001 -0.004 0 0.005\n0.001 0.004 0 0.005\n")
    p = case.default.replace(places=str(path), **DRUM[1])
    (output,) = run(engine_class(code), case.job(p))
    table = output.table(("step", "x_m", "y_m", "z_m"))
    np.testing.assert_allclose(table["x_m"][0], [0.0, -0.004, 0.004], atol=1e-9)
    fall = 0.5 * p.gravity * (p.step_size * p.steps) ** 2
    np.testing.assert_allclose(table["z_m"][-1], 0.005 - fall, atol=2.0 / p.steps * fall)


# ---- the longest step


def test_the_longest_step_is_by_rayleigh_waves_of_steel_or_by_an_impact():
    # 0.2 pi r sqrt(rho/G)/(0.1631 nu + 0.8766), the sphere's
    p = CASES["penetration"].default
    wave = math.pi * 4e-3 * math.sqrt(7200 * 2.4 / 2.1e9) / (0.1631 * 0.2 + 0.8766)
    assert p.longest_step == pytest.approx(0.2 * wave)
    # a fast sphere: Hertz's contact time of a grain on steel, by its two moduli
    p = p.replace(speed=100.0, step_size=1e-6)
    modulus = 1 / ((1 - 0.04) / 1e7 + (1 - 0.04) / 2.1e9)
    speed = math.hypot(100.0, math.sqrt(2 * 9.81 * 0.026))
    deepest = (15 * p.grain.mass * speed**2 / (16 * math.sqrt(p.radius) * modulus)) ** 0.4
    assert p.longest_step == pytest.approx(2.9432 * deepest / speed / 20, rel=1e-3)


@pytest.mark.parametrize("nu", [0.0, 0.2, 0.35, 0.49])
def test_the_rayleigh_wave_of_the_step_is_the_root_of_rayleighs_equation(nu):
    """(2 - s)^2 = 4 sqrt(1 - s) sqrt(1 - s c), s = (speed over that of shear)^2."""
    pressed = (1 - 2 * nu) / (2 - 2 * nu)

    def secular(s):
        return (2 - s) ** 2 - 4 * math.sqrt((1 - s) * (1 - s * pressed))

    speed = math.sqrt(brentq(secular, 0.5, 1 - 1e-12))
    shear = math.sqrt(1e9 / (2 * (1 + nu)) / 2500.0)
    step = RAYLEIGH_SHARE * math.pi * 2e-3 / (speed * shear)
    assert Sphere(2e-3, 2500.0, 1e9, nu).rayleigh_step == pytest.approx(step, rel=4e-3)


# ---- elastic energies


@pytest.mark.parametrize("name", ["silo", "heap", "penetration"])
def test_the_elastic_energy_of_columns_is_below_its_bound(name):
    """Columns of grains, the k-th contact from above bears k grains."""
    p = CASES[name].default
    modulus, reduced = p.youngs_modulus / (2 * (1 - 0.04)), p.radius / 2
    weights = p.grain.mass * p.gravity * np.append(np.arange(1, p.column), p.column)
    energies = 0.4 * weights * (weights / (4 / 3 * modulus * math.sqrt(reduced))) ** (2 / 3)
    assert p.grains / p.column * energies.sum() < p.largest_elastic_energy
    assert p.largest_elastic_energy == pytest.approx(3 * p.grains * energies[-1])


@pytest.mark.parametrize("nu", [0.0, 0.2, 0.49])
def test_a_tangential_spring_holds_most_at_coulombs_limit(nu):
    friction, modulus, radius, overlap = 0.3, 1e7, 1e-3, 2e-6
    contact = modulus / (1 - nu**2) / 2, modulus / (1 + nu) / 2 / (2 * (2 - nu)), radius / 2
    young, shear, size = contact
    width = math.sqrt(size * overlap)
    normal = quad(lambda d: 4 / 3 * young * math.sqrt(size) * d**1.5, 0, overlap, epsabs=0)[0]
    force = friction * 4 / 3 * young * math.sqrt(size) * overlap**1.5
    slide = force / (8 * shear * width)
    tangential = quad(lambda s: 8 * shear * width * s, 0, slide, epsabs=0)[0]
    p = CASES["penetration"].default.replace(poisson_ratio=nu, friction=friction)
    assert tangential / normal == pytest.approx(p.tangential_share, rel=1e-7)
    assert p.replace(friction=0.0, steel_friction=0.0).tangential_share == 0.0


def spring_energy(places, radius, young, walls, steel):
    """Return what normal springs hold [J], each pair and wall by hand, and the pairs that touch.

    ``walls`` are the distances of all places from each wall [m]; all have Poisson's ratio 0.2.
    """

    def spring(overlap, modulus, other, size):
        compliance = 0.96 * (1 / modulus + 1 / other)
        return np.where(overlap > 0, 8 / 15 / compliance * np.sqrt(size) * abs(overlap) ** 2.5, 0)

    i, j = np.triu_indices(len(places), 1)
    overlap = radius[i] + radius[j] - np.linalg.norm(places[i] - places[j], axis=1)
    total = spring(overlap, young[i], young[j], 1 / (1 / radius[i] + 1 / radius[j])).sum()
    total += sum(spring(radius - distance, young, steel, radius).sum() for distance in walls)
    return total, {*zip(i[overlap > 0], j[overlap > 0], strict=True)}


def test_pairs_of_a_drum_that_touch_and_what_they_hold_are_those_of_all_pairs():
    p = drum.Drum(drum_radius=0.014, drum_length=0.0105, small_layers=2, large_layers=0)
    room = 0.65 * p.drum_radius, 0.45 * p.drum_length, 0.65 * p.drum_radius
    places = np.random.default_rng(4).uniform(-1.0, 1.0, (p.grains, 3)) * room
    radii, (x, y, z) = p.of_each("radius"), places.T
    young = np.where(radii == p.large_radius, p.large_youngs_modulus, p.small_youngs_modulus)
    walls = p.drum_radius - np.hypot(x, z), 0.5 * p.drum_length - abs(y)
    held, pairs = spring_energy(places, radii, young, walls, p.steel_youngs_modulus)
    contacts = find_contacts(places, radii)
    assert {*zip(contacts.i, contacts.j, strict=True)} == pairs
    assert drum.elastic_energy(p, places, contacts) == pytest.approx(held, rel=1e-12)


SMALL_BED = SMALL["penetration"].replace(along=5, across=4, settle_time=0.05, duration=0.03)


def results_by_hand(p, lmp, folder, **more):
    """Run the script of a small bed by hand; return its results, and its particles by step."""
    case, script = CASES["penetration"], folder / "penetration.in"
    script.write_text(Lammps.script(case.template).text, encoding="utf-8")
    values = {**case.job(p).values, "dump": "all", "record": "yes", **more}
    sets = (word for name, value in values.items() for word in ("-var", name, str(value)))
    command = [lmp, "-in", str(script), "-log", "log", "-screen", "none", *sets]
    subprocess.run(command, cwd=folder, check=True)
    lines = (folder / "all").read_text("utf-8").splitlines()
    block = int(lines[3]) + 9
    frames = {
        int(lines[i + 1]): np.loadtxt(lines[i + 9 : i + block]) for i in range(0, len(lines), block)
    }
    return dict(results_in((folder / "log").read_text("utf-8"))), frames


@pytest.mark.slow
@pytest.mark.live
def test_the_script_measures_the_springs_of_its_places_and_changes_nothing(lmp, tmp_path):
    results, frames = results_by_hand(SMALL_BED, lmp, tmp_path)
    series = (tmp_path / "penetration.csv").read_bytes()
    for name, step in (("elastic_J", SMALL_BED.settle_steps), ("end_elastic_J", max(frames))):
        kind, places, radius = frames[step][:, 1], frames[step][:, 2:5], frames[step][:, 8]
        young = np.where(kind == 1, SMALL_BED.youngs_modulus, SMALL_BED.steel_youngs_modulus)
        x, y, z = places.T
        walls = x, SMALL_BED.box.length - x, y, SMALL_BED.box.width - y, z
        held, _ = spring_energy(places, radius, young, walls, SMALL_BED.steel_youngs_modulus)
        # overlaps are counted in bins of 4e-8 m, some 1e-2 of one: at random over all contacts
        assert float(results[name]) == pytest.approx(held, rel=5e-3), name
    # looked at each 500 steps, no bit of the motion changes
    results_by_hand(SMALL_BED, lmp, tmp_path, thermo=500)
    assert (tmp_path / "penetration.csv").read_bytes() == series


@pytest.mark.live
def test_grains_that_lie_alone_hold_two_fifths_of_weight_times_overlap(lmp, tmp_path):
    p = SMALL_BED.replace(along=3, across=3, layers=1, spacing=2.0, scatter=0.0, settle_time=0.2)
    results, _ = results_by_hand(p, lmp, tmp_path)
    both = p.youngs_modulus * p.steel_youngs_modulus / (p.youngs_modulus + p.steel_youngs_modulus)
    weight, modulus = p.grain.mass * p.gravity, both / (1 - p.poisson_ratio**2)
    overlap = (0.75 * weight / modulus / math.sqrt(p.radius)) ** (2 / 3)
    held = p.grains * 0.4 * weight * overlap
    assert float(results["elastic_J"]) == pytest.approx(held, rel=1e-3)  # it still swings
