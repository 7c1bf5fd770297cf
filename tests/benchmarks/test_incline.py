"""What a critical angle costs, against the naive way in the same run.

Run with ``pytest -m benchmark -s tests/benchmarks``. The naive way is what one
would write first: one ``lmp`` process an angle, each for the source's 45 s of
motion, bisected. CPU time is that of the processes started, all of it.
"""

import resource
import subprocess
import time

import pytest

from harness.cases.incline.angle import critical_angle
from harness.cases.incline.system import TEMPLATE, Incline, job_of
from harness.engines.lammps.engine import Lammps

pytestmark = [pytest.mark.benchmark, pytest.mark.live]

CASE = Incline()
BRACKET = (9.8, 10.8)
SOURCE_SECONDS = 45.0


def _children():
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


def _measure(function):
    cpu, wall = _children(), time.perf_counter()
    value = function()
    return value, _children() - cpu, time.perf_counter() - wall


def _ours(method, tolerance):
    with Lammps() as engine:
        return critical_angle(CASE, method=method, tolerance_deg=tolerance, engine=engine).value_deg


def _naive(lmp, folder, tolerance):
    """Bisect with one process an angle and a fixed number of steps; trapped when back in a well."""
    head, _ = Lammps.script(TEMPLATE, "source").text.split("# ---- well after well")
    steps = round(SOURCE_SECONDS / CASE.step)
    (folder / "naive.in").write_text(
        head + f'run {steps}\nprint "RESULT x = $(v_X)"\nprint "RESULT vx = $(v_VX)"\n'
    )
    low, high = BRACKET
    while (high - low) / 2 > tolerance:
        angle = (low + high) / 2
        values = {**job_of(CASE, "steady").values, "angle": angle}
        variables = {name: Lammps.literal(value) for name, value in values.items()}
        options = [word for name, value in variables.items() for word in ("-var", name, value)]
        command = [lmp, "-in", "naive.in", "-screen", "none", *options]
        subprocess.run(command, cwd=folder, check=True)
        words = (folder / "log.lammps").read_text().splitlines()
        x, vx = (
            float(w.split("=")[1])
            for w in words
            if w.startswith("RESULT x") or w.startswith("RESULT vx")
        )
        in_a_well = abs(vx) < 1e-3 and abs(x % 1.0 - 0.5) < 0.01
        low, high = (angle, high) if in_a_well else (low, angle)
    return (low + high) / 2


@pytest.mark.parametrize(
    ("method", "tolerance", "limit"), [("passage", 1e-3, 1.0), ("steady", 5e-3, 4.0)]
)
def test_cost_of_a_critical_angle(tmp_path, lmp, method, tolerance, limit):
    ours, cpu, wall = _measure(lambda: _ours(method, tolerance))
    naive, naive_cpu, naive_wall = _measure(lambda: _naive(lmp, tmp_path, tolerance))
    print(
        f"\n{method} to {tolerance:g} deg: {ours:.4f} deg, {cpu:.2f} s CPU, {wall:.2f} s wall"
        f"\n  naive bisection:  {naive:.4f} deg, {naive_cpu:.2f} s CPU, {naive_wall:.2f} s wall"
        f"\n  ratio {naive_cpu / cpu:.1f} in CPU; the target is {limit:g} s of CPU"
    )
    assert cpu < naive_cpu
