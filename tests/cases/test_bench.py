"""What a bench says of the input of its jobs."""

from itertools import compress

import pytest

from harness.cases.bench import Bench
from harness.cases.registry import usable_cases
from harness.engines.base import scene_job
from harness.engines.registry import open_engine
from harness.results.compare import differ
from harness.results.rows import KEY
from harness.store.committed import accepted_rows
from tests.cases.test_defects import SLIDING, Code


@pytest.mark.parametrize(("error", "other"), [(1e-15, False), (-1e-11, False), (1e-7, True)])
def test_the_rounding_of_another_cpu_is_the_same_input(error, other):
    """A step follows from an integration, whose last digits depend on the CPU and on scipy."""
    jobs = [scene_job(SLIDING.replace(step=SLIDING.step * (1.0 + e))) for e in (0.0, error)]
    one, two = ([Bench(Code()).inputs_digest([job])] for job in jobs)
    assert list(differ(one, two)) == [other]


@pytest.mark.parametrize("name", ["penetration", "drum"])
def test_published_beds_are_the_same_input_for_each_user(name, tmp_path, monkeypatch):
    """The bed lies in a file in the cache of a user."""
    case, digests = usable_cases()[name], set()
    for home in ("one", "another one"):
        monkeypatch.setenv("DEM_HARNESS_HOME", str(tmp_path / home))
        digests.add(Bench(Code()).inputs_digest([case.job(case.presets["published"])]))
    assert len(digests) == 1


def test_the_accepted_run_had_the_input_of_the_checks_on_any_machine(lammps_here):  # noqa: ARG001
    """Nothing runs: other input is no change of the engine, and fails every verification."""
    with open_engine("lammps") as engine:
        accepted = accepted_rows({engine.name: engine.identify().engine_version})
        expected = dict(zip(accepted[list(KEY)].itertuples(index=False, name=None),
                            accepted["inputs"], strict=True))  # fmt: skip
        bench, pairs = Bench(engine), {}
        for case in usable_cases().values():
            for check in case.checks_up_to(engine, "quick"):
                key = (case.name, check.setup, check.quantity, engine.name, check.check)
                if key in expected:
                    pairs[key] = expected[key], bench.inputs_digest(check.jobs)
    assert [*compress(pairs, differ(*zip(*pairs.values(), strict=True)))] == []
    assert len(pairs) > len([text for text in expected.values() if text]) - len(accepted) / 2
