"""The outcome of a run: by its script, by its path, and outputs that are no result."""

import math
from dataclasses import replace

import numpy as np
import pytest

from harness.cases.base import COLUMNS, path_in
from harness.cases.bench import Bench
from harness.cases.incline.case import CASE
from harness.cases.incline.columns import Columns
from harness.cases.incline.runs import Fate, read
from harness.cases.incline.system import Incline
from harness.engines.output import STAGES
from harness.engines.reference import Reference
from harness.errors import EngineOutputError, RequestError
from harness.workflows import run as run_case
from tests.cases.common import made


def printed(case, **changes):
    """Return the output of a script that passed one crest, with changes to its results."""
    results = {
        "steps": "100", "time_s": repr(100 * case.step), "margin_J": "0.5", "touching": "1",
        "verdict": "moves_on", **changes,
    }  # fmt: skip
    crests = results.pop("crests", [f"1 {results['time_s']} 0.5 1"])
    return made([*(("crest", row) for row in crests), *results.items()])


def test_a_script_that_judges_is_read():
    case = Incline()
    run = read(case, "passage", printed(case))
    assert (run.fate, run.steps, run.touching) == (Fate.MOVES_ON, 100, True)
    assert run.margin == 0.5 / case.weight_energy


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"route": "steady"}, "another route"),
        ({"angle_deg": "10.3"}, "says that it ran with angle_deg = 10.3"),
        ({"verdict": "flew"}, "incomplete result"),
        ({"touching": "yes"}, "incomplete result"),
        ({"crests": ["1 0.001 0.5"]}, "incomplete result"),
        ({"crests": []}, "moves_on after 0 crests of 1"),
        ({"verdict": "trapped"}, "trapped after 1 crests of 1"),
        ({"crests": ["1 1.0 0.5 1", "2 2.0 0.5 1"]}, "moves_on after 2 crests of 1"),
    ],
    ids=str,
)
def test_an_output_of_another_run_or_with_another_end_is_no_result(changes, words):
    case = Incline()
    with pytest.raises(EngineOutputError, match=words):
        read(case, "passage", printed(case, **changes))


def stages(case, rows):
    """Return the output of a scene with stages that ended at states (x, y, vx, vy)."""
    times = 50 * case.step * np.arange(1 + len(rows))
    columns = [times, *np.array([(0.5, 0.9, 1.0, 0.0), *rows]).T]
    return replace(made({}), tables={STAGES: dict(zip(COLUMNS, columns, strict=True))})


OVER, FURTHER = (1.0, 1.0, 1.0, 0.0), (2.0, 1.0, 1.0, 0.0)
BACK, LATER = (0.5, 0.9, -0.1, 0.0), (1.5, 0.9, -0.1, 0.0)
REBOUND = (0.5, 1.2, -0.1, 0.0)  # moves back with a positive margin


@pytest.mark.parametrize(
    ("rows", "fate", "crests"),
    [
        ([OVER, FURTHER], "moves_on", 2),
        ([OVER, LATER], "trapped", 1),
        ([BACK], "trapped", 0),
        ([REBOUND], "undecided", 0),
    ],
)
@pytest.mark.parametrize("kind", [Incline, Columns])
def test_stages_are_judged_at_their_ends(kind, rows, fate, crests):
    case = kind(wells=2)
    case = case.replace(time_limit=50 * len(rows) * case.step / case.unit_of_time)
    run = read(case, "steady", stages(case, rows))
    assert (run.fate, run.steps, len(run.crest_margins)) == (fate, 50 * len(rows), crests)
    assert (run.margin < 0.0) is (run.fate is Fate.TRAPPED)


def test_an_end_that_is_undecided_before_the_time_limit_is_no_result():
    case, early = Incline(wells=2), [(0.5, 0.9, 0.1, 0.0)]
    with pytest.raises(EngineOutputError, match=r"ends at .* undecided, before the time limit"):
        read(case, "steady", stages(case, early))
    short = case.replace(time_limit=50 * case.step / case.unit_of_time)
    assert read(short, "steady", stages(short, early)).fate is Fate.UNDECIDED
    for rows in ([], [OVER] * 3):
        with pytest.raises(EngineOutputError, match=f"left {len(rows)} ends of stages, of 2"):
            read(case, "steady", stages(case, rows))


@pytest.mark.parametrize("preset", CASE.presets)
def test_one_passage_has_the_margin_of_the_closed_form_within_its_bias(preset):
    case = CASE.presets[preset]
    with Reference() as engine:
        found = CASE.measure(case, Bench(engine).output(CASE.job(case)))
    expected = CASE.exact(case)["margin_over_mgd"]
    # the slope is 0.0087 per degree: the bias of the angle is 0.01 deg at most
    assert found["margin_over_mgd"] == pytest.approx(expected, abs=2e-4)
    assert found["moves_on"] == float(found["margin_over_mgd"] >= 0.0)
    assert found["steps"] * case.step == pytest.approx(found["time_s"])
    assert set(found) == {q.name for q in CASE.quantities if not q.varies}


def test_the_closed_form_of_rigid_spheres_is_no_limit_of_small_steps():
    with Reference() as engine:
        (margin,) = run_case(
            "incline", engine=engine, quantities="margin_over_mgd"
        ).quantities.values()
    # of a soft contact with its tail that is -6.1e-4, nine times the closed form
    assert margin.reference_kind == "equal steps"
    assert math.isnan(margin.limit)
    assert math.isnan(margin.step_error)


def test_a_film_shows_the_grain_over_the_row():
    case = CASE.presets["plastic"].replace(angle=10.6, wells=2)
    with Reference() as engine:
        output = Bench(engine).output(CASE.film_job(case, 40))
    discs = CASE.discs(case, output)
    assert discs.x.shape == discs.y.shape == discs.value.shape
    assert 10 < len(discs.time) <= 41
    gaps = np.hypot(discs.x - discs.fixed[:, 0], discs.y - discs.fixed[:, 1]).min(axis=1)
    assert np.abs(gaps - 1.0).max() < 1e-3
    assert set(path_in(output)) == {"step", *COLUMNS}


def test_rigid_spheres_are_a_solver_without_friction():
    case = CASE.presets["plastic"]
    found = CASE.solve(case, "hard-sphere")
    assert found["margin_over_mgd"] == pytest.approx(CASE.exact(case)["margin_over_mgd"], abs=1e-4)
    assert found["critical_angle_deg"] == pytest.approx(10.2078, abs=1e-3)
    with pytest.raises(RequestError, match="hard-sphere"):
        CASE.solve(case.replace(friction=0.1), "hard-sphere")
    with pytest.raises(RequestError):
        CASE.solve(case, "soft-sphere")
