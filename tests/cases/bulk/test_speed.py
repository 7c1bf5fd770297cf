"""The cost of a particle and step: starts of programs do not count, a failed run is no number."""

import contextlib
from dataclasses import replace

import pytest

from harness.cases.bulk import speed
from harness.cases.bulk.speed import FEW, MORE, Row, drawn, measure, speedups
from harness.engines.output import Output
from harness.errors import EngineCrashError
from harness.observables.provenance import Provenance


class Machine:
    """Runs that take 0.3 s to start and 2 us a particle and step on one core; half the wall on two.

    Other processes take ``others`` cores.
    """

    title = "Code"

    def __init__(self, grains, cores=1, others=0.0):
        self.grains, self.cores, self.others = grains, cores, others
        self.processor = self.wall = self.machine = 0.0
        self.steps = []

    @property
    def clock(self):
        return speed.Clock(lambda: self.processor, lambda: self.wall, lambda: self.machine)

    @contextlib.contextmanager
    def engine(self):
        yield self

    def run(self, jobs):
        (job,) = jobs
        self.steps.append(job.values["settle_steps"])
        spent = 0.3 + 2e-6 * self.grains * (self.steps[-1] + job.values["steps"])
        self.processor += spent
        self.wall += spent / self.cores
        self.machine += spent + self.others * spent / self.cores
        return [Output((("coordination", "4.5"),), Provenance("code", "1"))]


@pytest.mark.parametrize("case", ["penetration", "silo", "drum"])
def test_the_start_of_a_program_is_subtracted(case):
    small = Machine(1)
    grains = measure(case, small.engine, clock=small.clock).grains
    machine = Machine(grains)
    row = measure(case, machine.engine, clock=machine.clock)
    assert row.microseconds_per_particle_step == pytest.approx(2.0)
    assert row.wall_microseconds_per_particle_step == pytest.approx(2.0)
    assert machine.steps == [FEW, FEW + MORE]
    assert (row.coordination, row.others_cores) == (4.5, pytest.approx(0.0, abs=1e-9))


def test_two_cores_are_held_against_one_by_wall_time_of_an_idle_machine():
    one, two = Machine(1000), Machine(1000, cores=2)
    rows = [measure("drum", m.engine, m.cores, m.clock) for m in (one, two)]
    assert [row.ranks for row in rows] == [1, 2]
    assert rows[1].microseconds_per_particle_step == rows[0].microseconds_per_particle_step
    assert speedups(rows) == {("drum", "Code"): pytest.approx(2.0)}
    loaded = Machine(1000, cores=2, others=0.5)
    busy = measure("drum", loaded.engine, 2, loaded.clock)
    assert busy.others_cores == pytest.approx(0.5)
    assert speedups([rows[0], busy]) == {}
    assert speedups(rows[1:]) == {}


def test_a_run_that_fails_is_an_error():
    machine = Machine(1)
    machine.run = lambda jobs: [EngineCrashError("died") for _ in jobs]
    with pytest.raises(EngineCrashError):
        measure("drum", machine.engine, clock=machine.clock)


def test_every_code_has_a_bar_in_every_case():
    row = Row("silo", "A", 1, 1000, 4.5, 1e-5, 1.0, 1.0, 0.0)
    rows = [
        replace(row, case=case, code=code, ranks=ranks)
        for case in ("silo", "drum")
        for code in ("A", "B", "C")
        for ranks in (1, 2)
    ]
    assert [len(axes.patches) for axes in drawn(rows).axes] == [6, 6]
    busy = [replace(row, others_cores=1.0) for row in rows]
    assert [len(axes.patches) for axes in drawn(busy).axes] == [6, 0]


def test_the_processor_time_of_the_machine_rises():
    first = speed.machine_seconds()
    assert speed.machine_seconds() >= first > 0.0


@pytest.mark.parametrize("case", speed.CASES)
def test_the_scripts_of_kratos_leave_the_threads_to_the_environment(case):
    from harness.cases.registry import get_case
    from harness.engines.kratos.engine import Kratos

    before = Kratos.script(get_case(case).template).text.partition("SetNumThreads(1)")[0]
    assert before.splitlines()[-2].strip().startswith('if "OMP_NUM_THREADS" not in os.')
