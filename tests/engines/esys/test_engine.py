"""What goes wrong in a run costs only that run, and is named; played by a fake program."""

import time

import pytest

from harness.cases.drop.case import Drop, run_drops
from harness.cases.drop.case import job_of as drop_job
from harness.cases.incline.runs import run_inclines
from harness.cases.incline.system import Incline
from harness.cases.incline.system import job_of as incline_job
from harness.cases.tower.run import run_towers
from harness.engines.esys.engine import Esys
from harness.engines.registry import open_engine
from harness.errors import (
    EngineCrashError,
    EngineError,
    EngineInputError,
    EngineMissingError,
    EngineNaNError,
    EngineOutputError,
    EngineTimeoutError,
    RequestError,
)
from harness.parameters.law import PLASTIC, SOURCE, Contact
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


@pytest.mark.parametrize(
    ("body", "error", "words"),
    [
        ("os.kill(os.getpid(), signal.SIGSEGV)", EngineCrashError, "SIGSEGV"),
        ("print('no'); sys.exit(3)", EngineCrashError, "exit status 3 .*no"),
        ("raise ValueError('what is this')", EngineInputError, "what is this"),
        ("print('bye')", EngineOutputError, "without a result .*bye"),
        (WRITES + 'runs[0]["series"] = ""\nwrite(runs[0], "")', EngineOutputError, "left no table"),
        (GOOD_DROP.replace("2,0,1,0,-1", "2,0,1"), EngineOutputError, "incomplete series"),
        (GOOD_DROP.replace("1,0,-1\\n2", "nan,0,-1\\n2"), EngineNaNError, "not numbers"),
    ],
    ids=["signal", "status", "exception", "no result", "no file", "half a file", "NaN"],
)
def test_a_drop_that_goes_wrong_is_named_with_what_it_left(fake, body, error, words):
    (found,) = run_drops(fake(body), [DROP])
    assert type(found) is error
    assert found.args[0]
    with pytest.raises(error, match=words):
        raise found
    assert "esysparticle drop.py x=[0.0,0.0] " in found.log


def test_one_that_hangs_is_ended(fake):
    started = time.monotonic()
    (found,) = run_drops(fake("time.sleep(1000)", seconds=0.5), [DROP])
    assert isinstance(found, EngineTimeoutError)
    assert time.monotonic() - started < 30.0


def test_the_others_of_a_batch_go_on(fake):
    body = 'if runs[0]["gravity_y"] < 0.0: sys.exit("bad")\n' + GOOD_DROP
    engine = fake(body)
    good, bad, last = run_drops(engine, [DROP, DROP.replace(gravity=1.0), DROP])
    assert isinstance(bad, EngineError)
    assert good.path.y_m.tolist() == last.path.y_m.tolist() == [1.0, 1.0, 1.0]
    assert (good.provenance.engine_version, good.provenance.script) == ("9.9", "drop.py")
    assert "RESULT verdict" in engine.logs()["drop.py"]


def test_rows_that_die_together_run_alone(fake):
    """A grain that is lost takes the rows of its model with it: each gets a model of its own."""
    cases = [INCLINE.replace(phase=phase) for phase in (0.5, 0.0)]
    x = fake("").task(incline_job(cases[0], "passage")).values["x"][0]
    loses = f'if any(run["x"][0] == {x!r} for run in runs):\n    sys.exit("lost")\n'
    lost, found = run_inclines(fake(WRITES + loses + PASSED), cases, "passage")
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


@pytest.mark.parametrize(
    ("cases", "words"),
    [
        ([DROP.replace(contact=SOURCE)], "cannot run 'drop': its contacts always have the clipped"),
        ([INCLINE.replace(contact=SOURCE)], "cannot run 'incline': its contacts always"),
        (
            [INCLINE.replace(steps_per_contact=23.8)],
            r"steps_per_contact = 23\.8 is unstable .* greater than 23\.853",
        ),
    ],
)
def test_what_it_cannot_state_is_refused_before_anything_runs(fake, cases, words):
    engine = fake("sys.exit(1)")
    jobs = [drop_job(c) if isinstance(c, Drop) else incline_job(c, "passage") for c in cases]
    with pytest.raises(RequestError, match=words):
        engine.run(jobs)


def test_a_rebounding_contact_asks_for_fewer_steps(fake):
    soft = Contact(restitution=1.0, damping_ratio=None, tail="clipped")
    case = Incline(contact=soft, steps_per_contact=4.0, stiffness=1e5)
    (found,) = run_inclines(fake("sys.exit(1)"), [case], "passage")
    assert isinstance(found, EngineCrashError)


def test_a_program_or_launcher_that_is_not_there_is_named(monkeypatch, script_file):
    with pytest.raises(RequestError, match=r"^--program esys='/no/such': no such executable"):
        open_engine("esys", programs={"esys": "/no/such"})
    here = script_file("exit 0", "esysparticle")
    with pytest.raises(RequestError, match=r"--mpirun 'no-such-mpirun': no such executable"):
        Esys(here, "no-such-mpirun --oversubscribe")
    monkeypatch.setenv("PATH", "/nowhere")
    monkeypatch.setattr("sys.executable", "/nowhere/python")
    with pytest.raises(EngineMissingError, match="apt install esys-particle"):
        Esys()
    with pytest.raises(EngineMissingError, match=r"mpirun\.openmpi: apt install openmpi-bin"):
        Esys(here)


def test_a_program_that_names_no_version_is_not_it(script_file):
    program = script_file('echo "wrong number of processes !! aborting"; exit 1', "esysparticle")
    engine = Esys(program, script_file('shift 2\nexec "$@"\n', "mpirun-fake"))
    with engine, pytest.raises(EngineMissingError, match=r"exit status 1 .*wrong number of proc"):
        engine.identify()


def test_nothing_runs_after_close(fake):
    engine = fake(GOOD_DROP)
    engine.identify()
    engine.close()
    (found,) = run_drops(engine, [DROP])
    assert isinstance(found, EngineCrashError)
