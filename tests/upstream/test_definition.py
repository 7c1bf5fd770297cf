import numpy as np
import pytest

from harness.errors import RequestError
from harness.upstream.definition import read_test, read_tests


def test_a_test_is_read_as_it_was_written(impact, tmp_path):
    file = tmp_path / "impact.yaml"
    file.write_text(impact.text())
    read = read_test(file)
    for name in ("variables", "before_pair", "pair_style", "pair_coeff", "after_pair", "segments"):
        assert getattr(read, name) == getattr(impact, name)
    assert read.epsilon == impact.epsilon
    assert read.atoms == 2
    for name, rows in impact.recorded.items():
        np.testing.assert_array_equal(read.recorded[name], rows)


def test_the_step_is_divided_and_segments_take_more_steps(impact):
    script = impact.script("on", finer=4).splitlines()
    assert script[0] == "newton on"
    assert "timestep $(dt/4:%.17g)" in script
    assert [line for line in script if line.startswith("run ")] == [
        "run 0 post no",
        "run 6000 post no",
        "run 18000 post no",
    ]


@pytest.mark.parametrize(
    ("change", "named"),
    [
        (("pair_style: granular", "pair: granular"), "pair_style"),
        (("  1500 4500", "  1500 many"), "1500 many"),
        (("epsilon: 1e-09", "epsilon: small"), "epsilon = 'small'"),
        (("run_vel: |2\n    0 ", "run_vel: |2\n    x "), "run_vel"),
        (("pre_commands: |", "pre_commands: ["), "cannot be read"),
    ],
)
def test_a_file_that_is_no_test_is_refused_by_file_and_key(impact, tmp_path, change, named):
    file = tmp_path / "broken.yaml"
    text = impact.text().replace(*change)
    assert text != impact.text()
    file.write_text(text)
    with pytest.raises(RequestError) as refused:
        read_test(file)
    assert str(file) in str(refused.value)
    assert named in str(refused.value)
    assert "\n" not in str(refused.value)


def test_a_folder_without_tests_is_refused(tmp_path):
    for path in (tmp_path, tmp_path / "none.yaml"):
        with pytest.raises(RequestError, match=str(path)):
            read_tests(path)
