"""The drop: every engine's own fault turns the row that is made for it; closed forms; values."""

import math
import re
from dataclasses import replace

import numpy as np
import pytest

from harness.cases.base import LEVELS
from harness.cases.bench import Bench
from harness.cases.checks import run_checks
from harness.cases.drop import CASE, Drop, contacts
from harness.engines.reference import Reference
from harness.errors import EngineCrashError
from harness.model.law import Contact
from harness.results.rows import Verdict
from tests.cases.common import assert_refused, verdicts
from tests.cases.scene_faults import coefficient, scaled
from tests.engine_doubles import Clipping, FewDigits, Twin, lost, same


def verify(engine, setup=None):
    checks = [check for check in CASE.checks(engine) if setup in (None, check.setup)]
    return run_checks("drop", checks, Bench(engine))


@pytest.mark.parametrize("scheme", ["velocity-verlet", "mfix-euler", "mfix-adams-bashforth"])
def test_the_reference_qualifies(scheme):
    rows = verify(Reference(scheme))
    assert {row.verdict for row in rows} == {Verdict.PASS}
    assert len({row.key for row in rows}) == len(rows) == 26
    assert {row.level for row in rows} == {LEVELS[0]}


@pytest.mark.live
def test_lammps_qualifies(lammps):
    assert verdicts(verify(lammps)) == {Verdict.PASS}


# ---- planted faults


def stiffer(factor):
    return coefficient("normal_stiffness", factor)


def other_mass(scene):
    first, second = scene.bodies
    motion = "held" if second.motion == "frozen" else "frozen"
    return scene.replace(bodies=(first, second.replace(motion=motion)))


def other_tail(scene):
    weaker = min(scene.law.damping_coefficient, 0.99)  # an overdamped one would never end
    law = scene.law.replace(clipped=not scene.law.clipped, damping_coefficient=weaker)
    return scene.replace(law=law)


def late(scene, motion):
    """Let the sphere be found 20 steps late: until then the grain flies on."""
    if scene.every > 1:
        return motion
    shifted = np.concatenate([motion.velocity[:1].repeat(20, axis=0), motion.velocity[:-20]])
    place = motion.position[:1] + np.cumsum(shifted, axis=0) * scene.step
    return replace(motion, velocity=shifted, position=place)


def dragged(scene, motion):
    """Damp the motion along the tangent, as a dashpot on the whole relative velocity does."""
    contact_time = math.pi * math.sqrt(1.0 / scene.law.normal_stiffness)
    motion.velocity[:, :, 0] *= np.exp(-motion.time / contact_time)[:, None]
    return motion


def blind(_, motion):
    """Let the grain fly through the sphere."""
    return replace(motion, velocity=motion.velocity[:1].repeat(len(motion), axis=0))


def frozen(_, motion):
    first = np.zeros(len(motion), dtype=int)
    return replace(motion, position=motion.position[first], velocity=motion.velocity[first])


def interchanged(_, motion):
    return replace(motion, velocity=motion.velocity[:, :, [1, 0, 2]])


def faster(_, motion):
    return replace(motion, velocity=1.01 * motion.velocity)


HEAD_ON, PATH = "head-on, e = 0.5, attractive, m_eff full", "path_difference"
REST = "at rest under its weight"
FAULTS = {  # fault: (engine, setup and quantity of a row that must turn)
    "no dashpot": (Twin(coefficient("damping_coefficient", 0.0)), HEAD_ON, "restitution"),
    "m/2": (Twin(other_mass), HEAD_ON, "restitution"),
    "tail": (Twin(other_tail), HEAD_ON, "restitution"),
    "spring": (Twin(stiffer(2.0)), REST, "static_overlap_ratio"),
    "contact time": (Twin(stiffer(1.02)), "contact lasts its time", "contact_time_ratio"),
    "late contact": (Twin(same, late), "contact found within two steps", "onset_steps"),
    "no contact": (Twin(same, blind), "contact lasts its time", "contact_time_ratio"),
    "tangential drag": (Twin(same, dragged), "oblique contact", "angular_momentum_ratio"),
    "frozen": (Twin(same, frozen), "oblique contact", "angular_momentum_ratio"),
    "speed off": (Twin(same, faster), "energy of a free fall", "energy_ratio"),
    "gravity": (Twin(scaled("gravity", 1.001)), "free fall", "fall_ratio"),
    "columns interchanged": (Twin(same, interchanged), HEAD_ON, PATH),
    "stiffness off by 1e-6": (Twin(stiffer(1.0 + 1e-6)), HEAD_ON, PATH),
    "step off by 1e-6": (Twin(scaled("step", 1.0 + 1e-6)), "free fall", PATH),
    "gravity off by 1e-6": (Twin(scaled("gravity", 1.0 + 1e-6)), REST, PATH),
}  # fmt: skip


@pytest.mark.parametrize("fault", FAULTS)
def test_planted_fault_turns_its_row(fault):
    engine, setup, quantity = FAULTS[fault]
    assert quantity in {r.quantity for r in verify(engine, setup) if r.verdict is Verdict.FAIL}


@pytest.mark.parametrize(
    "change", [lost, lambda *_: EngineCrashError("it fell over"),
               lambda _, motion: replace(motion, velocity=np.full_like(motion.velocity, np.nan)),
               lambda _, motion: replace(motion, position=motion.position * [1.0, 1.0, np.nan])],
)  # fmt: skip
def test_spoiled_runs_fail_every_row(change):
    assert [row.verdict for row in verify(Twin(change_motion=change))] == 26 * [Verdict.FAIL]


def test_a_path_is_held_to_what_few_digits_resolve():
    def off(_, motion):
        return replace(motion, velocity=1.002 * motion.velocity)

    failing = [row for row in verify(FewDigits(same, off)) if row.verdict is Verdict.FAIL]
    assert sum(row.quantity == PATH for row in failing) > 10


def test_digits_that_do_not_show_a_contact_are_named_as_the_reason():
    assert {row.verdict for row in verify(FewDigits())} == {Verdict.PASS}
    engine = FewDigits()
    engine.traits = replace(engine.traits, digits=5)
    failing = [row for row in verify(engine) if row.verdict is Verdict.FAIL]
    assert len(failing) == 2
    assert all("must write at least 6" in row.note for row in failing)


def test_refused_contacts_are_not_tested():
    rows = verify(Clipping())
    refused = {row.setup for row in rows if row.verdict is Verdict.NOT_TESTED}
    assert refused == {f"head-on, {one.name}" for one in contacts() if not one.clipped}
    assert {row.verdict for row in rows} == {Verdict.PASS, Verdict.NOT_TESTED}
    assert {row.note for row in rows if row.setup in refused} == {"never attracts (clipped = True)"}


# ---- one run


@pytest.fixture(scope="module")
def measured():
    bench = Bench(Reference())
    return {n: CASE.measure(p, bench.output(CASE.job(p))) for n, p in CASE.presets.items()}


VERSION_1 = {  # values of version 1 with LAMMPS, of round-off 1e-9 of the scale
    "head-on": {"restitution": 0.499861222814022, "end_speed_m_per_s": 0.499861222814022,
                "largest_sampled_overlap_m": 0.000741591887082005,
                "end_overlap_m": -0.0026033501228},
    "plastic": {"restitution": 0.00919818294125297, "end_speed_m_per_s": 0.00919818294125297,
                "largest_sampled_overlap_m": 9.54383320069807e-05,
                "end_overlap_m": -0.000612689374970055},
    "static": {"largest_sampled_overlap_m": 0.00147004404082596, "end_overlap_m": 0.000981000000012,
               "end_speed_m_per_s": 2.87807733725346e-12},
    "fall": {"largest_sampled_overlap_m": -0.00942711469884006,
             "end_overlap_m": -0.00942711469884006, "end_speed_m_per_s": 0.892210742821435},
    "oblique": {"largest_sampled_overlap_m": 9.9999999999989e-05,
                "end_overlap_m": -0.000550041863888406, "end_speed_m_per_s": 1.00224289179818,
                "angular_momentum_ratio": 1.00000000000022},
}  # fmt: skip


@pytest.mark.parametrize("name", VERSION_1)
def test_values_of_the_presets(measured, name):
    parameters = CASE.presets[name]
    assert measured[name].keys() == VERSION_1[name].keys()
    for quantity, value in VERSION_1[name].items():
        size = CASE.quantity(quantity).size(parameters)
        assert abs(measured[name][quantity] - value) < 1e-9 * size
        exact = CASE.exact(parameters).get(quantity)
        assert exact is None or abs(value - exact) < 2e-3 * size


def test_a_short_run_takes_a_sample():
    assert Drop(duration=1e-30, every=7).steps == 7


def test_no_scale_exceeds_three_times_the_largest_value(measured):
    for quantity in CASE.quantities:
        found = {n: abs(f[quantity.name]) for n, f in measured.items() if quantity.name in f}
        largest = max(quantity.size(CASE.presets[name]) for name in found)
        assert largest <= 3.0 * max(found.values()), quantity.name


@pytest.mark.parametrize(
    ("values", "line"),
    [
        ({"gap": -0.3}, "gap = -0.3"),
        ({"diameter": 0.1, "gap": -0.03}, "must be greater than -0.025 m"),
        ({"speed": 1e5}, "would press itself 100 diameters in"),
        ({"speed": 1e-9}, "must be from 2.2e-10 to 0.5"),
        ({"steps_per_contact": 0.0}, "steps_per_contact = 0.0"),
        ({"density": 1e300}, "beyond floating point"),
        ({"mass": 1.0}, "no such parameter"),
        ({"contact": Contact(restitution=0.0)}, "contact.restitution = 0: must be greater than 0"),
        ({"contact": Contact(damping_ratio=2.0, effective_mass="half")}, "must be below 1.414"),
    ],
)
def test_bad_parameters(values, line):
    assert_refused(re.escape(line), Drop, **values)
