from __future__ import annotations

import math

import pytest

from harness.cases.tower.impulse import impulse_table
from harness.cases.tower.run import covering, tower
from harness.errors import RequestError
from harness.parameters.tower import Tower
from tests.cases.tower.row_engine import RowEngine


@pytest.mark.parametrize(
    ("values", "said"),
    [
        ({"solver": "euler"}, "solver = 'euler': must be one of rk4, exact"),
        ({"duration": 0.0}, "duration = 0.0 t0"),
        ({"duration": math.nan}, "duration = nan t0"),
        ({"samples": 0}, "samples = 0"),
        ({"solver": "exact", "steps_per_contact": 10.0}, "has no step"),
        ({"steps_per_contact": 1.0}, "unstable"),
    ],
)
def test_bad_requests(values, said):
    with pytest.raises(RequestError, match=said):
        tower(Tower(height=3), **values)


@pytest.mark.parametrize("solver", ["rk4", "exact"])
def test_covering_runs_longer_only_where_needed(solver):
    case = Tower(height=2)
    run = tower(case, solver=solver)
    assert covering(run, "turnaround") is run
    short = tower(case, solver=solver, duration=0.5)
    whole = covering(short, "turnaround")
    assert whole.time[-1] == pytest.approx(3 * case.contact_time)
    assert whole.step == (None if short.step is None else pytest.approx(short.step, rel=1e-3))
    sinking = Tower(height=12, speed=0.01, law="overlap")
    whole = covering(tower(sinking, solver=solver, steps_per_contact=None), "turnaround")
    assert whole.time[-1] == pytest.approx(6 * sinking.contact_time, rel=2e-3)


@pytest.mark.parametrize("solver", ["exact", "rk4", "other"])
def test_a_solver_does_not_silently_replace_a_given_engine_nor_the_other_way_round(solver):
    with RowEngine() as engine:
        for run in (tower, lambda _, **given: impulse_table(**given)):
            with pytest.raises(RequestError, match=f"solver = '{solver}': contradicts .* 'row'"):
                run(Tower(height=1, law="overlap"), solver=solver, engine=engine)
        assert not engine.jobs
        case = Tower(height=1, law="overlap")
        for named in (None, "row"):
            assert tower(case, solver=named, engine=engine).solver == "row"


def test_impulse_table_runs_the_heights_of_an_engine_as_one_batch():
    common = {"heights": (1, 2, 9), "stiffnesses": (1e6,), "speeds": (2.0,), "laws": ("overlap",)}
    batches = []

    class Counting(RowEngine):
        def run(self, jobs):
            batches.append(len(jobs))
            return super().run(jobs)

    rows = impulse_table(engine=Counting(), **common)
    assert batches == [3]
    for ours, exact in zip(rows, impulse_table(solver="exact", **common), strict=True):
        assert ours.ratio == pytest.approx(exact.ratio, abs=1e-5)
