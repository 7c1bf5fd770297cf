"""Drum: what is refused, what is read, faults that turn each check, small runs."""

import math
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from harness.cases.bulk.seeds import Runs
from harness.cases.drum import CASE, Drum, values_of
from harness.comparison.verdicts import Verdict
from harness.engines.contract import Job
from harness.engines.lammps.engine import Lammps
from harness.engines.output import Output
from harness.errors import EngineLostAtomsError, EngineOutputError, RequestError
from harness.observables.provenance import Provenance

TINY = Drum(drum_radius=0.014, drum_length=0.0105, small_layers=2, large_layers=0, speed=5.3,
            turn=90.0, settle_time=0.1)  # fmt: skip
TRAITS = Lammps.traits

WRONG = [
    ({"large_layers": -5}, "large_layers = -5: no large grain finds room in the drum"),
    ({"large_layers": 9}, "small_layers = 4: no small grain finds room in the drum"),
    ({"scatter": 0.3}, "scatter = 0.3: grains overlap at the start; must be at most spacing - 1"),
    ({"step_size": 1e-4}, "step_size = 0.0001 s: must be at most"),
    ({"speed": 0.0}, "speed = 0.0 rad/s: must be greater than 0"),
]


@pytest.mark.parametrize(("changes", "words"), WRONG)
def test_what_cannot_be_simulated_is_refused_in_one_line(changes, words):
    with pytest.raises(RequestError) as refused:
        Drum(**changes)
    assert words in str(refused.value)
    assert "\n" not in str(refused.value)


def test_froude_number_filling_and_numbers_are_those_that_were_published():
    p = Drum()
    assert p.speed**2 * p.drum_radius == pytest.approx(2.0**2 * 0.1, rel=2e-3)
    assert p.small_grains / p.large_grains == pytest.approx(30000 / 8000, rel=0.06)
    solid = 4 / 3 * math.pi * (8000 * 8 + 30000) * 1e-9
    assert p.fill == pytest.approx(solid / 0.6 / (math.pi * 0.01 * 0.06), rel=0.06)


def frames(p, slope=0.5):
    """Return grains at random below a plane through the axis, the same in every frame."""
    rng = np.random.default_rng(3)
    r = 0.9 * p.drum_radius * np.sqrt(rng.uniform(0, 1, p.grains))
    phi = rng.uniform(-math.pi, 0, p.grains) - math.atan(slope)
    x, z = r * np.cos(phi), r * np.sin(phi)
    steps = p.settle_steps + p.every * np.arange(p.steps // p.every + 1)
    rows = np.ones((len(steps), 1))
    y = rng.uniform(-0.4, 0.4, p.grains) * p.drum_length
    return {"step": steps, "x_m": rows * x, "y_m": rows * y, "z_m": rows * z}


def output(p, table, **changes):
    results = {
        "bed_kinetic_J": 1e-9, "large": p.large_grains, "small": p.small_grains, "outside": 0,
        "steps": p.settle_steps + p.steps, "verdict": "finished",
    }  # fmt: skip
    told = tuple((name, str(value)) for name, value in {**results, **changes}.items())
    return Output(told, Provenance("lammps", "1"), {"series": table}, seconds=1.0)


def read(table=None, **changes):
    p = Drum()
    return CASE.read(p, output(p, table or frames(p), **changes), TRAITS)


def test_grains_at_random_below_a_plane_are_mixed_and_have_its_angle():
    found = read()
    assert found["mixing_index"] == pytest.approx(1.0, abs=0.05)
    assert found["mixing_index"] == pytest.approx(found["first_mixing_index"])
    assert found["surface_angle_deg"] == pytest.approx(math.degrees(math.atan(0.5)), abs=5.0)


def test_a_quadrant_holds_the_share_of_its_part_of_the_plane():
    found, part = read(), math.atan(0.5) / math.pi
    for kind in ("large", "small"):
        assert found[f"{kind}_rising_ratio"] == pytest.approx(part, abs=0.09)
        assert found[f"{kind}_falling_ratio"] == pytest.approx(0.5 - part, abs=0.09)


def test_a_grain_beyond_a_wall_and_another_number_are_errors():
    for column, value in (("x_m", 0.03), ("y_m", 0.011)):
        table = frames(Drum())
        table[column][50, 0] = value
        with pytest.raises(EngineLostAtomsError, match=r"beyond the walls after 90 deg"):
            read(table)
    with pytest.raises(EngineOutputError, match="small = 1"):
        read(small=1)


def runs(engine="LAMMPS", **changes):
    row = {**read(), "mixing_index": 0.7, "surface_angle_deg": 31.0}
    spread = (0.98, 0.99, 1.0, 1.01, 1.02)
    rows = ({**row, "mixing_index": s * 0.7, **changes} for s in spread)
    return Runs(engine, tuple(rows))


def test_a_planted_fault_turns_its_check():
    for value, verdict in ((1e-3, Verdict.PASS), (0.02, Verdict.FAIL), (math.nan, Verdict.FAIL)):
        (row,) = CASE.judge(CASE.judged, runs(bed_kinetic_ratio=value), Drum())
        assert row.verdict is verdict


@pytest.mark.parametrize(
    ("fault", "verdicts"),
    [
        ({}, [Verdict.PASS, Verdict.PASS]),
        ({"mixing_index": 0.6}, [Verdict.FAIL, Verdict.PASS]),
        ({"surface_angle_deg": 28.0}, [Verdict.PASS, Verdict.FAIL]),
        ({"mixing_index": 0.7 / 0.95}, [Verdict.NOT_TESTED, Verdict.PASS]),
    ],
)
def test_codes_that_part_fail_in_the_quantity_that_parts(fault, verdicts):
    assert [
        row.verdict for row in CASE.verification.compared([runs(), runs("LIGGGHTS", **fault)])
    ] == verdicts


@pytest.fixture(scope="module")
def lammps():
    with Lammps() as engine:
        yield engine


def test_the_drum_drags_grains_by_friction_alone(lammps):
    """A planted fault: without friction on the drum, it turns beneath a level bed."""
    jobs = [
        CASE.job(TINY),
        Job(CASE.template, {**values_of(TINY), "steel_friction": 0.0}, "", True),
    ]
    rough, smooth = (CASE.read(TINY, one, TRAITS) for one in lammps.run(jobs))
    assert rough["surface_angle_deg"] > 15.0
    assert abs(smooth["surface_angle_deg"]) < 5.0


SLIDING = """
units si
atom_style sphere
boundary f f f
comm_modify vel yes
region box block -0.05 0.05 -0.05 0.05 -0.05 0.05 units box
create_box 1 box
create_atoms 1 single 0 0 -0.04 units box
set group all diameter 0.004
set group all density 2500
pair_style granular
pair_coeff * * hertz/material 1e7 0.5 0.2 tangential mindlin NULL 0 0.2 damping coeff_restitution
variable turned equal 5*dt*step
region drum cylinder y 0 0 0.042 -0.02 0.02 units box rotate v_turned 0 0 0 0 1 0
fix wall all wall/gran/region granular hertz/material 1e7 0.5 0.2 tangential mindlin NULL 0 0.2 damping coeff_restitution region drum
fix weight all gravity 9.81 vector 0 0 -1
fix move all nve/sphere
timestep 1e-5
velocity all set 0 0 0
compute spin all property/atom omegay
compute sum all reduce sum c_spin
thermo_style custom step c_sum
run 500
print "FOUND $(vcm(all,x):%.10g)"
print "FOUND $(c_sum:%.10g)"
"""  # noqa: E501


def test_the_velocity_of_a_turning_region_is_in_its_contacts(tmp_path):
    """A grain at rest on the lowest line of a drum that turns about +y, dragged to -x.

    The wall moves at -omega R there, so that the grain slides: m dv/dt = -mu N, 2/5 m r^2 dspin/dt
    = mu N r (about +y, as the drum) with N = m g in the mean, hence spin = -5 v/(2 r).
    """
    (tmp_path / "in.lmp").write_text(SLIDING)
    lmp = Path(sys.executable).with_name("lmp")
    words = [str(lmp), "-in", "in.lmp", "-log", "none"]
    said = subprocess.run(words, cwd=tmp_path, capture_output=True, text=True, check=True).stdout
    found = [line.split()[1] for line in said.splitlines() if line.startswith("FOUND")]
    v, spin = map(float, found)
    assert v == pytest.approx(-0.2 * 9.81 * 5e-3, rel=0.1)
    assert spin == pytest.approx(-2.5 * v / 2e-3, rel=0.01)


@pytest.mark.skipif(shutil.which("liggghts") is None, reason="liggghts is not installed")
def test_liggghts_starts_from_the_same_places_and_turns_the_same_way(lammps):
    from harness.engines.liggghts.engine import Liggghts

    jobs = [CASE.job(TINY)]
    with Liggghts() as other:
        one, two = (engine.run(jobs)[0] for engine in (lammps, other))
    first, second = (CASE.read(TINY, found, TRAITS) for found in (one, two))
    assert second["surface_angle_deg"] == pytest.approx(first["surface_angle_deg"], abs=8.0)
    assert one.table(("x_m",))["x_m"].shape == two.table(("x_m",))["x_m"].shape
