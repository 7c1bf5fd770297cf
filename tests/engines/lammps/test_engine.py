import math
from functools import partial

import numpy as np
import pytest

from harness.cases.incline.angle import critical_angle_by_passage, critical_angle_by_steady_motion
from harness.cases.incline.runs import measured, read, run_inclines
from harness.cases.incline.system import TEMPLATE, Incline, Motion, job_of, values_of
from harness.engines.lammps.engine import Lammps
from harness.engines.output import Output, results_in
from harness.engines.process import Limits
from harness.engines.scripts import Script, Task
from harness.errors import EngineError, EngineMissingError
from harness.observables.provenance import Provenance
from harness.parameters.law import CONTACTS, PLASTIC, SOURCE
from harness.theory.incline import critical_angle, energies, passage_margin, well_depth

pytestmark = [pytest.mark.live, pytest.mark.usefixtures("lammps_here")]

CASES = [
    Incline(angle=angle, contact=contact) for angle in (9.9, 10.5) for contact in CONTACTS.values()
]
EARTH = Incline(angle=10.2)
GLASS = {"diameter": 0.003, "density": 2500.0}


def passage(measured):
    return lambda cases: measured(cases, "passage")


def ratio(run):
    return run.margin_J / run.case.weight_energy


def scaled(**changes):
    """Return the case with other units that keeps k d / (m g)."""
    other = EARTH.replace(stiffness=1e12, **changes)
    return other.replace(
        stiffness=other.mass * other.gravity / other.diameter / EARTH.static_overlap
    )


@pytest.fixture(scope="module")
def lammps():
    with Lammps(workers=2) as engine:
        yield engine


@pytest.fixture(scope="module")
def executable(lmp):
    with Lammps(lmp=lmp, workers=2) as engine:
        yield engine


@pytest.mark.parametrize("route", ["passage", "steady"])
def test_in_process_and_executable_agree_bitwise(lammps, executable, route):
    one, other = measured(lammps, CASES, route), measured(executable, CASES, route)
    assert [run.margin_J for run in one] == [run.margin_J for run in other]
    assert [run.motion for run in one] == [run.motion for run in other]
    assert [run.steps for run in one] == [run.steps for run in other]
    for a, b in zip(one, other, strict=True):
        assert a.crests.margin_J.tolist() == b.crests.margin_J.tolist()
        assert a.provenance.script_sha256 == b.provenance.script_sha256


def test_crest_energies_follow_the_recursion_of_the_theory(lammps):
    (run,) = measured(
        lammps, [Incline(angle=10.6, contact=PLASTIC, steps_per_contact=200)], "steady"
    )
    start = run.crests.margin_J[0] / run.case.weight_energy + well_depth(10.6)
    expected = energies(start, run.case.wells - 1, 10.6, 0.25) - well_depth(10.6)
    found = run.crests.margin_J[1:] / run.case.weight_energy
    # the finite stiffness, mg / (k d) = 1e-5, and the work done in the contacts
    assert found == pytest.approx(expected, abs=2e-4)


def test_margin_over_one_well_is_that_of_the_theory(lammps):
    cases = [
        Incline(angle=a, contact=PLASTIC, stiffness=1e7, steps_per_contact=200.0)
        for a in (9.8, 10.2, 10.6)
    ]
    for run in measured(lammps, cases, "passage"):
        assert ratio(run) == pytest.approx(passage_margin(run.case.angle, 0.25), abs=1e-4)


@pytest.mark.parametrize("contact", [SOURCE, PLASTIC], ids=lambda c: c.name)
def test_both_routes_give_the_critical_angle_in_few_runs(lammps, contact):
    case = Incline(contact=contact)
    one = critical_angle_by_passage(passage(partial(measured, lammps)), case)
    other = critical_angle_by_steady_motion(lambda c: measured(lammps, c, "steady"), case)
    assert abs(one.value_deg - other.value_deg) <= one.uncertainty_deg + other.uncertainty_deg
    assert one.value_deg == pytest.approx(critical_angle(), abs=5e-3)
    assert len(one.samples) <= 14
    assert len(other.samples) <= 24


def test_clipping_the_tail_of_the_source_contact_raises_the_angle(lammps):
    kept = critical_angle_by_passage(passage(partial(measured, lammps)), Incline())
    clipped = Incline(contact=SOURCE.replace(tail="clipped"))
    raised = critical_angle_by_passage(passage(partial(measured, lammps)), clipped)
    assert kept.value_deg == pytest.approx(10.206, abs=2e-3)
    assert raised.value_deg == pytest.approx(10.218, abs=2e-3)


def test_half_the_effective_mass_is_less_damping(lammps):
    half = SOURCE.replace(effective_mass="half")
    full = SOURCE.replace(restitution=None, damping_ratio=SOURCE.zeta / math.sqrt(2))
    one, other = measured(lammps, [Incline(contact=c) for c in (half, full)], "passage")
    assert one.margin_J == pytest.approx(other.margin_J, rel=1e-9)


@pytest.mark.parametrize(
    "case",
    [scaled(**GLASS), scaled(gravity=1.62), scaled(**GLASS, gravity=1.62)],
    ids=["glass", "moon", "glass on the moon"],
)
def test_margin_does_not_depend_on_units(lammps, case):
    here, there = measured(lammps, [EARTH, case], "passage")
    assert there.case.stiffness != here.case.stiffness
    assert ratio(there) == pytest.approx(ratio(here), abs=1e-9)
    assert there.steps == here.steps


def test_row_length_does_not_matter(lammps):
    one, other = measured(lammps, [EARTH, EARTH.replace(spheres=5)], "steady")
    # positions are wrapped elsewhere: round-off decides in which step a contact breaks
    assert ratio(other) == pytest.approx(ratio(one), abs=5e-6)
    assert other.motion is one.motion


def test_time_limit_leaves_a_run_undecided_not_trapped(lammps):
    (run,) = measured(lammps, [EARTH.replace(time_limit=0.5)], "steady")
    assert run.motion is Motion.UNDECIDED
    assert run.time_s == pytest.approx(0.5 / math.sqrt(9.81), rel=1e-3)


def test_more_steps_than_lammps_runs_at_once(lammps):
    (run,) = measured(lammps, [EARTH.replace(time_limit=1e7)], "passage")
    assert 1e7 / math.sqrt(9.81) / run.case.step > 2**31
    (usual,) = measured(lammps, [EARTH], "passage")
    assert run.margin_J == usual.margin_J


def test_trajectory_stays_on_the_row_and_keeps_its_energy(lammps):
    case = Incline(angle=10.5, contact=PLASTIC, steps_per_contact=100.0, wells=3)
    (run,) = run_inclines(lammps, [case], "steady", every=50)
    path = run.trajectory
    assert (np.diff(path.time_s) > 0).all()
    assert np.diff(path.time_s)[:-1] == pytest.approx(50 * case.step, rel=1e-6)
    assert (path.x_m[0], path.time_s[0]) == (0.5, 0.0)
    assert path.speed_m_per_s[0] == pytest.approx(0.48 * math.sqrt(9.81), rel=1e-9)
    assert path.time_s[-1] == pytest.approx(run.time_s, abs=60 * case.step)
    behind = np.floor(path.x_m)
    nearest = np.minimum(
        np.hypot(path.x_m - behind, path.y_m), np.hypot(path.x_m - behind - 1, path.y_m)
    )
    overlap = 1.0 - nearest
    assert overlap.max() < 0.01
    theta = math.radians(case.angle)
    height = path.y_m * math.cos(theta) - path.x_m * math.sin(theta)
    energy = path.speed_m_per_s**2 / 2 + 9.81 * height
    assert np.diff(energy).max() < 1e-3
    assert energy[-1] < energy[0] - 0.5
    (silent,) = run_inclines(lammps, [case], "steady")
    assert silent.margin_J == run.margin_J
    assert silent.trajectory is None


def test_variables_on_the_command_line_override_the_script(lmp, lammps, tmp_path, inputs):
    import subprocess

    case = Incline(angle=10.4, stiffness=2e6, contact=PLASTIC, steps_per_contact=80.0, spheres=7)
    options = [
        word
        for name, value in values_of(case, "passage").items()
        for word in ("-var", name, Lammps.literal(value))
    ]
    script = inputs / "incline-source.in"
    subprocess.run([lmp, "-in", str(script), "-screen", "none", *options], cwd=tmp_path, check=True)
    log = (tmp_path / "log.lammps").read_text(encoding="utf-8")
    run = read(case, "passage", Output(results_in(log), Provenance("lammps", "1")))
    (expected,) = measured(lammps, [case], "passage")
    assert run.margin_J == expected.margin_J


def test_two_ranks_give_the_same_verdict_and_margin(lmp, mpirun, lammps):
    soft = EARTH.replace(stiffness=1e5)  # fewer steps: ranks that share a core wait for each other
    cases = [soft, soft.replace(angle=10.5)]
    try:
        engine = Lammps(lmp=lmp, launcher=f"{mpirun} -np 2")
    except EngineMissingError as error:
        pytest.skip(f"mpirun does not fit this LAMMPS: {error}")
    with engine:
        two = run_inclines(engine, cases, "passage")
    assert not [run for run in two if isinstance(run, EngineError)]
    for one, other in zip(measured(lammps, cases, "passage"), two, strict=True):
        assert other.motion is one.motion
        assert other.margin_J == pytest.approx(one.margin_J, rel=1e-9)
        assert other.provenance.how == f"{mpirun} -np 2"


@pytest.mark.parametrize(("factor", "settles"), [(0.98, False), (1.05, True)])
def test_lammps_is_unstable_just_below_the_bound_on_the_step(lmp, factor, settles):
    case = Incline(angle=0.0, wells=1, time_limit=20.0)
    steps = factor * case.fewest_steps_per_contact
    script = Lammps.script(TEMPLATE, "source")
    # let it rest in the well: no verdict is to stop it
    text = script.text.replace("(vcm(grain,x)<0)", "0").replace("v_margin<0", "v_margin>1e9")
    with Lammps(lmp=lmp, workers=1, limits=Limits(seconds=30)) as engine:
        engine.identify()
        values = {**engine.task(job_of(case, "steady", 100)).values, "speed": 1e-12}
        task = Task(
            job_of(case, "steady", 100),
            Script("rest.in", text, script.variables),
            {**values, "steps_per_contact": steps},
        )
        (output,) = engine.execute([task])
    if isinstance(output, EngineError):
        assert not settles
        return
    # the clock is that of other steps than the case's: the table is read as it is
    path = output.table(("time_s", "vx_m_per_s", "vy_m_per_s"))
    speed = math.hypot(path["vx_m_per_s"][-1], path["vy_m_per_s"][-1])
    assert bool(speed < 1e-6) is settles
