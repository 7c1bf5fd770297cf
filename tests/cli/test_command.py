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
    "sweep incline --over angle=9 --cpus 0": ("--cpus 0", "1 or more"),
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
