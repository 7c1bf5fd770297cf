from pathlib import Path

import numpy as np
import pytest

from harness.comparison.verdicts import Verdict
from harness.errors import RequestError
from harness.upstream.defect_test import defect_as_test, defect_named
from harness.upstream.definition import read_test
from harness.upstream.runs import recorded_check, run_test

COMMITTED = sorted(Path(__file__).parents[2].glob("reports/defects/*/test.yaml"))
FAST = ("tsuji-restitution", "wall-tsuji-again")


@pytest.mark.parametrize(
    "file",
    [
        pytest.param(file, marks=[] if file.parent.name in FAST else pytest.mark.slow)
        for file in COMMITTED
    ],
    ids=[file.parent.name for file in COMMITTED],
)
def test_the_committed_tests_of_defects_are_what_is_computed(file, lmp):
    kept, fresh = read_test(file), defect_as_test(file.parent.name, lmp)
    for name in ("variables", "before_pair", "pair_style", "pair_coeff", "after_pair", "segments"):
        assert getattr(kept, name) == getattr(fresh, name)
    for table, values in fresh.recorded.items():
        size = np.abs(values[:, 2:]).max(initial=1e-30)
        assert np.allclose(kept.recorded[table], values, rtol=1e-9, atol=1e-9 * size)


def verdict(name, lmp, tmp_path):
    file = tmp_path / f"{name}.yaml"
    file.write_text(defect_as_test(name, lmp).text())
    test = read_test(file)
    return recorded_check(name, test, run_test(test, lmp))


@pytest.mark.parametrize("name", ["tsuji-restitution", "marshall-twist-with-mindlin"])
def test_the_test_of_a_defect_fails_where_it_is(name, lmp, tmp_path):
    assert verdict(name, lmp, tmp_path).verdict is Verdict.FAIL


@pytest.mark.parametrize("name", ["wall-shear-modulus", "dmt-limit-without-pull-off"])
def test_the_test_of_a_defect_passes_where_it_is_gone(name, lmp, tmp_path):
    row = verdict(name, lmp, tmp_path)
    assert row.verdict is Verdict.PASS
    assert row.value < 1e-12


@pytest.mark.parametrize(
    ("name", "why"),
    [
        ("rot-elastic-scaled", "one of esys"),
        ("moving-wall-at-rest-in-setup", "one system"),
        ("mdr-damping-interchanged", "mdr"),
        ("jkr-frozen-type-first", "fix freeze"),
    ],
)
def test_a_defect_that_is_no_such_test_is_refused(name, why, lmp):
    with pytest.raises(RequestError, match=why):
        defect_as_test(name, lmp)


def test_an_unknown_defect_is_refused_with_those_that_are_known():
    with pytest.raises(
        RequestError, match=r"'tsuji' is not known: did you mean .*tsuji-restitution"
    ):
        defect_named("tsuji")
