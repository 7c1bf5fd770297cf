"""Bulk runs of codes: recorded and small ones, planted faults, rolling resistance, films."""

import math

import numpy as np
import pytest

from harness.cases.bulk.drum import Drum, energy_and_work
from harness.cases.bulk.heap import Heap
from harness.cases.bulk.silo import Silo
from harness.engines.base import Job
from harness.engines.lammps.engine import Lammps
from harness.engines.liggghts.engine import Liggghts
from harness.engines.registry import engine_class
from harness.errors import EngineLostAtomsError, EngineUndecidedError
from tests.cases.bulk.doubles import CASES, LIGGGHTS, SMALL, changed, needs, recorded, replaced, run

CODES = ("yade", "kratos")
SILO, DRUM, HEAP = (CASES[n] for n in ("silo", "drum", "heap"))
TINY_DRUM = Drum(drum_radius=0.014, drum_length=0.0105, small_layers=2, large_layers=0, speed=5.3,
                 turn=60.0, settle_time=0.1)  # fmt: skip
ALL = pytest.mark.parametrize("case", CASES.values(), ids=CASES)
EACH = pytest.mark.parametrize("code", CODES)


def job(case, p=None, **changes):
    """Return the job of a run, small unless given, with changed values of the script."""
    values = case.job(p or SMALL[case.name]).values
    return Job(case.template, {**values, **changes}, sampled=True)


# ---- recorded runs


@ALL
@EACH
def test_quantities_are_read_from_a_recorded_run(code, case):
    found = case.measure(SMALL[case.name], recorded(code, case))
    springs = {"elastic_ratio", "end_elastic_ratio", "balance_ratio"}  # scripts of LAMMPS alone
    springs = set() if case is DRUM else springs  # computed from places
    assert set(found) == {quantity.name for quantity in case.quantities} - springs
    assert all(math.isfinite(value) for value in found.values())
    assert found.get("energy_gain_ratio", 0.0) < 0.02
    assert found.get("bed_solid_fraction", 0.5) == pytest.approx(0.5, abs=0.12)
    if case is SILO:  # the walls bear what does not move
        assert found["walls_load_ratio"] == pytest.approx(1.0, abs=0.08)
        assert found["passed_ratio"] == 1.0
    if case is HEAP:
        assert 15.0 < found["angle_deg"] < 40.0
        assert 0.3 < found["remaining_ratio"] < 0.9
    if case is DRUM:  # grains rise at x < 0, so that the surface falls along +x
        assert 0.0 < found["surface_angle_deg"] < 40.0


# ---- small runs


@pytest.mark.live
@pytest.mark.slow
@ALL
@pytest.mark.parametrize("code", ["liggghts", *CODES])
def test_a_small_run_begins_as_lammps_s_and_settles_to_the_same_height(code, case, lammps):
    """Places at the start are one formula: after 10 steps of fall heights agree to round-off.

    A drum's grains are in another order: those of each kind are compared by their means.
    """
    needs(code)
    p = SMALL[case.name]
    short = {"settle_steps": 0 if case is DRUM else 10, "steps": 10, "series_every": 10}
    mine, first = lammps.run([job(case), job(case, **short)])
    theirs, begun = run(engine_class(code), job(case), job(case, **short))
    if case is DRUM:
        for name in ("x_m", "y_m", "z_m"):
            one, other = (o.tables["series"][name][0] for o in (first, begun))
            for kind in (slice(0, p.counts[0]), slice(p.counts[0], None)):
                assert other[kind].mean() == pytest.approx(one[kind].mean(), abs=1e-8), name
        # where the bed of some grains lies at the end
        ends = [
            [o.tables["series"][name][-1].mean() for name in ("x_m", "z_m")] for o in (mine, theirs)
        ]
        assert ends[1] == pytest.approx(ends[0], abs=0.05 * p.drum_radius)
        return
    one, other = (o.number("mean_height_m") for o in (first, begun))
    assert other == pytest.approx(one, rel=1e-8)
    found = [case.measure(p, o) for o in (mine, theirs)]
    name, width = ("remaining_ratio", 0.25) if case is HEAP else ("bed_solid_fraction", 0.05)
    assert found[1][name] == pytest.approx(found[0][name], rel=width)
    if case is SILO:  # a bed that is not quite at rest
        assert found[1]["walls_load_ratio"] == pytest.approx(1.0, abs=0.15)


HOLE = '"open_facets": 0'
LOST, UNDECIDED = EngineLostAtomsError, EngineUndecidedError
FAULTS = [  # a hole, a closed orifice, a drum that turns back, no floor, no side, ends that stay
    ("silo", (HOLE, '"open_facets": 20'), LOST),
    ("silo", ("self.spheres.remove_wall(self.floor)", "pass"), UNDECIDED),
    ("drum", ("self.wall, self.p.speed", "self.wall, -self.p.speed"), AssertionError),
    ("penetration", ("for place, normal in walls:", "for place, normal in walls[1:]:"), LOST),
    ("heap", ("in ((low, (0, 1, 0)), (high, (0, -1, 0))):", "in ((high, (0, -1, 0)),):"), LOST),
    ("heap", ("for end in self.ends:", "for end in ():"), UNDECIDED),
]
IN_OTHERS = [
    ("lammps", "heap", ("fix sides grains", "fix sides glued"), LOST),
    ("lammps", "heap", ("unfix ends", ""), UNDECIDED),
    ("liggghts", "silo", ("open_facets      index 0", "open_facets      index 20"), LOST),
]


@pytest.mark.live
@pytest.mark.slow
@pytest.mark.parametrize(
    ("code", "name", "fault", "error"),
    [*((code, *fault) for code in CODES for fault in FAULTS), *IN_OTHERS],
)
def test_a_planted_fault_turns_a_bulk_case(code, name, fault, error):
    needs(code)
    kind = changed(engine_class(code), lambda text: replaced(text, fault))

    def found():
        (output,) = run(kind, job(CASES[name]))
        assert CASES[name].measure(SMALL[name], output)["surface_angle_deg"] > 0.0

    with pytest.raises(error):
        found()


@pytest.mark.live
def test_a_small_silo_in_lammps_runs_empty_and_its_walls_bear_the_weight(lammps):
    tiny = Silo(layers=5, silo_radius=0.012, orifice_radius=0.008, cone_height=0.004, duration=0.3)
    rested = tiny.replace(settle_time=0.25)
    arched = tiny.replace(settle_time=0.1, orifice_radius=2.2e-3, cone_height=9.8e-3)
    outputs = lammps.run([SILO.job(rested), SILO.job(arched)])
    found = SILO.measure(rested, outputs[0])
    assert found["passed_ratio"] == 1.0
    assert found["walls_load_ratio"] == pytest.approx(1.0, abs=5e-3)
    assert found["energy_rise_ratio"] < 1e-2
    with pytest.raises(EngineUndecidedError, match="arching"):
        SILO.measure(arched, outputs[1])


@pytest.mark.live
def test_the_drum_drags_grains_by_friction_alone(lammps):
    """A planted fault: without friction on the drum, it turns beneath a level bed."""
    outputs = lammps.run([job(DRUM, TINY_DRUM), job(DRUM, TINY_DRUM, steel_friction=0.0)])
    rough, smooth = (DRUM.measure(TINY_DRUM, one)["surface_angle_deg"] for one in outputs)
    assert rough > 15.0
    assert abs(smooth) < 5.0


def with_power(text):
    """Return the script with the power of the drum's forces, F (omega x r), step by step.

    LAMMPS knows one contact of a grain with a region only: the ends are smooth planes here.
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
    result = 'print "RESULT power = $(f_power[1]+f_power[2]:%.12g)"\n'
    return replaced(
        text,
        *words,
        ("units box rotate v_turned", "units box open 1 open 2 rotate v_turned"),
        ("timestep ", f"fix ends all wall/gran {smooth} yplane -${{half}} ${{half}}\ntimestep "),
        ("run ${steps} post no\n", f"fix power all {mean}\nrun ${{steps}} post no\n"),
        ('print "RESULT outside', result + 'print "RESULT outside'),
    )


@pytest.mark.live
def test_the_work_by_weight_and_angular_momentum_is_that_of_the_walls_forces():
    p = TINY_DRUM.replace(rolling_friction=0.1)
    (found,) = run(changed(Lammps, with_power), DRUM.job(p))
    work = found.number("power") * p.steps * p.step_size
    _, done = energy_and_work(p, found.table(DRUM.series))
    assert done[-1] == pytest.approx(work, rel=0.02)


@pytest.mark.live
@pytest.mark.slow
def test_the_angle_grows_with_friction_of_sliding_then_of_rolling(lammps):
    """Means of seeds vary by 2 deg; friction 0, 0.2, 0.5, then 0.4 of rolling: 9, 23, 30, 42 deg.

    Packings without friction hold 5.76 deg (Peyneau and Roux, Phys. Rev. E 78, 011307 (2008)), a
    small heap more.
    """
    laws = [(0.0, 0.0), (0.2, 0.0), (0.5, 0.0), (0.5, 0.4)]
    trials = [Heap(friction=mu, rolling_friction=rolling) for mu, rolling in laws]
    found = lammps.run([HEAP.job(p) for p in trials])
    angle = [HEAP.measure(p, o)["angle_deg"] for p, o in zip(trials, found, strict=True)]
    assert np.diff(angle).min() > 3.0
    assert angle[0] < 15.0


@pytest.mark.live
@ALL
def test_each_case_has_a_film(case, lammps):
    short = {"turn": 30.0} if case is DRUM else {"duration": 0.05}
    p = SMALL[case.name].replace(settle_time=0.02, **short)
    (output,) = lammps.run([case.film_job(p, 5)])
    discs = case.discs(p, output)
    assert len(discs.time) in (5, 6)
    assert 0.7 < discs.time[-1] / (p.steps * p.step_size) < 1.01  # from the release on
    assert not np.allclose(discs.y[0], discs.y[-1])


# ---- rolling resistance

ROLLING = Drum(rolling_friction=0.1)
PAIRS = [("large", "large"), ("large", "small"), ("small", "small")]
COUNTS = (10, 20, 300)  # steps


class Rolling:
    """A pair of grains of a drum: one rolls on the other, which is held."""

    def __init__(self, pair, p=ROLLING):
        self.pair = [p.kinds[("large", "small").index(name)] for name in pair]
        one, other = self.pair
        reduced = one.radius * other.radius / (one.radius + other.radius)
        compliance, nu = 1.0 / one.youngs_modulus + 1.0 / other.youngs_modulus, p.poisson_ratio
        mass = 0.5 * (one.density + other.density) * 4.0 / 3.0 * math.pi * (2.0 * reduced) ** 3
        load = 0.5 * p.drum_radius / (4.0 * reduced) * mass * p.gravity
        contact = (0.75 * load * reduced * (1.0 - nu**2) * compliance) ** (1.0 / 3.0)
        shear = 1.0 / (2.0 * (1.0 + nu) * (2.0 - nu) * compliance)
        self.overlap, self.limit = contact**2 / reduced, p.rolling_friction * load * reduced
        spring = 8.0 * shear * contact * reduced**2
        self.spin = 0.1 * self.limit / spring / (10.0 * p.step_size)  # a tenth in ten steps

    def write(self, path, p=ROLLING):
        """Write the pair as grains 2 and 3: LIGGGHTS needs type 1, which the first one has."""
        kinds = [p.kinds[0], *self.pair]
        places = -0.5 * p.drum_radius, 0.0, sum(one.radius for one in self.pair) - self.overlap
        rows = [f"{i} {1 + p.kinds.index(one)} {2 * one.radius:.17g} {one.density} {x:.17g} 0 0"
                for i, (one, x) in enumerate(zip(kinds, places, strict=True), 1)]  # fmt: skip
        ends = [f"-0.1 0.1 {n}lo {n}hi" for n in "xyz"]
        head = ["grains", "", "3 atoms", "3 atom types", "", *ends, "", "Atoms", ""]
        path.write_text("\n".join([*head, *rows, ""]))


def torques(kind, folder):
    """Return torques [N m] of a grain that turns on another, by pair, after some numbers of steps.

    It spins across the normal, without friction of sliding. The last one of a pair is without
    rolling resistance.
    """
    turn = "omega 0 ${speed} 0" if kind is Lammps else "omegay ${speed}"
    words = (
        ("fix move all nve/sphere", f"set atom 3 {turn}\nfix move all nve/noforce"),
        ("compute kinetic all ke",
         "group last id 3\ncompute each last property/atom tqy\n"
         "compute torque last reduce sum c_each\ncompute kinetic all ke"),
        ("variable kinetic   equal c_kinetic+c_turning", "variable kinetic equal c_torque"),
    )  # fmt: skip
    values = dict.fromkeys(("large_friction", "small_friction", "mixed_friction"), 0.0)
    values |= {"steps": 1, "series_every": 1, "bed": "file"}
    jobs = []
    for pair in map(Rolling, PAIRS):
        path = folder / f"{len(jobs)}.data"
        pair.write(path)
        values |= {"places": str(path), "speed": pair.spin}
        trials = [*((ROLLING, n) for n in COUNTS), (ROLLING.replace(rolling_friction=0.0), 300)]
        jobs += [job(DRUM, p, settle_steps=n, **values) for p, n in trials]
    outputs = run(changed(kind, lambda text: replaced(text, *words)), *jobs)
    found = [abs(output.number("bed_kinetic_J")) for output in outputs]
    return np.reshape(found, (len(PAIRS), -1))


@pytest.mark.live
@pytest.mark.parametrize(
    "kind", [Lammps, pytest.param(Liggghts, marks=[LIGGGHTS, pytest.mark.slow])]
)
def test_rolling_is_a_spring_up_to_its_limit(kind, tmp_path):
    """k_t R*^2 times the angle, k_t = 8 G* a under half of a column; at most mu_r F_n R*."""
    limits = np.array([Rolling(pair).limit for pair in PAIRS])
    first, second, last, without = torques(kind, tmp_path).T
    assert second - first == pytest.approx(0.1 * limits, rel=1e-5, abs=0.0)
    assert last == pytest.approx(limits, rel=1e-5, abs=0.0)
    assert not without.any()
