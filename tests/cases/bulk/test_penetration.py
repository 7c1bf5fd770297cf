"""Penetration: what is refused, what is read, faults that turn each check, small runs."""

import math

import numpy as np
import pytest
from scipy.optimize import brentq

from harness.cases.bulk.materials import RAYLEIGH, Sphere
from harness.cases.bulk.seeds import Runs
from harness.cases.contract import Measured
from harness.cases.penetration import CASE, Penetration, largest_elastic_energy, values_of
from harness.cases.verification import Study
from harness.comparison.verdicts import Verdict
from harness.engines.contract import Job
from harness.engines.lammps.engine import Lammps
from harness.engines.liggghts.engine import Liggghts
from harness.engines.process import Limits
from harness.errors import EngineLostAtomsError, EngineOutputError
from tests.cases.bulk.doubles import made

TINY = Penetration(
    along=6, across=5, layers=3, start_height=0.0115, settle_time=0.06, duration=0.05
)
TRAITS = Lammps.traits


def test_the_longest_step_is_by_rayleigh_waves_of_steel_or_by_an_impact():
    # 0.2 pi r sqrt(rho/G)/(0.1631 nu + 0.8766), the sphere's
    wave = math.pi * 4e-3 * math.sqrt(7200 * 2.4 / 2.1e9) / (0.1631 * 0.2 + 0.8766)
    assert Penetration().longest_step == pytest.approx(0.2 * wave)
    # a fast sphere: Hertz's contact time of a grain on steel, by its two moduli
    p = Penetration(speed=100.0, step_size=1e-6)
    modulus = 1 / ((1 - 0.04) / 1e7 + (1 - 0.04) / 2.1e9)
    speed = math.hypot(100.0, math.sqrt(2 * 9.81 * 0.026))
    deepest = (15 * p.mass * speed**2 / (16 * math.sqrt(p.radius) * modulus)) ** 0.4
    assert p.longest_step == pytest.approx(2.9432 * deepest / speed / 20, rel=1e-3)


@pytest.mark.parametrize("nu", [0.0, 0.2, 0.35, 0.49])
def test_the_rayleigh_wave_of_the_step_is_the_root_of_rayleighs_equation(nu):
    """(2 - s)^2 = 4 sqrt(1 - s) sqrt(1 - s c), s = (speed over that of shear)^2."""
    pressed = (1 - 2 * nu) / (2 - 2 * nu)

    def secular(s):
        return (2 - s) ** 2 - 4 * math.sqrt((1 - s) * (1 - s * pressed))

    speed = math.sqrt(brentq(secular, 0.5, 1 - 1e-12))
    grain = Sphere(2e-3, 2500.0, 1e9, nu)
    shear = math.sqrt(1e9 / (2 * (1 + nu)) / 2500.0)
    assert grain.rayleigh_step == pytest.approx(
        RAYLEIGH * math.pi * 2e-3 / (speed * shear), rel=4e-3
    )


def test_the_elastic_energy_of_a_column_is_below_its_bound():
    """One column of grains, the k-th contact from above bears k grains."""
    p = Penetration()
    modulus, reduced = 1e7 / (2 * (1 - 0.04)), p.radius / 2
    weights = p.mass * p.gravity * np.arange(1, p.layers + 1)
    overlaps = (weights / (4 / 3 * modulus * math.sqrt(reduced))) ** (2 / 3)
    columns = p.along * p.across
    assert columns * (0.4 * weights * overlaps).sum() < largest_elastic_energy(p)
    one_layer = p.replace(layers=1, along=4, across=4)
    assert largest_elastic_energy(one_layer) == pytest.approx(
        3 * 16 * 0.4 * weights[0] * overlaps[0]
    )


def series(p, gained=0.0):
    """Return a sphere that falls, is stopped at 10 mm within 20 ms and stays there."""
    t = np.arange(1, 601) * p.duration / 600
    v = np.minimum(-p.speed * (1 - t / 0.02), 0.0)
    z = p.start_height + np.cumsum(v) * (t[1] - t[0])
    kinetic = 0.5 * p.steel_mass * v**2
    return {"time_s": t, "z_m": z, "vz_m_per_s": v, "kinetic_J": kinetic,
            "potential_J": np.full(600, 1e-4 + gained)}  # fmt: skip


def output(p, table, **changes):
    results = {
        "bed_kinetic_J": 0.0, "release_potential_J": 1e-4, "coordination": 4.2,
        "mean_height_m": 0.006, "grains": p.grains, "outside": 0,
        "steps": p.settle_steps + p.steps, "verdict": "finished",
    }  # fmt: skip
    return made(table, seconds=4.752, **{**results, **changes})


def test_quantities_follow_from_the_series_and_the_state_of_the_bed():
    p = Penetration()
    found = CASE.read(p, output(p, series(p)), TRAITS)
    last = series(p)["z_m"][-1]
    assert found["final_height_m"] == pytest.approx(last)
    assert found["final_depth_m"] == pytest.approx(0.012 + 0.004 - last)
    assert found["peak_deceleration_m_per_s2"] == pytest.approx(p.speed / 0.02)
    assert found["slowed_time_s"] == pytest.approx(0.018, abs=2 * p.duration / 600)
    assert found["energy_gain_ratio"] == 0.0
    assert found["dissipated_ratio"] == pytest.approx(1.0)
    # one grain in a cell of the lattice, which shrank from 9 * 2.4 mm to 12 mm
    assert found["bed_solid_fraction"] == pytest.approx(math.pi / 6 / 1.2**3 * 21.6 / 12)
    assert found["microseconds_per_particle_step"] == pytest.approx(0.1, rel=1e-2)


def test_the_friction_by_depth_takes_the_fall_to_the_surface_and_the_bed_with_its_voids():
    p, table = Penetration(), series(Penetration())
    table["z_m"] = table["z_m"] - 0.015
    found = CASE.read(p, output(p, table), TRAITS)
    depth = 0.012 + p.steel_radius - table["z_m"][-1]
    assert found["final_depth_m"] == pytest.approx(depth)
    height = p.start_height - p.steel_radius - 0.012 + p.speed**2 / (2 * p.gravity)
    ratio = p.steel_density / p.density / found["bed_solid_fraction"]
    expected = 0.14 * math.sqrt(ratio) * 0.008 ** (2 / 3) * (height + depth) ** (1 / 3) / depth
    assert found["friction_by_depth"] == pytest.approx(expected)
    above = CASE.read(p, output(p, series(p)), TRAITS)  # a sphere that never came to the bed
    assert math.isnan(above["friction_by_depth"])


def test_a_particle_beyond_a_wall_is_an_error_and_no_result():
    p = Penetration()
    with pytest.raises(EngineLostAtomsError, match="a particle passed a wall at step_size = 5e-06"):
        CASE.read(p, output(p, series(p), outside=1), TRAITS)


def test_another_number_of_grains_and_a_sphere_that_still_falls_are_errors():
    p = Penetration()
    with pytest.raises(EngineOutputError, match="grains = 1079"):
        CASE.read(p, output(p, series(p), grains=1079), TRAITS)
    falling = {**series(p), "vz_m_per_s": np.full(600, -0.3)}
    with pytest.raises(EngineOutputError, match="still falls at a tenth"):
        CASE.read(p, output(p, falling), TRAITS)


def impacts(**changes):
    p = Penetration()
    row = dict(CASE.read(p, output(p, series(p)), TRAITS))
    rows = tuple({**row, **changes, "seed": seed} for seed in range(5))
    return Runs("LAMMPS", rows, equivalent=CASE.equivalent)


def test_where_the_floor_ends_the_fall_the_known_depth_is_not_tested():
    p = Penetration()
    near = impacts(lowest_height_m=p.steel_radius + 1.9 * p.radius)
    depth = CASE.judge(CASE.judged, near, p)[-1]
    assert depth.verdict is Verdict.NOT_TESTED
    assert "stops 1.9 mm above it, less than a grain's diameter of 2 mm" in depth.note
    free = impacts(lowest_height_m=p.steel_radius + 2.1 * p.radius)
    assert CASE.judge(CASE.judged, free, p)[-1].verdict is Verdict.FINDING


class Impacts:
    """An engine that leaves the depth of its seed or place, and how long it was given."""

    workers = 2

    def __init__(self, name, traits, depth=1.0):
        self.name, self.title, self.traits, self.depth = name, name, traits, depth
        self.ran = []

    def refuses(self, job):  # noqa: ARG002
        return ""

    def run(self, jobs):
        self.ran += jobs
        return [
            self.depth * (1.0 + job.values["offset"] + 1e-3 * (job.values["seed"] % 3))
            for job in jobs
        ]


@pytest.fixture
def measured_by_place(monkeypatch):
    row = impacts().rows[0]
    monkeypatch.setattr(
        type(CASE), "measured", lambda _, trial, output, traits: Measured(  # noqa: ARG005
            {**row, "largest_depth_m": output, "final_depth_m": 1.0})
    )  # fmt: skip
    monkeypatch.setattr(type(CASE), "curves", lambda *_: ())


@pytest.mark.usefixtures("measured_by_place")
@pytest.mark.parametrize(("ratio", "verdict"), [(1.0, Verdict.PASS), (1.1, Verdict.FAIL)])
def test_levels_but_quick_run_the_published_bed_from_several_places(ratio, verdict):
    """Only there codes are held to the largest depth; its runs have the time that they need."""
    main, other = Impacts("lammps", TRAITS), Impacts("liggghts", Liggghts.traits, ratio)
    study = Study("default", role="other")
    found = {one.name: CASE.verification.run(one, study) for one in (main, other)}
    planned = [row.name for row in CASE.verification.planned("default", main)]
    assert [row.name for row in found["lammps"].checks] == planned
    rows = {row.name: row for row in CASE.verification.compare(found)}
    published = {name for name in rows if name.startswith("penetration: published: ")}
    quantities = {name.rpartition(": ")[2] for name in published}
    assert quantities == {"largest_depth_m", "slowed_time_s"}
    assert {name.rpartition(": ")[2] for name in set(rows) - published} == set(CASE.equivalent)
    held = rows["penetration: published: lammps against liggghts: largest_depth_m"]
    assert held.verdict is verdict
    *jobs, whole = [job for job in main.ran if job.values["bed"] == "file"]
    assert len({job.values["offset"] for job in jobs}) == len(jobs) == 4
    assert whole.values["steps"] * 5e-7 == pytest.approx(0.1, rel=1e-3)  # as long as published
    assert whole.values["offset"] == 0.0
    assert not [name for name in rows if "its whole time" in name]  # one run: no statistics
    assert len(main.ran) == 5 + CASE.seeds["default"]
    expected = CASE.seconds(CASE.systems("default")[1].parameters, TRAITS)
    assert {job.seconds for job in jobs} == {expected}
    assert Limits().time_for(expected) > 3600.0
    assert Limits().time_for(main.ran[0].seconds) == Limits().seconds


def test_a_small_bed_in_lammps_is_the_same_between_planes_and_in_a_region(lammps):
    """A block of planes or a region: round-off of places in the box, which the motion magnifies."""
    short = TINY.replace(settle_time=0.02, duration=0.005)
    jobs = [
        Job(CASE.template, {**values_of(short), **changes}, sampled=True)
        for changes in ({}, {"walls_as": "region"}, {"steel_friction": 0.5, "seed": 2})
    ]
    planes, region, other = lammps.run(jobs)
    assert region.number("mean_height_m") == pytest.approx(planes.number("mean_height_m"), rel=1e-8)
    assert other.number("mean_height_m") != pytest.approx(planes.number("mean_height_m"), rel=1e-5)


def test_a_small_impact_in_lammps_loses_energy_and_comes_to_rest(lammps):
    found = CASE.measure(TINY, lammps).values
    assert found["energy_gain_ratio"] == 0.0
    assert found["dissipated_ratio"] > 0.5
    assert 0.4 < found["bed_solid_fraction"] < 0.7
