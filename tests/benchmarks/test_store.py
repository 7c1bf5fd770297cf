"""What a kept verification costs, with the start of Python in it, as CPU time.

Run with ``pytest -m benchmark -s tests/benchmarks``.
"""

import json
import resource
import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.benchmark

HARNESS = (Path(sys.executable).with_name("dem-harness"),)


def _timed(folder, *arguments):
    """Return what Python prints and the CPU time [s] it takes, given these arguments."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run(
        [sys.executable, *arguments],
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode in (0, 1), done.stderr  # what the verdicts are is no matter of speed
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return done.stdout, after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime


@pytest.mark.live
def test_a_kept_verification_costs_a_tenth_of_a_quick_one_at_most(tmp_path):
    _, first = _timed(tmp_path, *HARNESS, "verify", "--quick", "--output", "first")
    times = []
    for n in range(3):
        out, seconds = _timed(
            tmp_path, *HARNESS, "verify", "--quick", "--json", "--output", f"again-{n}"
        )
        assert json.loads(out)["cached"] is True
        times.append(seconds)
    files = [sorted(p.name for p in (tmp_path / n).rglob("*")) for n in ("first", "again-0")]
    assert files[0] == files[1]
    print(f"\nverify --quick: {first:.1f} s; kept: {', '.join(f'{t:.2f} s' for t in times)}")
    assert min(times) < first / 10.0
