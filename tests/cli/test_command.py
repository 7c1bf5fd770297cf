"""What is wrong on a command line is said in two lines: option, value, what is allowed."""

import pytest

WRONG = {
    "verfy": ("verfy", "verify"),
    "theory --restituton 0.5": ("--restituton", "did you mean --restitution"),
    "theory --shock x": ("--shock 'x'", "a number"),
    "theory --shock": ("--shock", "given a value"),
    "theory --reading kep": ("--reading 'kep'", "kept, lost", "did you mean kept"),
    "theory extra": ("'extra'", "more than"),
    "verify --quick=x": ("--quick", "'x'", "flag"),
    "verify --no-quick": ("--no-quick", "--quick"),
    "tower --height 1.5": ("--height '1.5'", "whole number"),
    "sweep incline --over": ("--over", "given a value"),
    "run": ("CASE", "given a value"),
    "diff one": ("AFTER", "given a value"),
    "baseline comparo": ("comparo", "compare"),
    "verify --only oblik": ("--only 'oblik'", "near it", "'oblique'"),
    f"tower --series {'a' * 300}": ("--series", "name too long"),
}


@pytest.mark.parametrize("line", WRONG)
def test_a_wrong_word_is_named_with_what_is_allowed(command, line):
    said = command(*line.split(), status=2)
    assert said.out == ""
    assert said.err.count("\n") <= 2
    for part in WRONG[line]:
        assert part.lower() in said.err.lower()


def test_an_option_that_is_given_twice_counts_as_the_last(command):
    said = command("theory", "--shock", "0.5", "--shock", "0.1", "--json", "--json")
    assert '"shock": 0.1' in said.out


@pytest.mark.parametrize("words", [(), ("baseline",)])
def test_without_a_command_the_help_is_shown_and_the_request_was_wrong(command, words):
    assert "Usage: dem-harness" in command(*words, status=2).out
    assert command(*words, "-h").out == command(*words, "--help").out


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("critical-angle --stiffness -5", "--stiffness -5.0 N/m: must be greater than 0"),
        ("critical-angle --restitution 0.9", "use --method steady"),
        ("theory --shock=2", "--shock 2.0 is not allowed: must be from 0 to 1"),
        ("tower --height 0", "--height 0"),
        ("verify --known-defects nowhere.toml", "--known-defects nowhere.toml: No such file"),
    ],
)
def test_an_error_names_the_option_and_not_the_argument_of_a_function(command, line, said):
    assert said in command(*line.split(), status=2).err


def test_the_critical_angle_is_the_first_thing_that_is_printed(command):
    first, second, *_ = command(*["critical-angle", "--engine", "reference"]).out.splitlines()
    assert first.startswith("critical angle: 10.")
    assert "+-" in first
    assert second.startswith("closed form: 10.20782 deg")
