"""Parameters of bulk cases: refusals, steps, published beds, level beds, energies at rest."""

import math
import re

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq

from harness.cases.bulk import drum, penetration
from harness.cases.bulk.beds import PUBLISHED, RAYLEIGH_SHARE, Sphere, level_bed
from harness.engines.lammps.engine import Lammps
from harness.engines.output import read_dump
from harness.engines.registry import engine_class
from tests.cases.bulk.doubles import CASES, SMALL, changed, needs, replaced, run
from tests.cases.common import assert_refused

WRONG = [
    ("silo", {"orifice_radius": 0.03}, "orifice_radius = 0.03 m: must be less than silo_radius ="),
    ("silo", {"radius": 0.03}, "silo_radius = 0.024 m: no grain of radius = 0.03 m finds room"),
    ("drum", {"large_layers": -5}, "large_layers = -5: no large grain finds room in the drum"),
    ("drum", {"large_layers": 9}, "small_layers = 4: no small grain finds room in the drum"),
    ("penetration", {"start_height": 0.02}, "start_height = 0.02 m: the sphere overlaps the"),
    ("penetration", {"steel_radius": 0.013, "start_height": 0.1}, "must be at most 0.012"),
    ("penetration", {"offset": 0.012}, "offset = 0.012 m: the sphere is in a wall; must be within"),
    ("penetration", {"places": "bed.txt"}, "places = 'bed.txt': must be 'published' or empty"),
    ("penetration", {"places": PUBLISHED, "radius": 2e-3}, "radius = 0.002 m: must be 0.001 with"),
    ("drum", {"places": PUBLISHED}, "drum_radius = 0.024 m: must be 0.1 with places = 'published'"),
    ("heap", {"dispersity": 0.5}, "grains overlap at the start"),
    ("silo", {"radius": 1e-7}, "2e+05 grains find room in a row between walls: at most 3000"),
    ("drum", {"large_radius": 1e308}, "large_radius = 1e+308: must be 1e-30 to 1e+30 in size"),
    ("heap", {"duration": 1e308}, "duration = 1e+308: must be 1e-30 to 1e+30 in size"),
    ("heap", {"width": 2, "spacing": 3.0}, "width = 2: no grain finds room between the sides"),
    ("silo", {"scatter": 0.3}, "scatter = 0.3: grains overlap at the start; must be at most 0."),
    ("drum", {"step_size": 1e-4}, "step_size = 0.0001 s: must be at most"),
]


@pytest.mark.parametrize(("name", "changes", "words"), WRONG)
def test_what_cannot_be_simulated_is_refused_in_one_line(name, changes, words):
    assert_refused(re.escape(words), CASES[name].default.replace, **changes)


@pytest.mark.parametrize(("code", "name", "preset"),
                         [("yade", "drum", "slow"), ("kratos", "heap", "small")])  # fmt: skip
def test_codes_that_do_not_resist_rolling_refuse_it(code, name, preset):
    engine, case = engine_class(code).__new__(engine_class(code)), CASES[name]
    p = case.presets[preset]
    assert engine.refuses(case.job(p)).endswith(
        f"has no variable 'rolling_friction' (rolling_friction = {p.rolling_friction})"
    )
    assert not engine.refuses(case.job(p.replace(rolling_friction=0.0)))


# ---- published systems


def test_the_small_systems_are_like_the_published_ones():
    """Walls of 45 deg and a hundred thousand grains; Froude number, filling, numbers of grains."""
    for name in (PUBLISHED, f"{PUBLISHED}-wide"):
        p = CASES["silo"].presets[name]
        assert p.grains == pytest.approx(1e5, rel=0.01)
        assert p.silo_radius - p.orifice_radius == pytest.approx(p.cone_height)
    p = drum.Drum()
    assert p.speed**2 * p.drum_radius == pytest.approx(2.0**2 * 0.1, rel=2e-3)
    assert p.counts[1] / p.counts[0] == pytest.approx(30000 / 8000, rel=0.06)
    solid = 4 / 3 * math.pi * (8000 * 8 + 30000) * 1e-9
    share = sum(p.of_each("volume")) / p.drum_radius**2 / p.drum_length
    assert share == pytest.approx(solid / (0.01 * 0.06), rel=0.06)
    p = CASES["heap"].default  # the mean mass of an even range of diameters
    mean = p.grain.mass * np.mean(np.linspace(0.85, 1.15, 100_001) ** 3)
    assert p.weight / (p.grains * p.gravity) == pytest.approx(mean, rel=1e-5)


# ---- published beds


def test_the_published_beds_touch_their_walls():
    p, rows = CASES["penetration"].presets[PUBLISHED], penetration.BED.rows()
    assert rows.shape == (p.grains, 4) == (25000, 4)
    assert rows[:, 1:].min(axis=0) == pytest.approx(1e-3, abs=2e-6)
    assert rows[:, 1:3].max(axis=0) == pytest.approx([0.097, 0.059], abs=2e-6)
    assert rows[:, 3].max() + p.radius == pytest.approx(p.bed_top, rel=1e-12)
    radius, x, y, z = drum.BED.rows().T
    p = CASES["drum"].presets[PUBLISHED]
    for kind, count in zip(p.kinds, p.counts, strict=True):
        of_kind = radius == kind.radius
        assert of_kind.sum() == count
        gaps = p.drum_radius - np.hypot(x, z), 0.5 * p.drum_length - abs(y)
        assert np.min(gaps, axis=0)[of_kind].min() == pytest.approx(kind.radius, abs=3e-6)


@pytest.mark.live
def test_lammps_has_the_contacts_of_the_published_bed_and_the_sphere_at_its_offset(lammps):
    case = CASES["penetration"]
    p = case.presets[PUBLISHED].replace(duration=5e-6, offset=4e-3)
    (output,) = lammps.run([case.film_job(p, 2)])
    radius, *places = penetration.BED.rows().T
    contacts = drum.find_contacts(np.transpose(places), radius)
    assert output.number("coordination") == pytest.approx(2 * len(contacts[0]) / p.grains, rel=1e-3)
    assert output.number("mean_height_m") == pytest.approx(places[2].mean(), rel=1e-6)
    series = output.tables["series"]
    sphere = np.argmax(series["radius_m"][0])
    assert series["x_m"][0][sphere] == pytest.approx(0.049 + 4e-3, rel=1e-9)


@pytest.mark.parametrize("code", ["lammps", "liggghts", "yade", "kratos"])
@pytest.mark.live
@pytest.mark.slow
def test_a_code_begins_with_the_places_of_the_published_drum(code):
    needs(code)
    case = CASES["drum"]
    p = case.presets[PUBLISHED].replace(turn=1e-3)
    (output,) = run(engine_class(code), case.job(p))
    rows = drum.BED.rows()
    places = np.concatenate([rows[rows[:, 0] == kind.radius, 1:] for kind in p.kinds])
    found = np.stack([output.tables["series"][f"{axis}_m"][0] for axis in "xyz"], axis=1)
    assert np.abs(found - places).max() < 1e-7  # LIGGGHTS writes six digits


# ---- level beds


def test_a_level_bed_on_a_cone_and_in_a_drum_has_the_volume_of_its_closed_form():
    p = CASES["silo"].default
    low, high, cone = p.orifice_radius, p.silo_radius, p.cone_height
    slope, height = (high - low) / cone, 0.05
    first = low**2 * cone**2 / 2 + 2 * low * slope * cone**3 / 3 + slope**2 * cone**4 / 4
    volume = p.cone_volume + math.pi * high**2 * (height - cone)
    moment = math.pi * (first + high**2 * (height**2 - cone**2) / 2)
    found = level_bed(p.section, 0.0, 1.0, moment / volume)
    assert found == pytest.approx((height, volume), rel=1e-9)
    # R^2 (a - sin a cos a) of a circle, whose centre is 2/3 R sin^3 a/(a - sin a cos a) below
    p = drum.Drum()
    for angle in (0.6, 1.2, 2.0):
        part = angle - math.sin(angle) * math.cos(angle)
        centre = -2 / 3 * p.drum_radius * math.sin(angle) ** 3 / part
        found = level_bed(p.section, -p.drum_radius, p.drum_radius, centre)
        volume = part * p.drum_radius**2 * p.drum_length
        assert found == pytest.approx((-p.drum_radius * math.cos(angle), volume), rel=1e-9)


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


@pytest.mark.parametrize("nu", [0.0, 0.2, 0.49])
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
    column = p.grains * (2 * p.radius) ** 2 / p.floor_area
    weights = p.grain.mass * p.gravity * np.append(np.arange(1, column), column)
    energies = 0.4 * weights * (weights / (4 / 3 * modulus * math.sqrt(reduced))) ** (2 / 3)
    assert p.grains / column * energies.sum() < p.largest_elastic_energy
    assert p.largest_elastic_energy == pytest.approx(3 * p.grains * energies[-1])


@pytest.mark.parametrize("nu", [0.0, 0.49])
def test_a_tangential_spring_holds_most_at_coulombs_limit(nu):
    friction, young, size, overlap = 0.3, 1e7 / (1 - nu**2) / 2, 5e-4, 2e-6
    spring = 8 * 1e7 / (1 + nu) / 2 / (2 * (2 - nu)) * math.sqrt(size * overlap)  # 8 G* a
    normal = quad(lambda d: 4 / 3 * young * math.sqrt(size) * d**1.5, 0, overlap, epsabs=0)[0]
    slide = friction * 4 / 3 * young * math.sqrt(size) * overlap**1.5 / spring
    tangential = quad(lambda s: spring * s, 0, slide, epsabs=0)[0]
    p = CASES["penetration"].default.replace(poisson_ratio=nu, friction=friction)
    assert tangential / normal == pytest.approx(p.tangential_share, rel=1e-7)


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
    contacts = drum.find_contacts(places, radii)
    assert {*zip(*contacts[:2], strict=True)} == pairs
    assert drum.elastic_energy(p, places, contacts) == pytest.approx(held, rel=1e-12)


@pytest.mark.slow
@pytest.mark.live
def test_the_script_measures_the_springs_of_its_places_and_changes_nothing(tmp_path):
    case = CASES["penetration"]
    p = SMALL["penetration"].replace(along=5, across=4, settle_time=0.05, duration=0.03)
    dumps = f"variable dump string {tmp_path / 'all.dump'}\nvariable thermo "
    watched = changed(Lammps, lambda text: replaced(text, ("variable thermo ", dumps)))
    often = changed(Lammps, lambda text: replaced(text, ("index 10000 ", "index 500 ")))
    (output,), (looked,) = (run(kind, case.job(p)) for kind in (watched, often))
    frames = read_dump((tmp_path / "all.dump").read_text("utf-8"), "LAMMPS")
    for name, frame in (
        ("elastic_J", [*frames["step"]].index(p.settle_steps)),
        ("end_elastic_J", -1),
    ):
        kind, radius = frames["type"][frame], frames["radius_m"][frame]
        x, y, z = (frames[f"{axis}_m"][frame] for axis in "xyz")
        young = np.where(kind == 1, p.youngs_modulus, p.steel_youngs_modulus)
        walls = x, p.box[0] - x, y, p.box[1] - y, z
        places = np.column_stack([x, y, z])
        held, _ = spring_energy(places, radius, young, walls, p.steel_youngs_modulus)
        # overlaps are counted in bins of 4e-8 m, some 1e-2 of one: at random over all contacts
        assert output.number(name) == pytest.approx(held, rel=5e-3), name
    # looked at each 500 steps, no bit of the motion changes
    for name, column in output.tables["series"].items():
        assert np.array_equal(column, looked.tables["series"][name]), name
