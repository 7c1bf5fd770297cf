"""Silo: what is refused, what is read, faults that turn each check, small runs."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import quad

from harness.cases.bulk.rules import Law
from harness.cases.bulk.seeds import Runs
from harness.cases.bulk.series import largest_gain
from harness.cases.silo import (
    CASE,
    STRESS_RATIO,
    Silo,
    arching,
    largest_elastic_energy,
    values_of,
)
from harness.cases.verification import Study
from harness.comparison.verdicts import Verdict
from harness.engines.contract import Job
from harness.engines.lammps.engine import Lammps
from harness.errors import (
    EngineLostAtomsError,
    EngineOutputError,
    EngineUndecidedError,
)
from harness.theory.bulk import janssen_share
from tests.cases.bulk.doubles import LIGGGHTS, made

TINY = Silo(
    layers=5, silo_radius=0.012, orifice_radius=0.008, cone_height=0.004, settle_time=0.1,
    duration=0.4,
)  # fmt: skip
TRAITS = Lammps.traits


def test_the_published_silos_have_a_hundred_thousand_grains_and_walls_of_45_deg():
    for name in ("published", "published-wide"):
        p = CASE.presets[name]
        assert p.grains == pytest.approx(1e5, rel=0.01)
        assert p.silo_radius - p.orifice_radius == pytest.approx(p.cone_height)


def test_the_surface_of_a_bed_is_where_its_mean_height_is_that_of_the_grains():
    p = Silo(cone_height=0.02)

    def area(z):
        wide = min(1.0, z / p.cone_height)
        return math.pi * (p.orifice_radius + wide * (p.silo_radius - p.orifice_radius)) ** 2

    for height in (0.01, 0.05):
        volume, moment = (
            quad(lambda z, n=n: z**n * area(z), 0, height, points=[min(height, 0.02)])[0]
            for n in (0, 1)
        )
        assert p.volume(height) == pytest.approx(volume, rel=1e-9)
        assert p.surface(moment / volume) == pytest.approx(height, rel=1e-9)


def test_the_elastic_energy_of_a_column_is_below_its_bound():
    p = Silo()
    count = p.volume(0.045) * 0.6 / p.grain.volume / (math.pi * p.silo_radius**2 / 16e-6)
    loads = p.grain.mass * p.gravity * np.arange(1, count)
    columns = math.pi * p.silo_radius**2 / 16e-6
    energy = columns * sum(p.grain.elastic_energy(load) for load in loads)
    assert energy < largest_elastic_energy(p)


def series(p, stop=0.0, rate=2000.0):
    """Return grains that leave at one rate, from 0.1 s on, until so many remain."""
    t = np.arange(1, 501) * p.duration / 500
    remaining = np.clip(np.round(p.grains - rate * np.clip(t - 0.1, 0, None)), stop, None)
    potential = 1e-2 * remaining / p.grains
    return {"time_s": t, "remaining": remaining, "astray": np.zeros(500),
            "kinetic_J": np.full(500, 1e-3), "potential_J": potential}  # fmt: skip


def output(p, table, **changes):
    results = {
        "bed_kinetic_J": 1e-6, "released_J": 1.1e-2, "coordination": 4.9,
        "mean_height_m": p.surface(0.02) - 0.5 * p.cone_height, "grains": p.grains,
        "shaft_N": 0.1 * p.weight, "cone_N": 0.6 * p.weight, "floor_N": 0.3 * p.weight,
        "steps": p.settle_steps + p.steps, "verdict": "finished",
    }  # fmt: skip
    return made(table, **{**results, **changes})


def read(p=None, table=None, **changes):
    p = p or Silo()
    return CASE.read(p, output(p, table or series(p), **changes), TRAITS)


def test_the_rate_is_the_slope_of_what_remains():
    p = Silo()
    found = read(p)
    assert found["discharge_rate_per_s"] == pytest.approx(2000.0, rel=1e-3)
    assert found["discharge_rate_kg_per_s"] == pytest.approx(2000.0 * p.grain.mass, rel=1e-3)
    assert found["half_time_s"] == pytest.approx(0.1 + 0.5 * p.grains / 2000.0, abs=3e-3)
    assert found["passed_ratio"] == 1.0
    assert found["energy_rise_ratio"] == 0.0
    assert found["bed_kinetic_ratio"] == pytest.approx(1e-3)
    assert found["walls_load_ratio"] == pytest.approx(1.0)


def test_an_orifice_that_arches_is_no_rate():
    p = Silo()
    with pytest.raises(EngineUndecidedError, match=r"arching: 900 grains of 1200 remain, none has"):
        read(p, series(p, stop=900.0))
    with pytest.raises(EngineUndecidedError, match=r"duration = 1 s is too short"):
        read(p, series(p, rate=500.0))


def test_a_grain_beyond_a_wall_is_an_error_and_no_result():
    p = Silo()
    table = series(p)
    table["astray"][100] = 1
    with pytest.raises(EngineLostAtomsError, match=r"a grain is beyond the walls 0.202 s after"):
        read(p, table)
    with pytest.raises(EngineLostAtomsError, match=r"beyond the walls 0 s after the opening"):
        read(p, grains=p.grains - 1)
    with pytest.raises(EngineOutputError, match="began with 1201 grains of 1200"):
        read(p, grains=p.grains + 1)


def test_energy_may_fall_and_rise_by_no_more_than_it_fell_is_still_a_gain():
    assert largest_gain(np.array([3.0, 2.0, 1.0])) == 0.0
    assert largest_gain(np.array([3.0, 1.0, 1.5, 0.5])) == 0.5


def runs(engine="LAMMPS", **changes):
    row = dict(read())
    rate = row["discharge_rate_per_s"]
    spread = (0.98, 0.99, 1.0, 1.01, 1.02)
    rows = ({**row, "discharge_rate_per_s": s * rate, **changes, "seed": s} for s in spread)
    return Runs(engine, tuple(rows), equivalent=CASE.equivalent)


def test_the_load_of_the_shaft_stands_beside_janssens():
    p, found = Silo(), read()
    rows = CASE.judge(CASE.judged, runs(shaft_load_ratio=-0.02, walls_load_ratio=0.97), p)
    height = found["bed_height_m"]
    share = janssen_share(height - p.cone_height, p.silo_radius, p.steel_friction, STRESS_RATIO)
    share *= 1.0 - p.volume(p.cone_height) / p.volume(height)
    assert (rows[-1].value, rows[-1].expected) == (-0.02, pytest.approx(share))
    assert "All walls bear 0.97 of the weight" in rows[-1].note
    assert read(Silo(steel_friction=0.0))["janssen_load_ratio"] == 0.0


def test_codes_of_other_rates_fail_and_few_or_scattered_seeds_decide_nothing():
    same, other = runs(), runs("LIGGGHTS", discharge_rate_per_s=1700.0)
    verdicts = {
        row.name.rpartition(": ")[2]: row.verdict
        for row in CASE.verification.compared([same, other])
    }
    assert verdicts.pop("discharge_rate_per_s") is Verdict.FAIL
    assert set(verdicts.values()) == {Verdict.PASS}
    near = runs("LIGGGHTS", discharge_rate_per_s=2000.0 / 0.95)
    assert next(CASE.verification.compared([same, near])).verdict is Verdict.NOT_TESTED
    few = replace(same, engine="LIGGGHTS", rows=same.rows[:3])
    assert {row.verdict for row in CASE.verification.compared([same, few])} == {Verdict.NOT_TESTED}


def test_arches_are_shown_with_their_probability():
    row = arching("arching", 2, 5)
    assert row.value == 0.4
    # Wilson: centre (k + z^2/2)/(n + z^2), z = 1.96
    assert row.note == "2 of 5 seeds; 95 % interval 0.118 to 0.769"


class Arching:
    """An engine whose first runs arch."""

    name, title, traits, workers = "lammps", "LAMMPS", TRAITS, 99

    def __init__(self, arches):
        self.arches = arches

    def refuses(self, _):
        return ""

    def run(self, jobs):
        p, first = Silo(), self.arches
        return [output(p, series(p, stop=900.0 * (i < first))) for i in range(len(jobs))]


def test_seeds_that_arch_have_no_rate_and_are_counted():
    rows = {
        row.name.rpartition(": ")[2]: row
        for row in CASE.verification.run(Arching(1), Study()).checks
    }
    assert rows["arching"].value == pytest.approx(1 / CASE.seeds["default"])
    assert rows["no energy is gained"].verdict is Verdict.PASS
    rows = CASE.verification.run(Arching(4), Study("quick")).checks
    assert [row.name for row in rows] == [f"silo: lammps: {name}" for name in CASE.judged]
    assert {row.verdict for row in rows} == {Verdict.NOT_TESTED}
    assert rows[0].note.startswith("4 of 4 runs have no value; seed 1: undecided: arching: 900")


@pytest.mark.parametrize(
    ("arches", "law", "verdict"),
    [
        (1, Law(), Verdict.PASS),
        (8, Law(), Verdict.FAIL),
        (8, Law("of triangles"), Verdict.FINDING),
        (12, Law(), Verdict.FAIL),  # and then there is no mean at all
    ],
)
def test_a_code_that_arches_more_often_is_no_equivalent_of_the_others(arches, law, verdict):
    free = runs()
    free = replace(free, rows=(free.rows * 3)[:12], system="silo")
    arched = replace(free, engine="LIGGGHTS", rows=free.rows[arches:], undecided=arches, law=law)
    first, *others = CASE.verification.compared([free, arched])
    assert first.name == "silo: LAMMPS against LIGGGHTS: runs without a value"
    assert first.verdict is verdict
    assert f"0 of 12 and {arches} of 12" in first.note
    assert len(others) == len(CASE.equivalent)
    assert others[0].verdict is (Verdict.PASS if arches < 9 else Verdict.NOT_TESTED)
    assert "runs without" not in next(CASE.verification.compared([free, free])).name


def test_a_small_silo_in_lammps_runs_empty_and_its_walls_bear_the_weight(lammps):
    found = CASE.measure(TINY.replace(settle_time=0.4), lammps).values
    assert found["passed_ratio"] == 1.0
    assert found["walls_load_ratio"] == pytest.approx(1.0, abs=5e-3)
    assert found["energy_rise_ratio"] < 1e-2


def test_a_narrow_orifice_arches(lammps):
    with pytest.raises(EngineUndecidedError, match="arching"):
        CASE.measure(TINY.replace(orifice_radius=2.2e-3, cone_height=9.8e-3), lammps)


@LIGGGHTS
def test_triangles_that_leave_a_hole_are_an_error_and_no_result():
    from harness.engines.liggghts.engine import Liggghts

    holed = Job(CASE.template, {**values_of(TINY), "open_facets": 20}, sampled=True)
    with Liggghts() as engine:
        good, bad = engine.run([CASE.job(TINY), holed])
    assert CASE.read(TINY, good, TRAITS)["passed_ratio"] == 1.0
    with pytest.raises(EngineLostAtomsError, match="they leave a hole"):
        CASE.read(TINY, bad, TRAITS)


@pytest.mark.slow
@LIGGGHTS
def test_walls_of_twice_the_triangles_let_as_much_pass():
    from harness.engines.liggghts.engine import Liggghts

    trials = [Silo(seed=seed) for seed in range(1, 7)]
    with Liggghts() as engine:
        samples = []
        for facets in (60, 120):
            jobs = [
                Job(CASE.template, {**values_of(p), "facets": facets}, "", True) for p in trials
            ]
            pairs = zip(trials, engine.run(jobs), strict=True)
            rows = tuple(CASE.read(p, found, TRAITS) for p, found in pairs)
            samples.append(Runs(f"{facets} facets", rows, equivalent=CASE.equivalent))
    row = next(CASE.verification.compared(samples))
    assert row.verdict is Verdict.PASS, row.note
