"""Silo: geometry, readings, small runs in LAMMPS and LIGGGHTS."""

import math

import numpy as np
import pytest
from scipy.integrate import quad

from harness.cases.bulk.series import largest_gain
from harness.cases.bulk.silo import CASE, STRESS_RATIO, Silo
from harness.engines.contract import Job
from harness.errors import EngineLostAtomsError, EngineOutputError, EngineUndecidedError
from harness.theory.bulk import janssen_share
from tests.cases.bulk.doubles import LIGGGHTS, StandIn, own_rows, silo_output, silo_series

TINY = Silo(
    layers=5, silo_radius=0.012, orifice_radius=0.008, cone_height=0.004, settle_time=0.1,
    duration=0.4,
)  # fmt: skip


def test_the_published_silos_have_a_hundred_thousand_grains_and_walls_of_45_deg():
    for name in ("published", "published-wide"):
        p = CASE.presets[name]
        assert p.grains == pytest.approx(1e5, rel=0.01)
        assert p.silo_radius - p.orifice_radius == pytest.approx(p.cone_height)


def test_the_surface_of_a_bed_is_at_the_mean_height_of_the_grains():
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


def measure(p=None, table=None, **changes):
    p = p or Silo()
    return CASE.measure(p, silo_output(p, table, **changes))


def test_the_rate_is_the_slope_of_the_number_that_remains():
    p, found = Silo(), measure()
    assert found["discharge_rate_per_s"] == pytest.approx(2000.0, rel=1e-3)
    assert found["discharge_rate_kg_per_s"] == pytest.approx(2000.0 * p.grain.mass, rel=1e-3)
    assert found["half_time_s"] == pytest.approx(0.1 + 0.5 * p.grains / 2000.0, abs=3e-3)
    assert found["passed_ratio"] == 1.0
    assert found["energy_rise_ratio"] == 0.0
    assert found["bed_kinetic_ratio"] == pytest.approx(1e-3)
    assert found["walls_load_ratio"] == pytest.approx(1.0)


def test_an_orifice_that_arches_and_one_that_still_runs_are_undecided():
    with pytest.raises(EngineUndecidedError, match=r"arching: 900 grains of 1200 remain, none has"):
        measure(stop=900.0)
    with pytest.raises(EngineUndecidedError, match=r"duration = 1 s is too short"):
        measure(rate=500.0)


def test_a_grain_beyond_a_wall_is_an_error_and_no_result():
    p = Silo()
    table = silo_series(p)
    table["astray"][100] = 1
    with pytest.raises(EngineLostAtomsError, match=r"a grain is beyond the walls 0.202 s after"):
        measure(p, table)
    with pytest.raises(EngineLostAtomsError, match=r"beyond the walls 0 s after the opening"):
        measure(p, grains=p.grains - 1)
    with pytest.raises(EngineOutputError, match="began with 1201 grains of 1200"):
        measure(p, grains=p.grains + 1)


def test_a_series_that_lacks_rows_is_an_error():
    p = Silo()
    table = {name: np.delete(values, range(200, 203)) for name, values in silo_series(p).items()}
    with pytest.raises(EngineOutputError, match="lacks rows"):
        measure(p, table)


def test_a_rise_after_a_fall_is_a_gain():
    assert largest_gain(np.array([3.0, 2.0, 1.0])) == 0.0
    assert largest_gain(np.array([3.0, 1.0, 1.5, 0.5])) == 0.5


def test_the_load_of_the_shaft_is_compared_with_janssen_s():
    p, found = Silo(), measure()
    height = found["bed_height_m"]
    share = janssen_share(height - p.cone_height, p.silo_radius, p.steel_friction, STRESS_RATIO)
    share *= 1.0 - p.volume(p.cone_height) / p.volume(height)
    row = own_rows(StandIn("silo"))["shaft_load_ratio"]
    assert (row.value, row.expected) == (pytest.approx(0.1), pytest.approx(share))
    assert measure(Silo(steel_friction=0.0))["janssen_load_ratio"] == 0.0


@pytest.mark.live
def test_a_small_silo_in_lammps_runs_empty_and_its_walls_bear_the_weight(lammps):
    rested, arched = (
        TINY.replace(settle_time=0.4),
        TINY.replace(orifice_radius=2.2e-3, cone_height=9.8e-3),
    )
    outputs = lammps.run([CASE.job(rested), CASE.job(arched)])
    found = CASE.measure(rested, outputs[0])
    assert found["passed_ratio"] == 1.0
    assert found["walls_load_ratio"] == pytest.approx(1.0, abs=5e-3)
    assert found["energy_rise_ratio"] < 1e-2
    with pytest.raises(EngineUndecidedError, match="arching"):
        CASE.measure(arched, outputs[1])


@pytest.mark.live
@pytest.mark.slow
@LIGGGHTS
def test_triangles_that_leave_a_hole_are_an_error_and_no_result():
    from harness.engines.liggghts.engine import Liggghts

    holed = Job(CASE.template, {**TINY.values, "open_facets": 20}, sampled=True)
    with Liggghts() as engine:
        good, bad = engine.run([CASE.job(TINY), holed])
    assert CASE.measure(TINY, good)["passed_ratio"] == 1.0
    with pytest.raises(EngineLostAtomsError, match="they leave a hole"):
        CASE.measure(TINY, bad)
