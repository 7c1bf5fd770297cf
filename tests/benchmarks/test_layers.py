"""What a grain and step of flowing layers costs, and how two ranks share it, at three sizes.

Run with ``pytest -m benchmark -s tests/benchmarks/test_layers.py``. The case's own script, cut
after the first grains have come down: a stretch to settle, then one that is timed by LAMMPS.
"""

import subprocess

import pytest

from harness.cases.layers.extents import LOOP, Speed, efficiency, probe
from harness.cases.layers.system import TEMPLATE, job_of
from harness.engines.lammps.engine import Lammps
from harness.engines.process import cores

pytestmark = [pytest.mark.benchmark, pytest.mark.live]

SIDES = (16, 50, 158)
"""[d] of four layers: 1e3, 1e4 and 1e5 grains."""

SETTLING, TIMED = 100, 50
FALL = "run $(ceil(20/v_step_size)) post no\n"


def _speed(folder, side, launcher):
    """Return the cost of a grain and step [s] of what ``launcher``, a list of words, starts."""
    case = probe(side)
    head, _ = Lammps.script(TEMPLATE, "").text.split("# ---- flow ---")
    assert head.count(FALL) == 1
    stretches = f"run {SETTLING} post no\nrun {TIMED} post no\n"
    (folder / "layers.in").write_text(head.replace(FALL, stretches), encoding="utf-8")
    options = [
        word
        for name, value in job_of(case).values.items()
        for word in ("-var", name, Lammps.literal(value))
    ]
    command = [*launcher, "-in", "layers.in", "-screen", "none", *options]
    subprocess.run(command, cwd=folder, check=True, timeout=100)
    log = (folder / "log.lammps").read_text(encoding="utf-8")
    ((time, on, steps),) = [loop for loop in LOOP.findall(log) if int(loop[2]) == TIMED]
    return Speed(case.grains, int(on), float(time) / int(steps) / case.grains)


def test_cost_of_a_grain_and_step(tmp_path, lmp, mpirun):
    print("\ngrains  us/grain/step  on 2 ranks  efficiency")
    found = []
    for side in SIDES:
        one = _speed(tmp_path, side, [lmp])
        two = _speed(tmp_path, side, [mpirun, "-np", "2", lmp])
        assert (one.ranks, two.ranks) == (1, 2)
        found.append((one, two))
        costs = f"{1e6 * one.seconds:13.3f} {1e6 * two.seconds:11.3f}"
        print(f"{one.grains:6d} {costs} {efficiency(one, two):11.2f}", flush=True)
    ones = [one.seconds for one, _ in found]
    assert max(ones) < 20e-6
    assert max(ones) < 10.0 * min(ones)  # linear in the grains
    if cores() > 1:
        assert all(two.seconds < 3.0 * one.seconds for one, two in found)
