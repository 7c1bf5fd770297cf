import pytest

pytestmark = pytest.mark.live

KEYS = {
    "critical_angle_deg",
    "uncertainty_deg",
    "engine",
    "engine_version",
    "stiffness_N_per_m",
    "steps_per_contact",
    "method",
}


def test_without_options_the_source_s_contact_and_clipping_moves_its_angle(answer):
    record = answer("critical-angle")
    assert record.keys() >= KEYS
    assert record["stiffness_N_per_m"] == 1e6
    assert record["steps_per_contact"] == 50
    assert record["method"] == "passage"
    assert record["contact"] == "source"
    assert record["restitution"] == 1e-20
    assert record["tail"] == "attractive"
    # notes of earlier measurements: 10.206 by bisection to 0.0005 deg
    assert abs(record["critical_angle_deg"] - 10.206) <= record["uncertainty_deg"] + 5e-4
    clipped = answer("critical-angle", "--clip")
    assert clipped["tail"] == "clipped"
    shift = clipped["critical_angle_deg"] - record["critical_angle_deg"]
    assert shift == pytest.approx(0.012, abs=0.003)


@pytest.mark.parametrize(
    ("options", "name"),
    [
        (["--damping-ratio", "5", "--clip"], "plastic"),
        (["--contact", "plastic"], "plastic"),
        (["--restitution", "0", "--clip"], "clipped"),
        (["--restitution", "0.01"], "custom"),
        (["--damping-ratio", "5", "--restitution", "0.5", "--clip"], "custom"),
    ],
)
def test_the_contact_that_options_make(answer, options, name):
    record = answer("critical-angle", "--engine", "reference", "--stiffness", "1e5", *options)
    assert record["contact"] == name
    if "--damping-ratio" in options:
        assert record["damping_ratio"] == 5.0


def test_the_steady_route(answer):
    record = answer(
        "critical-angle", "--method", "steady", "--stiffness", "1e5", "--contact", "plastic"
    )
    assert record["method"] == "steady"
    assert record["uncertainty_deg"] <= 0.005
    assert record["critical_angle_deg"] == pytest.approx(10.2, abs=0.01)


def test_a_rebounding_contact_stands_beside_both_readings_not_beside_e_0(answer):
    words = ("--method", "steady", "--engine", "reference", "--stiffness", "1e5")
    record = answer("critical-angle", *words, "--restitution", "0.5")
    assert "closed_form_deg" not in record
    assert record["closed_form_kept_deg"] == pytest.approx(6.251, abs=1e-3)
    assert record["closed_form_lost_deg"] == pytest.approx(15.08, abs=1e-2)
    assert "neither describes" in record["theory"]
    assert "report's section on the contacts" in record["theory"]


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--stiffness", "0"], ["--stiffness 0", "greater than 0"]),
        (["--stiffness", "-1e6"], ["--stiffness -1000000", "greater than 0"]),
        (["--stiffness", "10"], ["--stiffness 10", "at least"]),
        (["--stiffness", "nan"], ["--stiffness nan", "greater than 0"]),
        (["--diameter", "-1"], ["--diameter -1", "greater than 0"]),
        (["--density", "0"], ["--density 0", "greater than 0"]),
        (["--gravity", "0"], ["--gravity 0", "greater than 0"]),
        (["--restitution", "1.5"], ["--restitution 1.5", "less than or equal to 1"]),
        (["--restitution", "-0.5"], ["--restitution -0.5", "greater than or equal to 0"]),
        (["--damping-ratio", "-1"], ["--damping-ratio -1"]),
        (["--steps-per-contact", "2"], ["--steps-per-contact 2", "unstable", "greater than"]),
        (["--steps-per-contact", "0"], ["--steps-per-contact 0"]),
        (["--tolerance", "0"], ["--tolerance 0.0", "1e-9"]),
        (["--engine", "yad"], ["--engine 'yad'", "lammps"]),
        (["--lmp", "/nowhere/lmp"], ["--lmp '/nowhere/lmp'", "no such executable"]),
        (["--mpirun", "no-such-launcher -np 2"], ["--mpirun 'no-such-launcher'"]),
        (["--extrapolate", "--steps-per-contact", "50"], ["--steps-per-contact"]),
        (["--extrapolate", "--method", "steady"], ["--method steady"]),
        (["--wells", "20"], ["--wells 20", "--method steady only"]),
        (["--method", "steady", "--wells", "0"], ["--wells 0", "greater than or equal to 1"]),
        (["--method", "other"], ["passage", "steady"]),
    ],
)
def test_bad_requests_name_the_option_the_value_and_the_range(command, options, words):
    done = command("critical-angle", *options, status=2)
    assert done.out == ""
    for word in words:
        assert word in done.err


def test_an_executable_that_is_not_lammps(harness):
    done = harness("critical-angle", "--lmp", "/bin/true", status=3)
    assert "--lmp /bin/true is not LAMMPS" in done.stderr
    assert len(done.stderr.strip().splitlines()) <= 2
