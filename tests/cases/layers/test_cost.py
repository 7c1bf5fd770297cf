"""What the study of layers costs: the model by hand, the measure from a log."""

from contextlib import nullcontext

import pytest

from harness.cases.layers import extents
from harness.cases.layers.study import LayersStudy
from harness.cases.layers.system import Layers
from harness.cases.study import Arm
from harness.engines.output import Output
from harness.errors import EngineOutputError
from harness.observables.provenance import Provenance

WHO = Provenance("double", "1")
LOG = """Loop time of 0.5 on 2 procs for 500 steps with 1280 atoms
Loop time of 0.9 on 2 procs for 13 steps with 1280 atoms
"""


def test_the_longest_stretch_of_a_log_is_the_measure():
    found = extents.loop_speed(Output((), WHO, log=LOG), 1000)
    assert found == (1000, 2, pytest.approx(1e-6))
    with pytest.raises(EngineOutputError, match="no line 'Loop time of'"):
        extents.loop_speed(Output((), WHO, log="ERROR"), 1000)


@pytest.mark.parametrize(("e", "share"), [(1.0, 0.0), (0.8, 0.25), (0.5, 1.0), (0.3, 1.0)])
def test_the_serial_part_is_that_of_amdahl(e, share):
    assert extents.serial_part(e) == pytest.approx(share)
    half = 0.5 if share < 1.0 else 1.0
    assert extents.wall_seconds([1.0], 2, share, 2) == pytest.approx(share + (1.0 - share) * half)


def test_independent_runs_end_with_the_longest_that_is_left():
    assert extents.wall_seconds([3.0, 3.0, 2.0, 2.0, 2.0], 2, 0.0, 1) == 7.0
    assert extents.wall_seconds([5.0, 1.0], 16, 0.0, 1) == 5.0
    # ranks that share without loss leave no core idle, lossy ones are not worth it
    assert extents.best_ranks([4.0, 4.0], 4, 0.0) == (2, 2.0)
    assert extents.best_ranks([4.0, 4.0], 4, 1.0) == (1, 4.0)


def test_steps_follow_from_times():
    case = Layers(first_angle=12.0, rate=0.1)
    # 20 of preparation, 40 of flow, then by the length: four layers in 16 d
    lowering = extents.LOWERING[4] * 16
    assert extents.steps_of(case) * case.step == pytest.approx(60.0 + lowering)
    assert extents.steps_of(case.replace(rate=0.05)) * case.step == pytest.approx(60 + 2 * lowering)
    assert extents.steps_of(case.replace(rise=0.02)) * case.step == pytest.approx(185 + lowering)
    thin = case.replace(layers=3, length=10)
    between = 0.5 * (extents.LOWERING[2] + extents.LOWERING[4]) * 10
    assert extents.steps_of(thin) * case.step == pytest.approx(60.0 + between)
    assert extents.steps_of(case.replace(length=1000)) * case.step == pytest.approx(60.0 + 5000.0)


class Timed:
    """An engine whose logs tell of 1 us for a grain and step, and of two ranks that lose 20 %."""

    def __init__(self, ranks):
        self.ranks = ranks

    def run(self, jobs):
        (job,) = jobs
        grains = job.values["layers"] * job.values["length"] * job.values["width"]
        time = 1e-6 * 100 * grains / (1.0 if self.ranks == 1 else 1.6)
        log = f"Loop time of {time:.9g} on {self.ranks} procs for 100 steps with {grains} atoms\n"
        return [Output((), WHO, log=log)]


def test_a_level_is_told_for_all_cores():
    found = LayersStudy().cost("full", lambda ranks: nullcontext(Timed(ranks)))
    assert [row["efficiency_of_2_ranks"] for row in found.measured] == pytest.approx([0.8, 0.8])
    one, some, many = found.rows
    assert [row["cores"] for row in found.rows] == [1, 16, 256]
    assert one["efficiency"] == pytest.approx(1.0)
    assert one["wall_time_h"] > some["wall_time_h"] > many["wall_time_h"]
    assert many["core_hours"] >= some["core_hours"] >= one["core_hours"] * (1.0 - 1e-12)
    speeds = [extents.Speed(1024, 1, 1e-6), extents.Speed(4096, 1, 1e-6)]
    alone = extents.durations_of([Arm("a", (Layers(), Layers()))], speeds)
    assert alone == [pytest.approx(extents.steps_of(Layers()) * Layers().grains * 1e-6)]
