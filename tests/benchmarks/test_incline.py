"""The cost of a critical angle against a naive bisection in the same run, as CPU time.

Run with ``pytest -m benchmark -s tests/benchmarks``. The naive way takes one ``lmp`` process for
each angle, and the source's 45 s of motion in each, without what makes a step of the harness's own
script cheap. CPU time is that of all processes started.
"""

import subprocess
import sys
import time
from pathlib import Path

import pytest

from harness.cases.incline.runs import TEMPLATE, job_of
from harness.cases.incline.search import critical_angle
from harness.cases.incline.system import Incline
from harness.engines.registry import engine_class, open_engine

pytestmark = [pytest.mark.benchmark, pytest.mark.live]

CASE = Incline()
BRACKET = (9.8, 10.8)
SOURCE_SECONDS = 45.0
TUNED = ("timer off", "neigh_modify exclude", "neigh_modify delay 0")  # commands of the script


def _searched(method, tolerance):
    with open_engine("lammps") as engine:
        return critical_angle(CASE, method=method, tolerance_deg=tolerance, engine=engine).value


def _bisected(lmp, folder, tolerance):
    """Bisect with a fixed number of steps for each angle; trapped is at rest in a well."""
    lammps, steps = engine_class("lammps"), round(SOURCE_SECONDS / CASE.step)
    head, _ = lammps.script(TEMPLATE, "source").text.split("# ---- well after well")
    tail = f'run {steps}\nprint "RESULT x = $(v_X)"\nprint "RESULT vx = $(v_VX)"\n'
    lines = [line for line in head.splitlines(keepends=True) if not line.startswith(TUNED)]
    plain = "neigh_modify delay 0 every 1 check yes\nfix plane all enforce2d\n"
    (folder / "naive.in").write_text("".join([*lines, plain, tail]))
    low, high = BRACKET
    while (high - low) / 2 > tolerance:
        angle = (low + high) / 2
        values = {**job_of(CASE, "steady").values, "angle": angle, "thermo": 1000}
        words = [w for n, v in values.items() for w in ("-var", n, lammps.literal(v))]
        subprocess.run([lmp, "-in", "naive.in", "-screen", "none", *words], cwd=folder, check=True)
        lines = (folder / "log.lammps").read_text().splitlines()
        x, vx = (float(line.split("=")[1]) for line in lines if line.startswith("RESULT x")
                 or line.startswith("RESULT vx"))  # fmt: skip
        in_a_well = abs(vx) < 1e-3 and abs(x % 1.0 - 0.5) < 0.01
        low, high = (angle, high) if in_a_well else (low, angle)
    return (low + high) / 2


@pytest.mark.parametrize(
    ("method", "tolerance", "most"), [("passage", 1e-3, 0.1), ("steady", 5e-3, 0.5)]
)
def test_a_critical_angle_costs_a_part_of_a_naive_bisection(
    tmp_path, lmp, cpu, method, tolerance, most
):
    angle, _, cost = cpu(lambda: _searched(method, tolerance))
    naive, _, naive_cost = cpu(lambda: _bisected(lmp, tmp_path, tolerance))
    print(f"\n{method} to {tolerance:g} deg: {angle:.4f} deg in {cost:.2f} s of CPU")
    print(f"naive bisection: {naive:.4f} deg in {naive_cost:.2f} s, {cost / naive_cost:.2f}")
    assert cost < most * naive_cost


def _seconds(function):
    begin = time.monotonic()
    function()
    return time.monotonic() - begin


def test_a_verification_takes_a_few_naive_bisections(tmp_path, lmp):
    """In wall time, with kernels that are compiled: a bisection has one core, ``verify`` all.

    Some 1.9 on two idle cores; twice a bisection is the goal.
    """

    def verify(*words):
        words = [Path(sys.executable).with_name("dem-harness"), "verify", "--fresh", *words]
        done = subprocess.run(words, cwd=tmp_path, check=False, stdout=subprocess.DEVNULL)
        assert done.returncode in (0, 1)  # what the verdicts are is no matter of speed

    verify("--quick", "--output", "first")
    verified = _seconds(lambda: verify("--output", "second"))
    naive = _seconds(lambda: _bisected(lmp, tmp_path, 1e-3))
    print(f"\nverify: {verified:.1f} s, bisection: {naive:.1f} s, ratio {verified / naive:.2f}")
    assert verified < 5.0 * naive
