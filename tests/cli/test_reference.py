import pytest


def test_the_critical_angle_by_the_reference_dem(answer):
    record = answer("critical-angle", "--engine", "reference", "--integrator", "mfix-euler")
    assert record["engine"] == "reference"
    assert record["integrator"] == "mfix-euler"
    assert abs(record["critical_angle_deg"] - 10.2078) < 0.01


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--engine", "reference", "--integrator", "euler"], ["integrator", "'euler'", "adaptive"]),
        (["--engine", "reference", "--lmp", "lmp"], ["--lmp 'lmp'", "'reference'", "integrator"]),
        (["--integrator", "rk4"], ["--integrator 'rk4'", "'lammps'", "lmp"]),
    ],
)
def test_bad_requests_name_the_option(harness, options, words):
    done = harness("critical-angle", *options, status=2)
    for word in words:
        assert word in done.stderr


def test_it_is_among_the_engines(answer):
    (row,) = [r for r in answer("engines")["engines"] if r["engine"] == "reference"]
    assert row["available"]
    assert row["how"] == "compiled"
