"""The cost of a particle and step: starts of programs do not count, a failed run is no number."""

import contextlib

import pytest

from harness.cases.bulk.speed import FEW, MANY, drawn, measure
from harness.errors import EngineCrashError


class Clock:
    """Processor time of runs that take 0.3 s to start and 2 us a particle and step."""

    def __init__(self, grains):
        self.now, self.grains, self.steps = 0.0, grains, []

    def __call__(self):
        return self.now

    @contextlib.contextmanager
    def engine(self):
        yield self

    def run(self, jobs):
        (job,) = jobs
        self.steps.append(job.values["settle_steps"])
        self.now += 0.3 + 2e-6 * self.grains * (self.steps[-1] + job.values["steps"])
        return [None]


@pytest.mark.parametrize("case", ["penetration", "silo", "drum"])
def test_the_start_of_a_program_is_subtracted(case):
    grains = measure(case, Clock(1).engine)[0]
    clock = Clock(grains)
    assert measure(case, clock.engine, clock)[2] == pytest.approx(2.0)
    assert clock.steps == [FEW, MANY]


def test_a_run_that_fails_is_an_error():
    clock = Clock(1)
    clock.run = lambda jobs: [EngineCrashError("died") for _ in jobs]
    with pytest.raises(EngineCrashError):
        measure("drum", clock.engine, clock)


def test_every_code_has_a_bar_in_every_case():
    rows = [(case, code, 1000, 1e-5, 1.0) for case in ("silo", "drum") for code in ("A", "B", "C")]
    assert len(drawn(rows).axes[0].patches) == 6
