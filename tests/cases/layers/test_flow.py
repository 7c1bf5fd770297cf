"""Layers in steady flow: sums to profiles, balances, faults that turn them, flows without means."""
# ruff: noqa: I001

import math
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from harness.cases.bench import Bench
from harness.cases.checks import run_checks, selected
from harness.cases.layers.flow import (
    BALANCES, CASE, GRAIN_DENSITY, SLICE, SMALL, STEADY, SUMS, Flow, Measurement,
)  # fmt: skip
from harness.errors import EngineLostAtomsError, EngineOutputError, EngineUndecidedError
from harness.results.rows import Verdict
from tests.cases.common import made

SHEAR, FRACTION, TEMPERATURE = 0.2, 0.6, 0.03


FLOW = Flow(blocks=6, angle=20.0)


def line(block, values):
    return " ".join(repr(float(value)) for value in (block + 1, *values))


def uniform(case=FLOW, growth=0.0):
    """A flow of uniform density and shear from z = 0 to H, in balance: every sum in closed form."""
    area, tilt = case.length * case.width, math.radians(case.angle)
    density = GRAIN_DENSITY * FRACTION
    height = case.layers / density  # a grain of mass 1 on each d^2 and layer
    z = SLICE * (np.arange(math.ceil(height / SLICE) - 1) + 0.5)
    mass = density * area * SLICE * np.ones_like(z)
    lost = case.layers * area - mass.sum()  # of the last slice, which is not full
    z, mass = np.append(z, z[-1] + SLICE), np.append(mass, lost)
    speed = SHEAR * z
    above = (np.cumsum(mass[::-1])[::-1] - 0.5 * mass) / area
    normal, shear = above * math.cos(tilt), above * math.sin(tilt)
    kinetic = mass * TEMPERATURE
    volume = area * SLICE
    weight = mass.sum()
    texts = [("mass", weight), ("block_time", 20.0), ("verdict", "flowed"), ("steps", 1)]
    for block in range(case.blocks):
        more = 1.0 + growth * block
        columns = {
            "count": mass, "volume": mass / GRAIN_DENSITY, "mass": mass, "momentum": mass * speed,
            "mxx": kinetic + mass * speed**2, "myy": kinetic, "mzz": kinetic, "mxz": 0 * mass,
            "virial_xx": 0 * mass, "virial_yy": 0 * mass,
            "virial_zz": kinetic - normal * volume, "virial_xz": shear * volume,
        }  # fmt: skip
        for row in zip(z, *(columns[name] for name in SUMS), strict=True):
            texts.append(("slice", line(block, row)))
        along, out = weight * math.sin(tilt), -weight * math.cos(tilt)
        mean = float(mass @ z / weight)
        values = (mass @ speed / weight, 5.0 * more, 4.0, mean, along, out, 1.0, 1.0, 0.0, 0.0)
        texts.append(("block", line(block, values)))
    return made(texts)


def test_a_uniform_flow_is_measured_as_it_is():
    found, tilt = CASE.measure(FLOW, uniform()), math.radians(20.0)
    assert found["mu"] == pytest.approx(math.tan(tilt))
    assert found["mu_of_contacts"] == pytest.approx(math.tan(tilt))
    assert found["shear_rate"] == pytest.approx(SHEAR)
    assert found["solid_fraction"] == pytest.approx(FRACTION)
    assert found["granular_temperature"] == pytest.approx(TEMPERATURE)
    for name in BALANCES:
        assert found[name] == pytest.approx(1.0, abs=2e-3), name  # a slice is a quarter of d
    # at half the height half the weight is above
    pressure = 0.5 * FLOW.layers * math.cos(tilt)
    assert found["pressure"] == pytest.approx(pressure, rel=0.03)
    inertial = SHEAR / math.sqrt(pressure / GRAIN_DENSITY)
    assert found["inertial_number"] == pytest.approx(inertial, rel=0.02)
    assert found["mean_speed_uncertainty"] == pytest.approx(0.0, abs=1e-12)
    assert set(found) == {quantity.name for quantity in CASE.quantities}


def test_the_profile_holds_the_balance_at_every_height():
    profile = pd.DataFrame({name: [*v] for name, v in CASE.profile(FLOW, uniform()).items()})
    p = profile[profile["height"].between(0.9, 2.6)]  # below the last slice
    np.testing.assert_allclose(p["mu"], math.tan(math.radians(20.0)), rtol=1e-6)
    np.testing.assert_allclose(p["normal_stress"], p["weight_above"], rtol=1e-9)
    np.testing.assert_allclose(p["velocity"], SHEAR * p["height"], rtol=1e-6)
    inertial = SHEAR / np.sqrt(p["normal_stress"] / GRAIN_DENSITY)
    np.testing.assert_allclose(p["inertial_number"], inertial, rtol=1e-6)


@pytest.mark.parametrize(
    ("fault", "turned"),
    [
        (lambda m: replace(m, parameters=m.parameters.replace(angle=22.0)),
         {"momentum_balance", "weight_on_base", "shear_stress_balance"}),
        (lambda m: replace(m, area=1.2 * m.area),
         {"shear_stress_balance", "normal_stress_balance"}),
        (lambda m: replace(m, mass=1.05 * m.mass),
         {"momentum_balance", "weight_on_base", "shear_stress_balance", "normal_stress_balance"}),
        (lambda m: replace(m, sums={**m.sums, "virial_zz": 0.5 * m.sums["virial_zz"]}),
         {"normal_stress_balance"}),
        (lambda m: replace(m, sums={**m.sums, "virial_xz": -m.sums["virial_xz"]}),
         {"shear_stress_balance"}),
    ],
    ids=["gravity at another angle", "wrong area", "wrong mass", "half a virial", "wrong sign"],
)  # fmt: skip
def test_a_fault_turns_the_balances(fault, turned):
    found = fault(Measurement.of(FLOW, uniform())).quantities()
    assert {n for n, width in BALANCES.items() if abs(found[n] - 1) > width.relative} == turned


def test_a_flow_that_becomes_faster_has_no_means_and_keeps_its_values():
    case = Flow(blocks=6)
    with pytest.raises(EngineUndecidedError, match=r"becomes faster: .* changes by \+") as caught:
        CASE.measure(case, uniform(case, growth=0.1))
    assert caught.value.values["mean_speed"] > 0.0
    with pytest.raises(EngineUndecidedError, match="becomes slower"):
        CASE.measure(case, uniform(case, growth=-0.1))
    small = 0.5 * STEADY / case.blocks
    assert CASE.measure(case, uniform(case, growth=small))["mean_speed"] > 0.0


def test_a_steady_flow_that_fluctuates_is_seldom_called_unsteady():
    case, wrong = Flow(blocks=10), 0
    one = Measurement.of(case, uniform(case))
    rng = np.random.default_rng(11)
    for _ in range(400):
        blocks = one.blocks.copy()
        blocks[:, 2] = 5.0 * (1.0 + 0.3 * rng.standard_normal(case.blocks))
        drift = replace(one, blocks=blocks).drift
        wrong += abs(drift[0]) > drift[1]
    assert wrong <= 12  # 1 % of 400 is 4; more than 12 once in 3000


@pytest.mark.parametrize(
    ("results", "error", "words"),
    [
        ({"verdict": "stopped"}, EngineUndecidedError, "the flow stopped at angle = 14 deg"),
        ({"verdict": "fell_through"}, EngineLostAtomsError, "fell through the base"),
        ({"verdict": "flowed"}, EngineOutputError, "block"),
        ({"verdict": "else", "block": " ".join("1" * 11)}, EngineOutputError, "verdict 'else'"),
    ],
)
def test_a_run_without_a_flow_is_an_error(results, error, words):
    with pytest.raises(error, match=words):
        CASE.measure(Flow(), made(results))


SHORT = SMALL.replace(layers=3, length=6, settle_time=20.0, flow_time=20.0, blocks=6)


@pytest.mark.live
@pytest.mark.parametrize(
    "p", [SHORT, pytest.param(SMALL, marks=pytest.mark.slow)],
    ids=["a shorter flow", "the flow of level quick"],
)  # fmt: skip
def test_the_balances_hold_in_lammps_and_the_mean_speed_is_that_of_the_particles(
    lammps, monkeypatch, p
):
    """Sums of slices beside the centre of mass, which LAMMPS computes by itself."""
    monkeypatch.setattr("harness.cases.layers.flow.SMALL", p)
    bench = Bench(lammps)
    rows = run_checks(CASE.name, selected(CASE.name, CASE.checks(lammps), "quick"), bench)
    verdicts = {row.quantity: row.verdict for row in rows}
    assert {name for name, verdict in verdicts.items() if verdict is Verdict.PASS} == set(BALANCES)
    assert {verdicts[name] for name in ("inertial_number", "solid_fraction")} == {Verdict.RECORDED}
    (section,) = CASE.sections({"lammps": bench})
    assert len(section.drawings[0].draw().axes) == 2
    measured = Measurement.of(p, bench.output(CASE.job(p)))
    momentum, mass = (measured.sums[name].sum(axis=1) for name in ("momentum", "mass"))
    assert momentum / mass == pytest.approx(measured.blocks[:, 1], rel=1e-6)
    assert mass == pytest.approx(np.full(p.blocks, measured.mass), rel=1e-6)


@pytest.mark.live
def test_on_a_gentle_slope_it_stops(lammps):
    p = SMALL.replace(layers=2, settle_time=30.0, flow_time=40.0, blocks=6, angle=2.0)
    (output,) = lammps.run([CASE.job(p)])
    with pytest.raises(EngineUndecidedError, match="stopped at angle = 2"):
        CASE.measure(p, output)
