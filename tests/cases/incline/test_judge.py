"""A path that an engine wrote is judged as the engine that looks at every step judges."""

import math

import numpy as np
import pytest

from harness.cases.incline.runs import follow, measured, read
from harness.cases.incline.system import Incline, Motion, start_of
from harness.engines.output import Output
from harness.engines.reference import Reference
from harness.errors import EngineNaNError, EngineOutputError
from harness.observables.provenance import Provenance
from harness.observables.reference import Trajectory
from harness.parameters.law import CLIPPED, PLASTIC, SOURCE

WHO = Provenance("some engine", "1")


def followed(case, route, seconds, every=1):
    return follow(Reference(), case, start_of(case, route), seconds, every=every)


def run_of_path(case, route, path, every=None):
    return read(case, route, Output((), WHO, {"series": vars(path)}, seconds=1.0), every)


@pytest.mark.parametrize("contact", [SOURCE, CLIPPED, PLASTIC], ids=lambda c: c.name)
@pytest.mark.parametrize(
    ("route", "angle", "motion"),
    [
        ("passage", 9.5, Motion.TRAPPED),
        ("passage", 11.0, Motion.MOVES_ON),
        ("steady", 9.5, Motion.TRAPPED),
        ("steady", 11.0, Motion.MOVES_ON),
    ],
)
def test_the_verdict_and_the_margin_are_those_of_the_reference(contact, route, angle, motion):
    case = Incline(contact=contact, angle=angle, steps_per_contact=50.0, stiffness=1e5, wells=3)
    (expected,) = measured(Reference(), [case], route)
    path = followed(case, route, expected.time_s + 50 * case.step)
    found = run_of_path(case, route, path)
    assert found.motion is expected.motion is motion
    # the reference looks every 50 steps: what is dissipated within them is between the two
    assert found.margin_J == pytest.approx(expected.margin_J, abs=2e-3 * case.weight_energy)
    assert abs(found.steps - expected.steps) <= 50
    assert len(found.crests.time_s) == len(expected.crests.time_s)
    assert found.trajectory is None


def test_the_path_is_kept_up_to_where_it_is_decided():
    case = Incline(contact=PLASTIC, angle=11.0, steps_per_contact=50.0, stiffness=1e5)
    path = followed(case, "passage", 3.0)
    run = run_of_path(case, "passage", path, every=1)
    assert run.trajectory.time_s[-1] == run.time_s < path.time_s[-1]
    assert run.time_s == run.crests.time_s[0]


@pytest.fixture
def resting():
    """Return a grain at rest in a well, up to the time limit."""
    case = Incline(contact=PLASTIC, time_limit=2.0)
    times = np.linspace(0.0, 2.0 / math.sqrt(case.gravity), 50)
    still = np.full(50, 1.0)
    return case, Trajectory(times, 0.5 * still, math.sqrt(0.75) * still, 0 * still, 0 * still)


def test_a_grain_at_rest_is_undecided_not_trapped(resting):
    case, path = resting
    assert run_of_path(case, "steady", path).motion is Motion.UNDECIDED


def test_a_path_that_ends_too_early_is_no_result(resting):
    case, path = resting
    half = Trajectory(*(column[:25] for column in vars(path).values()))
    with pytest.raises(EngineOutputError, match=r"ends at 0.31.* s, undecided, before the time"):
        run_of_path(case, "steady", half)


@pytest.mark.parametrize(
    ("change", "error", "words"),
    [
        (
            lambda p: p.x_m.__setitem__(3, np.nan),
            EngineNaNError,
            "series with values that are not numbers",
        ),
        (lambda p: p.time_s.__setitem__(3, 0.0), EngineOutputError, "series that is out of order"),
    ],
)
def test_a_damaged_path_is_named(resting, change, error, words):
    case, path = resting
    change(path)
    with pytest.raises(error, match=f"some engine wrote a {words}"):
        run_of_path(case, "steady", path)


def test_no_path_at_all():
    nothing = Trajectory(*(np.empty(0) for _ in range(5)))
    with pytest.raises(EngineOutputError, match="some engine left an incomplete series"):
        run_of_path(Incline(), "steady", nothing)


def told(case, **changes):
    """Return the output of a script that judged the grain itself, with changes to its results."""
    results = {
        "steps": "100", "time_s": repr(100 * case.step), "margin_J": "0.5", "touching": "1",
        "verdict": "moves_on", **changes,
    }  # fmt: skip
    crests = results.pop("crests", [f"1 {results['time_s']} 0.5 1"])
    pairs = [*(("crest", row) for row in crests), *results.items()]
    return Output(tuple(pairs), WHO)


def test_a_script_that_judges_is_taken_at_its_word():
    case = Incline()
    run = read(case, "passage", told(case))
    assert (run.motion, run.steps, run.margin_J) == (Motion.MOVES_ON, 100, 0.5)
    assert run.touching


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"verdict": "flew"}, "incomplete result"),
        ({"touching": "yes"}, "incomplete result"),
        ({"steps": "200"}, "took 200 steps .* and tells of"),
        ({"crests": []}, "moves_on after 0 crests of 1"),
        ({"verdict": "trapped"}, "trapped after 1 crests of 1"),
        ({"crests": ["2 0.001 0.5 1"]}, "after 1 crests"),
        ({"crests": ["1 9.0 0.5 1"]}, "passed a crest after the end"),
        ({"crests": ["1 0.001 0.5"]}, "incomplete result"),
        ({"crests": ["1 0.001 0.5 1"]}, "another time or energy than at its last crest"),
        ({"margin_J": "1.0"}, "another time or energy than at its last crest"),
    ],
)
def test_a_result_that_contradicts_itself_is_no_result(changes, words):
    case = Incline()
    with pytest.raises(EngineOutputError, match=words):
        read(case, "passage", told(case, **changes))


def test_every_well_must_have_its_crest():
    case = Incline(wells=3)
    rows = [f"{n} {25 * (n + 1) * case.step!r} 0.5 1" for n in (1, 2, 3)]
    assert len(read(case, "steady", told(case, crests=rows)).crests.time_s) == 3
    for broken in (rows[:2], [rows[0], rows[2]], [rows[1], rows[0], rows[2]]):
        with pytest.raises(EngineOutputError, match="crests of 3"):
            read(case, "steady", told(case, crests=broken))
