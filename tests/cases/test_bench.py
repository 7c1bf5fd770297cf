"""What a bench says of the input of its jobs."""

import pytest

from harness.cases.bench import Bench
from harness.cases.registry import usable_cases
from harness.engines.base import scene_job
from harness.engines.registry import open_engine
from harness.results.rows import KEY
from harness.store.committed import accepted_rows
from tests.cases.test_defects import SLIDING, Code


def digest(factor):
    """Return the digest of an impact whose step [s] is larger by a factor."""
    return Bench(Code()).inputs_digest([scene_job(SLIDING.replace(step=SLIDING.step * factor))])


@pytest.mark.parametrize("factor", [1.0 + 1e-15, 1.0 - 1e-13])
def test_the_rounding_of_another_cpu_is_the_same_input(factor):
    """A step follows from an integration, whose last digits depend on the vector units of a CPU."""
    assert digest(factor) == digest(1.0)


def test_an_input_that_is_off_by_1e_7_is_another_one():
    assert digest(1.0 + 1e-7) != digest(1.0)


def test_the_accepted_run_had_the_input_of_the_checks_on_any_machine(lammps_here):  # noqa: ARG001
    """Nothing runs: other input is no change of the engine, and fails every verification."""
    with open_engine("lammps") as engine:
        accepted = accepted_rows({engine.name: engine.identify().engine_version})
        expected = dict(zip(accepted[list(KEY)].itertuples(index=False, name=None),
                            accepted["inputs"], strict=True))  # fmt: skip
        bench = Bench(engine)
        for case in usable_cases().values():
            for check in case.checks_up_to(engine, "quick"):
                key = (case.name, check.setup, check.quantity, engine.name, check.check)
                if key in expected:
                    assert bench.inputs_digest(check.jobs) == expected.pop(key), key
    quick = [key for key, digest in expected.items() if digest]
    assert len(quick) < len(accepted) / 2
