"""The cost of the harness next to the engine: of a sweep, and of a verification that is kept.

Run with ``pytest -m benchmark -s tests/benchmarks``.
"""

import json
import subprocess
import sys
from pathlib import Path

import pytest

from harness.engines.registry import open_engine
from harness.store.cache import CachedEngine, Entries
from harness.workflows import sweep

pytestmark = [pytest.mark.benchmark, pytest.mark.live]

HARNESS = Path(sys.executable).with_name("dem-harness")
LARGEST_SHARE = 0.05  # of the engine's CPU time


@pytest.mark.parametrize(
    ("fixed", "runs", "largest"),
    [
        ({"stiffness": "1e8", "steps_per_contact": "200"}, 50, LARGEST_SHARE),
        ({}, 200, None),  # the cheapest runs: printed
    ],
)
@pytest.mark.usefixtures("lammps_here")
def test_a_sweep_costs_little_next_to_the_engine(tmp_path, cpu, fixed, runs, largest):
    def swept(angles):
        return sweep("incline", {"angle": angles}, fixed=fixed, engines="lammps", open_engine=lambda
                     name: CachedEngine(open_engine(name), Entries(tmp_path)))  # fmt: skip

    swept("9,9.5")  # imports and kernels are no part of the cost of a run
    found, own, engines = cpu(lambda: swept(f"10:11:{runs}"))
    assert found.count("done") == runs
    each = f"{1e3 * own / runs:.1f} ms of {1e3 * engines / runs:.0f} ms a run"
    print(f"\nsweep of {runs} runs: harness {100 * own / engines:.2g} % of the engine ({each})")
    if largest is not None:
        assert own < largest * engines


def test_a_kept_verification_costs_a_tenth_of_a_quick_one_at_most(tmp_path, cpu):
    def verify(output):
        words = [HARNESS, "verify", "--quick", "--json", "--output", output]
        done = subprocess.run(words, cwd=tmp_path, capture_output=True, text=True, check=False)
        assert done.returncode in (0, 1), done.stderr  # what the verdicts are is no matter of speed
        return json.loads(done.stdout)["cached"]

    _, _, first = cpu(lambda: verify("first"))
    kept = [cpu(lambda n=n: verify(f"again-{n}")) for n in range(3)]
    assert all(cached for cached, *_ in kept)
    files = [sorted(p.name for p in (tmp_path / n).rglob("*")) for n in ("first", "again-0")]
    assert files[0] == files[1]
    again = min(seconds for *_, seconds in kept)
    print(f"\nverify --quick: {first:.1f} s; kept: {again:.2f} s")
    assert again < first / 10.0
