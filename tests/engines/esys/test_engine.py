"""What goes wrong in a run costs only that run, and is named; played by a fake program."""

import pytest

from harness.cases.drop.case import Drop
from harness.cases.incline.runs import run_inclines
from harness.cases.incline.system import Incline
from harness.cases.incline.system import job_of as incline_job
from harness.cases.tower.run import run_towers
from harness.engines.esys.engine import Esys
from harness.errors import (
    EngineCrashError,
    EngineMissingError,
    EngineOutputError,
    RequestError,
)
from harness.parameters.law import PLASTIC, Contact
from harness.parameters.tower import Tower

DROP = Drop(contact=PLASTIC, speed=1.0, steps_per_contact=30.0, duration=1.0, every=15)
INCLINE = Incline(contact=PLASTIC, stiffness=1e5, steps_per_contact=50.0)
TOWER = Tower(height=1, law="overlap", stiffness=1e5)

WRITES = """
def write(run, text, *results):
    if run["series"]:
        with open(run["series"], "w") as series:
            series.write(text)
    with open(run["results"], "w") as file:
        for line in (*results, "verdict = finished"):
            print("RESULT", line)
            print("RESULT", line, file=file)
HEAD = "time_s,x_m,y_m,vx_m_per_s,vy_m_per_s\\n"
"""
GOOD_DROP = WRITES + 'write(runs[0], HEAD + "0,0,1,0,-1\\n1,0,1,0,-1\\n2,0,1,0,-1\\n")\n'
# a grain that has just passed the place where the contact has settled, with energy left
PASSED = """
for run in runs:
    x, y, vx, vy = run["x"][0], run["y"][0], run["vx"][0], run["vy"][0]
    ends = f"stage = 50 {50 * run['step']} {run['places'][0] + 1e-3} {y + 1} {vx} {vy}"
    write(run, HEAD + f"0,{x},1,1,0\\n{50 * run['step']},0.9,1,1,0\\n",
          f"stage = 0 0 {x} {y} {vx} {vy}", ends)
"""


def test_rows_that_die_together_run_alone(fake):
    """A grain that is lost takes the rows of its model with it: each gets a model of its own."""
    cases = [INCLINE.replace(phase=phase) for phase in (0.0, 0.5)]
    x = fake("").task(incline_job(cases[1], "passage")).values["x"][0]
    loses = f'if any(run["x"][0] == {x!r} for run in runs):\n    sys.exit("lost")\n'
    found, lost = run_inclines(fake(WRITES + loses + PASSED), cases, "passage")
    assert isinstance(lost, EngineCrashError)
    assert f" x=[{x!r}," in lost.log
    assert found.margin_J > 0.0


def test_runs_that_differ_by_their_start_share_a_model(fake):
    shared = 'if len(runs) != 2:\n    sys.exit("alone")\n'
    changes = ({}, {"phase": 0.5}, {"angle": 9.0})
    jobs = [incline_job(INCLINE.replace(**change), "passage", 50) for change in changes]
    first, second, other = fake(WRITES + shared + PASSED).run(jobs)
    assert isinstance(other, EngineCrashError)
    assert " gravity_x=1.5346" in other.log
    starts = [one.table(("time_s", "x_m"))["x_m"][0] for one in (first, second)]
    tasks = [fake("").task(job) for job in jobs[:2]]
    assert starts == [task.values["x"][0] for task in tasks]
    assert starts[0] != starts[1]
    for output, task in zip((first, second), tasks, strict=True):
        assert output.tables["stages"]["x_m"][0] == task.values["x"][0]
        assert f" x=[{task.values['x'][0]}," in output.log


def test_a_tower_that_is_cut_short_is_named(fake):
    head = ",".join(["step", *(f"{name}[{i}]" for name in ("x_m", "vx_m_per_s") for i in (1, 2))])
    body = WRITES + f'write(runs[0], "{head}\\n0,0,1,2,0\\n")'
    (found,) = run_towers(fake(body), [TOWER], 1.0, steps_per_contact=100.0)
    assert isinstance(found, EngineOutputError)


def test_an_unstable_step_is_refused_before_anything_runs(fake):
    job = incline_job(INCLINE.replace(steps_per_contact=23.8), "passage")
    with pytest.raises(
        RequestError, match=r"steps_per_contact = 23\.8 is unstable .* greater than 23\.853"
    ):
        fake("sys.exit(1)").run([job])


def test_a_rebounding_contact_asks_for_fewer_steps(fake):
    soft = Contact(restitution=1.0, damping_ratio=None, tail="clipped")
    case = Incline(contact=soft, steps_per_contact=4.0, stiffness=1e5)
    (found,) = run_inclines(fake("sys.exit(1)"), [case], "passage")
    assert isinstance(found, EngineCrashError)


def test_a_launcher_that_is_not_there_is_named(monkeypatch, script_file):
    here = script_file("exit 0", "esysparticle")
    with pytest.raises(RequestError, match=r"--mpirun 'no-such-mpirun': no such executable"):
        Esys(here, "no-such-mpirun --oversubscribe")
    monkeypatch.setenv("PATH", "/nowhere")
    with pytest.raises(EngineMissingError, match=r"mpirun\.openmpi: apt install openmpi-bin"):
        Esys(here)
