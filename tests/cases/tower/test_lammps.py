"""The tower in LAMMPS: all checks of the shortest level, and faults that they see there too."""

import pytest

from harness.cases.bench import Bench
from harness.cases.checks import run_checks, selected
from harness.cases.tower.case import CASE
from harness.cases.tower.parameters import TowerParameters
from harness.cases.tower.runs import make_setup
from harness.engines.lammps.engine import Lammps
from harness.results.rows import Verdict

# of `run tower --engine lammps` in version 1, by law
VERSION_1 = {
    "overlap": {
        "peak_force_N": 1441.2523106108347, "impulse_Ns": 2.524557595481276,
        "turnaround_s": 0.0019284148532298516, "energy_drift": 2.413923522508694e-06,
        "final_velocity_m_per_s": -1.916371905683487,
    },
    "deformable": {
        "peak_force_N": 1814.3387388649762, "impulse_Ns": 3.8186737270816655,
        "turnaround_s": 0.0036149475445609617, "energy_drift": 4.1795442387794695e-06,
        "final_velocity_m_per_s": -1.725927949301745,
    },
}  # fmt: skip

pytestmark = pytest.mark.live


@pytest.fixture(scope="module")
def engine():
    with Lammps(workers=1) as running:
        yield running


def rows_of(engine, only):
    checks = selected("tower", CASE.checks(engine), "quick", only)
    return {
        (row.setup, row.quantity, row.check): row
        for row in run_checks("tower", checks, Bench(engine))
    }


def test_both_laws_pass_with_the_numbers_of_the_readme(engine):
    rows = rows_of(engine, "*")
    assert {row.verdict for row in rows.values()} == {Verdict.PASS}, rows
    overlap, deformable = (
        rows[f"{law} law, n = 2", "force_difference", ""].value for law in ("overlap", "deformable")
    )
    assert (overlap, deformable) == pytest.approx((5.2e-6, 4.8e-6), rel=0.01)
    ratio = rows["overlap law, n = 2", "impulse_ratio", "turnaround"].value
    assert ratio == pytest.approx(0.626299, abs=5e-7)


@pytest.mark.parametrize("law", VERSION_1)
def test_a_run_has_the_values_of_version_1(engine, law):
    parameters = TowerParameters(law=law)
    measured = CASE.measure(parameters, Bench(engine).output(CASE.job(parameters)))
    assert make_setup(parameters).steps == 3010
    for name, value in VERSION_1[law].items():
        scale = CASE.quantity(name).size(parameters)
        assert measured[name] == pytest.approx(value, abs=1e-9 * scale)
