from dataclasses import replace

import pytest

from harness.comparison.verdicts import Verdict
from harness.engines.process import Limits
from harness.errors import EngineNaNError
from harness.upstream import runs
from harness.upstream.definition import COLUMNS
from harness.upstream.runs import run_upstream

pytestmark = pytest.mark.slow


def outcome(test, lmp, **options):
    (found,) = run_upstream([test], {"here": lmp}, **options).outcomes
    return found


def test_lammps_repeats_its_scheme_and_converges_to_the_law(impact, lmp):
    runs = run_upstream([impact], {"a": lmp, "b": lmp})
    for found in runs.outcomes:
        assert [check.verdict for check in found.checks] == [Verdict.PASS] * 3, found.to_json()
        assert found.law_difference < found.step_error < 1e-6
        assert not found.hides
    assert list(runs.to_frame()["release"]) == ["a", "b"]


def test_another_record_fails_and_names_the_component(impact, lmp):
    rows = impact.recorded["run_vel"].copy()
    rows[3, 4] *= 1.0 + 1e-6
    found = outcome(replace(impact, recorded={**impact.recorded, "run_vel": rows}), lmp)
    assert [check.verdict for check in found.checks] == [Verdict.FAIL, Verdict.FAIL, Verdict.PASS]
    assert "vz of atom 2 after segment 1" in found.checks[0].note


def with_tsuji(impact):
    words = "* * hertz/material ${E} 0.5 0.3 damping tsuji tangential linear_nohistory 0 0"
    return replace(impact, pair_coeff=(words,), recorded={})


@pytest.mark.xfail(strict=True, reason="upstream's tests are not held at equal steps yet")
def test_a_wrong_law_is_the_known_defect_that_explains_it(impact, lmp):
    found = outcome(with_tsuji(impact), lmp)
    assert found.defect == "tsuji-restitution"
    assert found.checks[-1].verdict is Verdict.KNOWN_DEFECT
    assert not found.hides


@pytest.mark.xfail(strict=True, reason="upstream's tests are not held at equal steps yet")
def test_a_wrong_law_that_no_defect_explains_fails(impact, lmp, monkeypatch):
    monkeypatch.setattr(runs, "known_defects", tuple)
    result = run_upstream([with_tsuji(impact)], {"here": lmp})
    (found,) = result.outcomes
    assert found.checks[-1].verdict is Verdict.FAIL
    assert found.law_difference == pytest.approx(0.116, abs=0.001)
    assert result.status == 1


def test_a_tolerance_that_covers_a_wrong_law_is_named(impact, lmp):
    assert outcome(replace(with_tsuji(impact), tolerance=0.2), lmp).hides


@pytest.mark.parametrize(
    ("command", "status", "said"),
    [
        ("no_such_command", 3, "Unknown command"),
        ("quit 7", 3, "exit status 7"),
    ],
)
def test_a_run_that_goes_wrong_is_a_row_and_the_others_go_on(impact, lmp, command, status, said):
    broken = replace(impact, after_pair=(*impact.after_pair, command))
    result = run_upstream([broken, impact], {"here": lmp})
    first, second = result.outcomes
    assert result.status == status
    assert {check.verdict for check in first.checks} == {Verdict.FAIL}
    assert any(said in check.triage + check.note for check in first.checks), first.checks
    assert {check.verdict for check in second.checks} == {Verdict.PASS}


def test_a_run_that_leaves_nan_went_wrong_and_did_not_die(impact, lmp, monkeypatch):
    def nan(*_, **__):
        raise EngineNaNError("vz of atom 1")

    monkeypatch.setattr(runs, "run_test", nan)
    result = run_upstream([impact], {"here": lmp})
    assert result.status == 1
    assert [check.triage for check in result.outcomes[0].checks] == ["NaN", "NaN"]


def test_nan_in_a_dump_is_found(tmp_path):
    values = " ".join("nan" if name == "vz" else "1" for name in COLUMNS)
    (tmp_path / "state.1").write_text("\n".join([*["ITEM:"] * 9, values]))
    with pytest.raises(EngineNaNError, match=r"state\.1"):
        runs.read_state(tmp_path / "state.1")


def test_a_run_that_hangs_is_ended(impact, lmp):
    endless = replace(impact, segments=(2_000_000_000,))
    found = outcome(endless, lmp, limits=Limits(seconds=1.0))
    assert "did not finish within 1 s" in found.checks[0].note


def test_what_is_no_scene_is_not_tested(impact, lmp):
    drag = replace(impact, after_pair=(*impact.after_pair, "fix drag all viscous 1e-9"))
    found = outcome(replace(drag, recorded={}), lmp)
    assert found.checks[-1].verdict is Verdict.NOT_TESTED
    assert "fix viscous" in found.why


def test_an_error_of_the_harness_is_a_row_and_the_others_go_on(impact, lmp, monkeypatch):
    held = runs.recorded_check

    def raises(name, test, run):
        if test.name == "broken":
            raise ZeroDivisionError("on purpose")
        return held(name, test, run)

    monkeypatch.setattr(runs, "recorded_check", raises)
    result = run_upstream([replace(impact, name="broken"), impact], {"here": lmp})
    first, second = result.outcomes
    assert [check.triage for check in first.checks] == ["harness error"]
    assert {check.verdict for check in second.checks} == {Verdict.PASS}
    assert result.status == 1


def test_a_rule_that_moves_nothing_explains_nothing(impact, lmp):
    rows = impact.recorded["run_vel"].copy()
    rows[:, 4] *= 1.1
    found = outcome(replace(impact, recorded={"run_vel": rows}), lmp)
    assert found.defect == ""
    assert found.checks[0].verdict is Verdict.FAIL
