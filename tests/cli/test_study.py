"""``study`` from the command line: what is refused, before anything runs."""

import pytest


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (("incline",), "case 'incline' has no study: must be one of layers"),
        (("layers", "--quick", "--full"), "--quick and --full: give one of them only"),
        (("layers", "--reference", "none.csv"), "--reference none.csv: No such file"),
        (("layers", "--quick", "--runs", "none.csv"), "--runs none.csv: No such file"),
        (("layers", "--runs", "a.csv", "--cost"), "--runs and --cost: give one of them only"),
        (("layers", "--runs", "a.csv", "--fresh"), "--runs and --fresh: give one of them only"),
        (("layers", "--ranks", "2"), "--ranks 2: goes with --executor slurm only"),
        (
            ("layers", "--full"),
            "runs of study layers (level full, what is kept counted as well) would take",
        ),
    ],
)
def test_what_cannot_be_is_refused_in_one_line(harness, words, told):
    done = harness("study", *words, status=2)
    assert told in done.stderr
    assert done.stdout == ""
