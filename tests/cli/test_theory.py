import math

import pytest


def _angle(ratio):
    return math.degrees(2 * math.atan(math.tan(math.radians(15)) * ratio))


def test_without_options_the_closed_form(answer):
    record = answer("theory")
    assert record["critical_angle_deg"] == pytest.approx(10.2078187220, abs=1e-10)
    assert record["shock"] == 0.25


@pytest.mark.parametrize(
    ("options", "angle"),
    [
        (["--shock", "0"], 30.0),
        (["--shock", "1"], 0.0),
        (["--restitution", "0"], 10.2078187),
        (["--restitution", "0", "--reading", "lost"], 10.2078187),
        (["--impulse-ratio", "1"], 10.2078187),
        # the velocity lost: tan(theta/2) = tan(15 deg) alpha / (4 - alpha)
        (["--impulse-ratio", "0.53"], _angle(0.53 / (4 - 0.53))),
        # the velocity kept: tan(theta/2) = tan(15 deg) (2 - alpha) / (2 + alpha)
        (["--impulse-ratio", "0.53", "--reading", "kept"], _angle((2 - 0.53) / (2 + 0.53))),
    ],
)
def test_options(answer, options, angle):
    assert answer("theory", *options)["critical_angle_deg"] == pytest.approx(angle, abs=1e-4)


def test_a_restitution_stands_beside_rigid_spheres_whichever_reading_is_chosen(answer):
    kept = answer("theory", "--restitution", "0.5")
    lost = answer("theory", "--restitution", "0.5", "--reading", "lost")
    # tan(theta/2) = tan(15 deg) (1 - v) / (1 + v), v^2 = 1/4 + 3/4 e^2, or 1 - v in its place
    v = math.sqrt(0.25 + 0.75 * 0.5**2)
    readings = {"kept": _angle((1 - v) / (1 + v)), "lost": _angle(v / (2 - v))}
    for record in (kept, lost):
        assert record["critical_angle_deg"] == pytest.approx(readings[record["reading"]], abs=1e-9)
        assert record["one_shock_kept_deg"] == pytest.approx(readings["kept"], abs=1e-9)
        assert record["one_shock_lost_deg"] == pytest.approx(readings["lost"], abs=1e-9)
        # measured by an independent DEM, its stiffness to infinity: tests/cases/incline/test_rigid
        assert record["event_driven_deg"] == pytest.approx(10.7224, abs=1e-3)
        assert "event_driven_deg" in record["caveat"]
    # rigid spheres need a steeper row where they rebound, the first reading says a flatter one
    without = answer("theory", "--restitution", "0")
    assert kept["critical_angle_deg"] < without["critical_angle_deg"] < kept["event_driven_deg"]
    assert without["event_driven_deg"] == pytest.approx(without["critical_angle_deg"], abs=1e-7)
    assert "caveat" not in without or without["caveat"] is None


def test_above_the_restitution_of_a_passage_there_is_no_event_driven_angle(answer):
    record = answer("theory", "--restitution", "0.8")
    assert record["event_driven_deg"] is None
    assert answer("theory", "--impulse-ratio", "0.53")["event_driven_deg"] is None


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--shock", "1.5"], ["--shock 1.5", "from 0 to 1"]),
        (["--shock", "nan"], ["--shock nan"]),
        (["--restitution", "-0.1"], ["--restitution -0.1", "from 0 to 1"]),
        (["--restitution", "1.1"], ["--restitution 1.1"]),
        (["--impulse-ratio", "0"], ["--impulse-ratio 0.0", "greater than 0"]),
        (["--impulse-ratio", "2"], ["--impulse-ratio 2.0", "less than 2"]),
        (["--shock", "0.2", "--restitution", "0"], ["--shock and --restitution"]),
        (["--reading", "kept"], ["--reading"]),
    ],
)
def test_bad_requests_name_the_option_the_value_and_the_range(harness, options, words):
    done = harness("theory", *options, status=2)
    assert done.stdout == ""
    assert len(done.stderr.strip().splitlines()) <= 2
    for word in words:
        assert word in done.stderr


def test_a_bad_reading_lists_the_good_ones(harness):
    done = harness("theory", "--restitution", "0", "--reading", "other", status=2)
    assert "kept" in done.stderr
    assert "lost" in done.stderr


@pytest.mark.parametrize(
    ("options", "angle", "model"),
    [
        (["--friction", "0"], 10.2078187, "closed form, no friction"),
        (["--grain-diameter", "2"], 2.4572237, "closed form, no friction"),
        (["--friction", "0.5"], 6.6674041, "closed form, rolls without slip"),
        (["--friction", "0.5", "--shape", "disc"], 6.1350746, "closed form, rolls without slip"),
        (["--friction", "0.1"], 7.6530638, "integrated: rigid grain, Coulomb friction in shock"),
        # the angle depends on the ratio of diameters alone
        (["--grain-diameter", "0.02", "--diameter", "0.01"], 2.4572237, "closed form, no"),
    ],
)
def test_friction_and_size(answer, options, angle, model):
    record = answer("theory", *options)
    assert record["critical_angle_deg"] == pytest.approx(angle, abs=5e-8)
    assert record["model"].startswith(model)
    # energies return over a well, but for what is lost on arcs by sliding
    falls = record["well_depth"] + record["gain_per_crest"]
    lost = 0.02 if record["model"].startswith("integrated") else 1e-12
    assert record["shock"] * falls == pytest.approx(record["steady_energy"], rel=lost)
    assert record["critical_angle_deg"] < record["no_flight_bound_deg"] < record["static_angle_deg"]
    assert record["smallest_grain_diameter_m"] < record["grain_diameter_m"]


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--friction", "-1"], ["--friction -1.0", "from 0 to 1e9"]),
        (["--friction", "nan"], ["--friction nan"]),
        (["--grain-diameter", "0.5"], ["--grain-diameter 0.5", "at least 0.81797 m"]),
        (
            ["--grain-diameter", "0.5", "--friction", "0.3"],
            ["--grain-diameter 0.5", "at least 0.652292 m at friction 0.3", "leaves the row"],
        ),
        (["--grain-diameter", "200"], ["--grain-diameter 200.0", "at most 100 m"]),
        (["--grain-diameter", "1", "--diameter", "0"], ["--diameter 0.0", "from 1e-30"]),
        (["--diameter", "2"], ["--diameter 2.0", "--grain-diameter"]),
        (["--shape", "disc"], ["--shape 'disc'", "--friction"]),
        (["--friction", "1", "--shock", "0.2"], ["--friction and --shock"]),
    ],
)
def test_bad_friction_and_size_name_the_option_the_value_and_the_bound(harness, options, words):
    done = harness("theory", *options, status=2)
    assert done.stdout == ""
    for word in words:
        assert word in done.stderr
