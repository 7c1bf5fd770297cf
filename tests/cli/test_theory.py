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


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--shock", "1.5"], ["shock = 1.5", "from 0 to 1"]),
        (["--shock", "nan"], ["shock = nan"]),
        (["--restitution", "-0.1"], ["restitution = -0.1", "from 0 to 1"]),
        (["--restitution", "1.1"], ["restitution = 1.1"]),
        (["--impulse-ratio", "0"], ["impulse-ratio = 0.0", "greater than 0"]),
        (["--impulse-ratio", "2"], ["impulse-ratio = 2.0", "less than 2"]),
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
