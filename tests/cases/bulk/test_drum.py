"""Drum: what is refused, what is read, faults that turn each check, small runs."""

import math
import shutil
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from harness.cases.bulk.mixing import touching
from harness.cases.bulk.places import PUBLISHED
from harness.cases.bulk.seeds import Runs
from harness.cases.drum import CASE, COLUMNS, Drum, drum_energy, elastic_energy, values_of
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
    rows = ({**row, "mixing_index": s * 0.7, **changes, "seed": s} for s in spread)
    return Runs(engine, tuple(rows), equivalent=CASE.equivalent)


@pytest.mark.parametrize(
    ("fault", "turned"),
    [
        ({}, None),
        ({"drum_energy_gain_ratio": 0.1}, 0),
        ({"drum_energy_gain_ratio": math.nan}, 0),
        ({"bed_kinetic_ratio": 0.02}, 1),
        ({"bed_kinetic_ratio": math.nan}, 1),
    ],
)
def test_a_planted_fault_turns_its_check(fault, turned):
    sound = {"drum_energy_gain_ratio": 0.01, "elastic_ratio": 0.012, "bed_kinetic_ratio": 1e-3}
    rows = CASE.judge(CASE.judged, runs(**{**sound, **fault}), Drum())
    expected = [Verdict.FAIL if i == turned else Verdict.PASS for i in range(2)]
    assert [row.verdict for row in rows] == expected


def turning(p, speed):
    """Return frames of grains that turn with the drum as a rigid body, in so many rad/s."""
    table = frames(p)
    t = p.step_size * (table["step"] - p.settle_steps)
    angle = speed * t[:, None]
    x, z = table["x_m"], table["z_m"]
    c, s = np.cos(angle), np.sin(angle)
    return {**table, "x_m": x * c + z * s, "z_m": z * c - x * s}


def test_a_drum_that_sets_a_rigid_body_in_motion_loses_its_kinetic_energy():
    """As a belt does that grains are laid on: work = speed L = 2 E_kin, besides what it lifts."""
    p = Drum()
    energy, work = drum_energy(p, turning(p, p.speed))
    table = frames(p)
    inertia = (p.masses * (table["x_m"][0] ** 2 + table["z_m"][0] ** 2)).sum()
    kinetic = 0.5 * inertia * p.speed**2
    lost = work[1:-1] - (energy[1:-1] - energy[0])
    # of differences over turns of 1.8 deg: 0.031^2/6 at most
    assert np.abs(lost - kinetic).max() < 2e-4 * work[-1]
    assert read(turning(p, p.speed))["loss_ratio"] == pytest.approx(kinetic / work[-1], abs=4e-4)


def test_grains_that_rise_against_the_drum_gain_energy():
    found = read(turning(Drum(), -Drum().speed))
    assert found["work_ratio"] < 0.0
    assert found["drum_energy_gain_ratio"] > 0.5


@pytest.mark.parametrize("height", [-0.02, -0.01, 0.0, 0.01])
def test_the_solid_fraction_is_that_of_a_bed_up_to_a_level(height):
    """The section below a height and its centre, by sums over strips."""
    p = Drum()
    z, step = np.linspace(-p.drum_radius, height, 200_001, retstep=True)
    width = 2.0 * np.sqrt(np.maximum(p.drum_radius**2 - z**2, 0.0))
    section = width.sum() * step
    solid = p.large_grains * p.large.volume + p.small_grains * p.small.volume
    expected = solid / (section * p.drum_length)
    assert p.solid_fraction((width * z).sum() / width.sum()) == pytest.approx(expected, rel=1e-4)


def test_pairs_that_touch_and_what_they_hold_are_those_of_all_pairs():
    p = TINY
    rng = np.random.default_rng(4)
    room = 0.65 * p.drum_radius, 0.45 * p.drum_length, 0.65 * p.drum_radius
    places = rng.uniform(-1.0, 1.0, (p.grains, 3)) * room
    young = np.where(p.radii == p.large_radius, p.large_youngs_modulus, p.small_youngs_modulus)
    pairs, held = [], 0.0
    for i in range(p.grains):
        for j in range(i):
            overlap = p.radii[i] + p.radii[j] - math.dist(places[i], places[j])
            if overlap > 0.0:
                pairs.append((j, i))
                modulus = 1 / (0.96 * (1 / young[i] + 1 / young[j]))
                size = p.radii[i] * p.radii[j] / (p.radii[i] + p.radii[j])
                held += 8 / 15 * modulus * math.sqrt(size) * overlap**2.5
        for reach in (
            p.drum_radius - math.hypot(places[i][0], places[i][2]),
            0.5 * p.drum_length - abs(places[i][1]),
        ):
            overlap = max(0.0, p.radii[i] - reach)
            modulus = 1 / (0.96 * (1 / young[i] + 1 / p.steel_youngs_modulus))
            held += 8 / 15 * modulus * math.sqrt(p.radii[i]) * overlap**2.5
    contacts = touching(places, p.radii)
    found = zip(contacts.i, contacts.j, strict=True)
    assert {tuple(sorted(pair)) for pair in found} == set(pairs)
    assert elastic_energy(p, places, contacts) == pytest.approx(held, rel=1e-12)


@pytest.mark.parametrize(
    ("fault", "verdicts"),
    [
        ({}, [Verdict.PASS] * 4),
        ({"mixing_index": 0.6}, [Verdict.FAIL, *[Verdict.PASS] * 3]),
        ({"surface_angle_deg": 28.0}, [Verdict.PASS, Verdict.FAIL, *[Verdict.PASS] * 2]),
        ({"mixing_index": 0.7 / 0.95}, [Verdict.NOT_TESTED, *[Verdict.PASS] * 3]),
        ({"bed_coordination": 9.0}, [*[Verdict.PASS] * 3, Verdict.FAIL]),
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


@pytest.mark.live
def test_the_work_by_weight_and_angular_momentum_is_that_of_the_walls_forces(lammps):
    """A second route: in LAMMPS the power of each contact, F (omega x r), step by step.

    It tells of one contact of a grain with a region only: the ends are smooth planes here.
    """
    kind, template = type(lammps), CASE.template
    text = kind.script(template).text
    for size in ("large", "small"):
        name = f"drum_of_{size}"
        old = f"fix {name} {size} wall/gran/region granular ${{{size}_on_steel}} region drum\n"
        assert old in text
        force, point = (f"f_{name}[{i}]" for i in (2, 7)), (f"f_{name}[{i}]" for i in (4, 5))
        (fx, z), (fz, x) = force, point
        text = text.replace(
            old,
            f"{old[:-1]} contacts\n"
            f"variable power_{size} atom v_speed*({fx}*{z}-{fz}*{x})\n"
            f"compute power_{size} all reduce sum v_power_{size}\n",
        )
    closed = "units box rotate v_turned"
    assert closed in text
    text = text.replace(closed, "units box open 1 open 2 rotate v_turned")
    ends = (
        "fix ends all wall/gran granular hooke 50 0.02 damping velocity tangential linear_nohistory"
    )
    text = text.replace("timestep ", f"{ends} 0 0 yplane -${{half}} ${{half}}\ntimestep ")
    began = "run $(v_stretch:%.0f) post no\n"
    before, _, rest = text.rpartition(began)
    both = "c_power_large c_power_small"
    text = f"{before}fix power all ave/time 1 1 1 {both} ave running\n{began}{rest}"
    told = 'print "RESULT power = $(f_power[1]+f_power[2]:%.12g)"\n'
    text = text.replace('print "RESULT outside', told + 'print "RESULT outside')
    watching = replace(kind.script(template), text=text)

    class Watching(kind):
        @classmethod
        def script(cls, template, variant=""):  # noqa: ARG003
            return watching

    p = TINY.replace(turn=120.0)
    with Watching() as engine:
        (found,) = engine.run([CASE.job(p)])
    assert not isinstance(found, Exception), found
    work = found.number("power") * p.steps * p.step_size
    _, done = drum_energy(p, found.table(COLUMNS))
    assert done[-1] == pytest.approx(work, rel=0.02)


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


@pytest.mark.slow
@pytest.mark.skipif(shutil.which("liggghts") is None, reason="liggghts is not installed")
def test_liggghts_starts_from_the_same_places_and_turns_the_same_way(lammps):
    from harness.engines.liggghts.engine import Liggghts

    jobs = [CASE.job(TINY)]
    with Liggghts() as other:
        one, two = (engine.run(jobs)[0] for engine in (lammps, other))
    first, second = (CASE.read(TINY, found, TRAITS) for found in (one, two))
    assert second["surface_angle_deg"] == pytest.approx(first["surface_angle_deg"], abs=8.0)
    assert one.table(("x_m",))["x_m"].shape == two.table(("x_m",))["x_m"].shape


def test_level_full_has_the_published_drum_from_four_beginnings():
    """Its places are given: rests of other lengths part its motions."""
    assert len(CASE.systems("default")) == 1
    _, published = CASE.systems("full")
    assert published.name == "drum: published"
    runs = published.trials.values()
    assert [p.replace(settle_time=0.0) for p in runs] == [CASE.presets[PUBLISHED]] * 4
    assert len({p.settle_steps for p in runs}) == 4
    assert max(p.settle_steps * p.step_size for p in runs) < 0.05
