"""Which digests are of one input: rounding and folders are no input, all else is."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from harness.results.compare import differ, digest

SCENE = {"steps": 50, "units": "si", "step": 2.0e-5, "bodies": [{"position": [0.0, -1.3e-6, 0.01]}]}
JOB = ["silo", {"places": "/home/one/beds/3f2a.data", "friction": 0.3}, SCENE]
CHANGES = {
    "a number off by 1e-7": (2.0e-5, 2.0e-5 * (1 + 1e-7)),
    "its sign": (-1.3e-6, 1.3e-6),
    "a zero": (0.0, 1e-12),
    "a whole number": (50, 51),
    "a text": ("si", "lj"),
    "another bed": ("/home/one/beds/3f2a.data", "/home/one/beds/3f2b.data"),
}


def changed(content, old, new):
    """Return nested lists and tables with one value in place of another."""
    if isinstance(content, dict):
        return {name: changed(value, old, new) for name, value in content.items()}
    if isinstance(content, list):
        return [changed(item, old, new) for item in content]
    return new if content == old and type(content) is type(old) else content


def are_other(one, two):
    """Return whether two digests are of different inputs."""
    return list(differ([one], [two])) == [True]


@pytest.mark.parametrize("name", CHANGES)
def test_another_input(name):
    assert are_other(digest(JOB), digest(changed(JOB, *CHANGES[name])))


def test_two_numbers_that_changed_places_are_another_input():
    assert are_other(digest([1.0, 2.0]), digest([2.0, 1.0]))


# among them all numbers that lie next to a limit of rounding, as 0.5 or 2.1889752155e-05
@given(st.lists(st.floats(1e-9, 1e9), min_size=1, max_size=20), st.floats(-1e-11, 1e-11))
def test_the_last_digits_of_numbers_are_no_input(numbers, share):
    other = [number * (1.0 + share) for number in numbers]
    assert not are_other(digest([numbers, 2]), digest([other, 2]))


def test_the_folder_of_a_file_named_by_its_content_and_the_sign_of_zero_are_no_input():
    moved = changed(JOB, "/home/one/beds/3f2a.data", "/tmp/3f2a.data")
    assert digest(moved) == digest(JOB) == digest(changed(JOB, 0.0, -0.0))


def test_a_digest_that_an_earlier_version_rounded_is_not_compared():
    assert not are_other("00f0a6d29b3c41e5", digest(JOB))
    assert are_other("00f0a6d29b3c41e5", "10f0a6d29b3c41e5")
    assert not are_other("", digest(JOB))
