from pathlib import Path

import numpy as np
import pytest

from harness.comparison.verdicts import Verdict
from harness.errors import RequestError
from harness.upstream.definition import read_test, read_tests
from harness.upstream.runs import recorded_check, run_test

DEFECTS = Path(__file__).parents[2] / "reports/defects"
TSUJI = DEFECTS / "tsuji-restitution/test.yaml"
OF_DEFECTS = {file.parent.name: file for file in sorted(DEFECTS.glob("*/test.yaml"))}
FAIL_HERE = {
    *("marshall-twist-with-mindlin", "mixed-tangential-stiffness", "old-wall-friction"),
    *("tsuji-restitution", "wall-tsuji-again"),
}


def test_a_test_is_read(impact):
    read = read_test(TSUJI)
    assert read.variables == (("e", "0.5"), ("damping", "tsuji"))
    assert read.before_pair[-1] == "set atom 2 vz -0.5"
    assert read.pair_style == "granular"
    assert read.pair_coeff[0].startswith("* * hertz/material 1e9 ${e} 0.3 damping")
    assert read.after_pair[-1] == "timestep 1e-7"
    assert read.segments == (3000, 3000)
    assert read.epsilon == 1e-8
    assert np.isnan(read.tolerance)
    assert {name: rows.shape for name, rows in read.recorded.items()} == dict.fromkeys(
        impact.recorded, (4, 5)
    )
    assert read.recorded["run_vel"][0, 4] == -2.7370684220428704e-01


def test_the_step_is_divided_and_segments_take_more_steps(impact):
    script = impact.script("on", finer=4).splitlines()
    assert script[0] == "newton on"
    assert "timestep $(dt/4:%.17g)" in script
    assert [line for line in script if line.startswith("run ")] == [
        "run 0 post no",
        "run 6000 post no",
        "run 18000 post no",
    ]


@pytest.mark.parametrize("name", OF_DEFECTS)
def test_the_test_of_a_defect_fails_where_lammps_has_the_defect(name, lmp):
    test = read_test(OF_DEFECTS[name])
    row = recorded_check(name, test, run_test(test, lmp))
    assert row.verdict is (Verdict.FAIL if name in FAIL_HERE else Verdict.PASS)


@pytest.mark.parametrize(
    ("change", "named"),
    [
        (("pair_style: granular", "pair: granular"), "pair_style"),
        (("run_segments: |\n  ", "run_segments: |\n  many "), "many"),
        (("epsilon: 1e-08", "epsilon: small"), "epsilon = 'small'"),
        (("run_vel: |2\n    0 ", "run_vel: |2\n    x "), "run_vel"),
        (("pre_commands: |", "pre_commands: ["), "cannot be read"),
    ],
)
def test_a_file_that_is_no_test_is_refused_by_file_and_key(tmp_path, change, named):
    file = tmp_path / "broken.yaml"
    text = TSUJI.read_text()
    assert change[0] in text
    file.write_text(text.replace(*change))
    with pytest.raises(RequestError) as refused:
        read_test(file)
    assert str(file) in str(refused.value)
    assert named in str(refused.value)
    assert "\n" not in str(refused.value)


def test_a_folder_without_tests_is_refused(tmp_path):
    for path in (tmp_path, tmp_path / "none.yaml"):
        with pytest.raises(RequestError, match=str(path)):
            read_tests(path)
