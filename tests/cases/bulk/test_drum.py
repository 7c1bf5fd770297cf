"""Drum: sizes, readings, energy and work, rolling resistance in LAMMPS and LIGGGHTS."""

import math

import numpy as np
import pytest

from harness.cases.bulk.drum import CASE, COLUMNS, Drum, elastic_energy, energy_and_work
from harness.cases.bulk.mixing import find_contacts
from harness.cases.bulk.places import write_grains
from harness.engines.contract import Job
from harness.engines.lammps.engine import Lammps
from harness.engines.liggghts.engine import Liggghts
from harness.errors import EngineLostAtomsError, EngineOutputError
from tests.cases.bulk.doubles import LIGGGHTS, changed, drum_output, replaced, run, turning

TINY = Drum(drum_radius=0.014, drum_length=0.0105, small_layers=2, large_layers=0, speed=5.3,
            turn=90.0, settle_time=0.1)  # fmt: skip


def test_froude_number_filling_and_numbers_are_those_that_were_published():
    p = Drum()
    assert p.speed**2 * p.drum_radius == pytest.approx(2.0**2 * 0.1, rel=2e-3)
    assert p.small_grains / p.large_grains == pytest.approx(30000 / 8000, rel=0.06)
    solid = 4 / 3 * math.pi * (8000 * 8 + 30000) * 1e-9
    share = sum(p.of_each("mass") / p.of_each("density")) / p.drum_radius**2 / p.drum_length
    assert share == pytest.approx(solid / (0.01 * 0.06), rel=0.06)


def random_grains(p, slope=0.5):
    """Return places of grains at random below a plane through the axis, (N, 3) [m]."""
    rng = np.random.default_rng(3)
    r = 0.9 * p.drum_radius * np.sqrt(rng.uniform(0, 1, p.grains))
    phi = rng.uniform(-math.pi, 0, p.grains) - math.atan(slope)
    y = rng.uniform(-0.4, 0.4, p.grains) * p.drum_length
    return np.column_stack([r * np.cos(phi), y, r * np.sin(phi)])


def series(spin=0.0):
    return turning(Drum(), random_grains(Drum()), spin)


def measure(table=None, **changes):
    return CASE.measure(Drum(), drum_output(Drum(), table or series(), **changes))


def test_grains_at_random_below_a_plane_are_mixed_and_have_its_angle():
    found = measure()
    assert found["mixing_index"] == pytest.approx(1.0, abs=0.05)
    assert found["mixing_index"] == pytest.approx(found["first_mixing_index"])
    assert found["surface_angle_deg"] == pytest.approx(math.degrees(math.atan(0.5)), abs=5.0)


def test_a_quadrant_holds_the_share_of_its_part_of_the_plane():
    found, part = measure(), math.atan(0.5) / math.pi
    for kind in ("large", "small"):
        assert found[f"{kind}_rising_ratio"] == pytest.approx(part, abs=0.09)
        assert found[f"{kind}_falling_ratio"] == pytest.approx(0.5 - part, abs=0.09)


def test_a_grain_beyond_a_wall_and_another_number_are_errors():
    for column, value in (("x_m", 0.03), ("y_m", 0.011)):
        table = series()
        table[column][50, 0] = value
        with pytest.raises(EngineLostAtomsError, match=r"beyond the walls after 90 deg"):
            measure(table)
    with pytest.raises(EngineOutputError, match="small = 1"):
        measure(small=1)


def test_a_drum_that_sets_a_rigid_body_in_motion_loses_its_kinetic_energy():
    """As a belt under grains that are laid on it: work = speed L = 2 E_kin, and the lift."""
    p = Drum()
    energy, work = energy_and_work(p, series(p.speed))
    table = series()
    inertia = (p.of_each("mass") * (table["x_m"][0] ** 2 + table["z_m"][0] ** 2)).sum()
    kinetic = 0.5 * inertia * p.speed**2
    lost = work[1:-1] - (energy[1:-1] - energy[0])
    # of differences over turns of 1.8 deg: 0.031^2/6 at most
    assert np.abs(lost - kinetic).max() < 2e-4 * work[-1]
    assert measure(series(p.speed))["loss_ratio"] == pytest.approx(kinetic / work[-1], abs=4e-4)


def test_grains_that_rise_against_the_drum_gain_energy():
    found = measure(series(-Drum().speed))
    assert found["work_ratio"] < 0.0
    assert found["drum_energy_gain_ratio"] > 0.5


@pytest.mark.parametrize("height", [-0.02, -0.01, 0.0, 0.01])
def test_the_solid_fraction_is_that_of_a_bed_up_to_a_level(height):
    """The section below a height and its centre, by sums over strips."""
    p = Drum()
    z, step = np.linspace(-p.drum_radius, height, 200_001, retstep=True)
    width = 2.0 * np.sqrt(np.maximum(p.drum_radius**2 - z**2, 0.0))
    section = width.sum() * step
    solid = sum(p.of_each("volume"))
    expected = solid / (section * p.drum_length)
    assert p.solid_fraction((width * z).sum() / width.sum()) == pytest.approx(expected, rel=1e-4)


def test_pairs_that_touch_and_what_they_hold_are_those_of_all_pairs():
    p = TINY
    rng = np.random.default_rng(4)
    room = 0.65 * p.drum_radius, 0.45 * p.drum_length, 0.65 * p.drum_radius
    places = rng.uniform(-1.0, 1.0, (p.grains, 3)) * room
    radii = p.of_each("radius")
    young = np.where(radii == p.large_radius, p.large_youngs_modulus, p.small_youngs_modulus)
    pairs, held = [], 0.0
    for i in range(p.grains):
        for j in range(i):
            overlap = radii[i] + radii[j] - math.dist(places[i], places[j])
            if overlap > 0.0:
                pairs.append((j, i))
                modulus = 1 / (0.96 * (1 / young[i] + 1 / young[j]))
                size = radii[i] * radii[j] / (radii[i] + radii[j])
                held += 8 / 15 * modulus * math.sqrt(size) * overlap**2.5
        for reach in (
            p.drum_radius - math.hypot(places[i][0], places[i][2]),
            0.5 * p.drum_length - abs(places[i][1]),
        ):
            overlap = max(0.0, radii[i] - reach)
            modulus = 1 / (0.96 * (1 / young[i] + 1 / p.steel_youngs_modulus))
            held += 8 / 15 * modulus * math.sqrt(radii[i]) * overlap**2.5
    contacts = find_contacts(places, radii)
    found = zip(contacts.i, contacts.j, strict=True)
    assert {tuple(sorted(pair)) for pair in found} == set(pairs)
    assert elastic_energy(p, places, contacts) == pytest.approx(held, rel=1e-12)


def with_power(text):
    """Return the script with the power of the drum's forces, F (omega x r), step by step.

    LAMMPS tells of one contact of a grain with a region only: the ends are smooth planes here.
    """
    words = []
    for size in ("large", "small"):
        name = f"drum_of_{size}"
        old = f"fix {name} {size} wall/gran/region granular ${{{size}_on_steel}} region drum\n"
        fx, fz, x, z = (f"f_{name}[{i}]" for i in (2, 4, 5, 7))
        power = (
            f"variable power_{size} atom v_speed*({fx}*{z}-{fz}*{x})\n"
            f"compute power_{size} all reduce sum v_power_{size}\n"
        )
        words.append((old, f"{old[:-1]} contacts\n{power}"))
    smooth = "granular hooke 50 0.02 damping velocity tangential linear_nohistory 0 0"
    mean = "ave/time 1 1 1 c_power_large c_power_small ave running"
    said = 'print "RESULT power = $(f_power[1]+f_power[2]:%.12g)"\n'
    return replaced(
        text,
        *words,
        ("units box rotate v_turned", "units box open 1 open 2 rotate v_turned"),
        ("timestep ", f"fix ends all wall/gran {smooth} yplane -${{half}} ${{half}}\ntimestep "),
        ("run ${steps} post no\n", f"fix power all {mean}\nrun ${{steps}} post no\n"),
        ('print "RESULT outside', said + 'print "RESULT outside'),
    )


@pytest.mark.live
@pytest.mark.parametrize("rolling_friction", [0.0, 0.1])
def test_the_work_by_weight_and_angular_momentum_is_that_of_the_walls_forces(rolling_friction):
    p = TINY.replace(turn=120.0, rolling_friction=rolling_friction)
    (found,) = run(changed(Lammps, with_power), CASE.job(p))
    work = found.number("power") * p.steps * p.step_size
    _, done = energy_and_work(p, found.table(COLUMNS))
    assert done[-1] == pytest.approx(work, rel=0.02)


def test_the_drum_drags_grains_by_friction_alone(lammps):
    """A planted fault: without friction on the drum, it turns beneath a level bed."""
    jobs = [
        CASE.job(TINY),
        Job(CASE.template, {**TINY.values, "steel_friction": 0.0}, "", True),
    ]
    rough, smooth = (CASE.measure(TINY, one) for one in lammps.run(jobs))
    assert rough["surface_angle_deg"] > 15.0
    assert abs(smooth["surface_angle_deg"]) < 5.0


def torque(kind, p, pair, steps, spin, overlap):
    """Return the torque [N m] of a grain on another that is held in it and turns, by a script.

    Spinning across the normal at a rate [rad/s] for so many steps, without friction of sliding.
    """
    grains: dict[str, list[list[float]]] = {"large": [], "small": []}
    distance = sum(getattr(p, f"{name}_radius") for name in pair) - overlap
    for name, x in zip(pair, (0.0, distance), strict=True):
        grains[name].append([x, 0.0, 0.0])
    grains["large"] = grains["large"] or [[-0.5 * p.drum_radius, 0.0, 0.0]]  # LIGGGHTS needs type 1
    last = sum(map(len, grains.values()))
    kinds = [
        (np.reshape(grains[name], (-1, 3)), sphere)
        for name, sphere in zip(("large", "small"), p.kinds, strict=True)
    ]
    turn = f"omega 0 {spin} 0" if kind is Lammps else f"omegay {spin}"
    words = (
        ("fix move all nve/sphere", f"set atom {last} {turn}\nfix move all nve/noforce"),
        (
            "compute kinetic all ke",
            f"group last id {last}\ncompute each last property/atom tqy\n"
            "compute torque last reduce sum c_each\ncompute kinetic all ke",
        ),
        ("variable kinetic equal c_kinetic+c_turning", "variable kinetic equal c_torque"),
    )
    still = changed(kind, lambda text: replaced(text, *words))
    size = ((-0.1, 0.1),) * 3
    values = {**p.values, "bed": "file", "places": str(write_grains(kinds, size))}
    values |= dict.fromkeys(("large_friction", "small_friction", "mixed_friction"), 0.0)
    values |= {"settle_steps": steps, "steps": 1, "series_every": 1}
    (found,) = run(still, Job(CASE.template, values, sampled=True))
    return abs(found.number("bed_kinetic_J"))


@pytest.mark.live
@pytest.mark.parametrize(
    "kind", [Lammps, pytest.param(Liggghts, marks=[LIGGGHTS, pytest.mark.slow])]
)
@pytest.mark.parametrize("pair", [("large", "large"), ("large", "small"), ("small", "small")])
def test_rolling_is_a_spring_up_to_its_limit(kind, pair):
    """k_t R*^2 times the angle, k_t = 8 G* a under half of a column; at most mu_r F_n R*."""
    p, nu = Drum(rolling_friction=0.1), Drum().poisson_ratio
    one, other = (p.kinds[("large", "small").index(name)] for name in pair)
    reduced = one.radius * other.radius / (one.radius + other.radius)
    compliance = 1.0 / one.youngs_modulus + 1.0 / other.youngs_modulus
    grains = 0.5 * p.drum_radius / (4.0 * reduced)
    volume = 4.0 / 3.0 * math.pi * (2.0 * reduced) ** 3
    load = grains * 0.5 * (one.density + other.density) * volume * p.gravity
    contact = (0.75 * load * reduced * (1.0 - nu**2) * compliance) ** (1.0 / 3.0)
    overlap = contact**2 / reduced
    shear = 1.0 / (2.0 * (1.0 + nu) * (2.0 - nu) * compliance)
    spring = 8.0 * shear * contact * reduced**2
    limit = p.rolling_friction * load * reduced
    turn = 0.1 * limit / spring  # rad of ten steps
    spin = turn / (10.0 * p.step_size)
    rise = torque(kind, p, pair, 20, spin, overlap) - torque(kind, p, pair, 10, spin, overlap)
    assert rise == pytest.approx(0.1 * limit, rel=1e-5)
    assert torque(kind, p, pair, 300, spin, overlap) == pytest.approx(limit, rel=1e-5)
    assert torque(kind, p.replace(rolling_friction=0.0), pair, 300, spin, overlap) == 0.0
