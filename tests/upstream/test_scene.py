"""Files as tests, commands as scenes: every word is understood, or named."""

import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from harness.errors import RequestError
from harness.upstream import MOTION, read_test, read_tests, run_test
from harness.upstream.scene import NotUnderstoodError, check_words, granular_law, read_scene
from tests.upstream.conftest import askew, named, run_with_newton_off

TSUJI = Path(__file__).parents[2] / "reports/defects/tsuji-restitution/test.yaml"
FLOOR = "wall/gran granular hooke 1e5 5 damping velocity tangential linear_history 3e4 0.1 0.4"
LINEAR = "damping velocity tangential linear_history"
SIZE = "set group all diameter 0.02 density 2500"
UPPER = ["fix upper upper nve/sphere"]


def pair(*laws):
    return [f"pair_coeff {law}" for law in laws]


def lying(mover="nve/sphere"):
    """Return the lines of two spheres that meet askew in the plane z = 0."""
    places = ("1 single -0.01005 0 0", "2 single 0.01005 0.003 0")
    return {
        "units": ["units si", "dimension 2"],
        "boundary": ["boundary f f p"],
        "create_atoms": [f"create_atoms {place} units box" for place in places],
        "set": [SIZE, "set type 1 vx 0.5", "set type 2 vx -0.5"],
        "fix": [f"fix move all {mover}"],
    }  # fmt: skip


UNDERSTOOD = {
    "the default step": askew(
        timestep=[], units=[], set=[SIZE, "set type 1 vz 0.002"],
        pair_coeff=pair(f"* * hooke 1 0.01 {LINEAR} 0.3 0.1 0.3"),
    ),
    "two movers": askew(fix=["fix a lower nve/sphere", *UPPER]),
    "at rest": askew("velocity lower set 0 0 0", fix=UPPER),
    "carried": askew(fix=["fix a lower nve/noforce", *UPPER]),
    "gravity twice": askew("fix g all gravity 9 vector 0 0 -1", "fix h all gravity 3 vector 2 0 0"),
    "spheres moved after a run": askew("run 0", "set type 1 z -0.0099"),
    "drag": askew("fix drag all viscous 0.01"),
    "mixed materials": askew(pair_coeff=pair(
        f"1 1 hertz/material 1e8 1 0.3 {LINEAR} 3e4 0.5 0.3 rolling sds 1e3 0.1 0.1",
        f"2 2 hertz/material 3e8 1 0.2 {LINEAR} 3e4 0.5 0.3 rolling sds 1e3 0.1 0.1",
    )),
    "each pair of types": askew(pair_coeff=pair(
        "* * hooke 1e4 0 damping velocity tangential linear_nohistory 0 0",
        f"2 1 jkr 1e8 3 0.2 0.5 {LINEAR} 3e4 0.5 0.3 rolling sds 1e3 0.1 0.1",
    )),
    "pairs of an asterisk, the smaller type first": askew(pair_coeff=pair(*(
        f"{types} hooke {k} 3 {LINEAR} 3e3 0.5 0.3"
        for types, k in (("* *", 1e4), ("2 *", 2e4), ("* 1", 3e4))
    ))),
    "walls of groups": askew(
        "set type 1 type 2", f"fix floor all {FLOOR} zplane -0.02 0.0201",
        f"fix side lower {FLOOR} limit_damping xplane NULL 0.0099",
    ),
    "a slit that the other sphere is too wide for": askew(
        f"fix slit lower {FLOOR} xplane -0.0099 0.0051",
        set=[SIZE, "set type 1 diameter 0.01 density 2500", "set type 1 vz 0.5"],
    ),
    "old styles": askew(
        "fix floor all wall/gran hertz/history 1e8 NULL 9 NULL 0 1 limit_damping zplane -0.02 NULL",
        pair_style=["pair_style gran/hooke/history 1e5 NULL 10 3 0.3 1"],
        pair_coeff=["pair_coeff * *"],
    ),
    "parts that do nothing": askew(
        pair_coeff=pair("* * hertz/material 1e8 0 0.3 tangential linear_history 0 0 0")
    ),
    "sticky without dashpot": askew(pair_coeff=pair(
        "* * jkr 1e8 0 0.3 0.5 tangential linear_history 0 0.5 0 rolling sds 1e3 0.1 0.1"
    )),
    "no pairs": askew(pair_style=["pair_style none"], pair_coeff=[]),
    "a fix taken back": askew("fix g all gravity 9 vector 0 0 1", "unfix g"),
    "a condition": askew(
        "variable h equal 2*3",
        'if "${h} > 5" then "fix g all gravity $(v_h) vector 0 0 -1" else "fix d all viscous 9"',
    ),
    "over a periodic boundary": askew(
        boundary=["boundary p p p"], region=["region box block -0.2 0.2 -0.2 0.2 -0.05 0.05"],
        create_atoms=["create_atoms 1 single 0 0 0.03995 units box",
                      "create_atoms 2 single 0.003 0 -0.03995 units box"],
    ),
    "discs": askew("fix flat all enforce2d", **lying("nve/sphere disc")),
    "spheres in a plane": askew(**lying()),
    "forces alone": named(askew(create_atoms=[
        "create_atoms 1 single 0 0 -0.00995 units box",
        "create_atoms 2 single 0.001 0 0.00995 units box",
    ]), segments=(0,)),
}  # fmt: skip


@pytest.fixture(scope="module")
def motions(lmp):
    tests = [named(test, name=name) for name, test in UNDERSTOOD.items()]
    rows = run_with_newton_off(tests, lmp).rows
    return rows[rows["quantity"] == MOTION].set_index("setup")


@pytest.mark.parametrize("name", UNDERSTOOD)
def test_what_is_understood_agrees_to_round_off(motions, name):
    row = motions.loc[name]
    assert row["verdict"] == "pass", row["note"]
    assert row["value"] < 1e-12


NOT_UNDERSTOOD = {
    "exclude": askew("neigh_modify exclude type 1 1"),
    "'fix setforce'": askew("fix hold all setforce 0 0 0"),
    "group 'upper' is not all that moves": askew("fix g upper gravity 9 vector 0 0 1"),
    "'chute'": askew("fix g all gravity 9 chute 20"),
    "'v_g'": askew("variable g equal 9", "fix g all gravity v_g vector 0 0 1"),
    "moved twice": askew("fix again upper nve/sphere"),
    "'dynamic'": askew("group some dynamic all every 1"),
    "'wiggle'": askew(f"fix w all {FLOOR} zplane -1 NULL wiggle z 0.1 1"),
    "'zcylinder'": askew(f"fix w all {FLOOR} zcylinder 0.5"),
    "'timeout'": askew("timer timeout 0:01:00"),
    "'grain'": askew("pair_coeff grain 2 hooke 1 0"),
    "'5'": askew("run 5"),
    "'thermo_modify'": askew("thermo_modify lost ignore"),
    "types of other coefficients": askew(pair_coeff=pair(
        "1 1 hertz 1e8 0 tangential mindlin 1e8 0.5 0.3",
        "2 2 hertz 4e8 0 tangential mindlin 1e8 0.5 0.3",
    )),
    "'1*'": askew("pair_coeff 1* 2 hertz 1e8 0"),
    "gamma_t = 3": askew(pair_style=["pair_style gran/hooke 1e4 NULL 0 3 0.5 1"], pair_coeff=[]),
    "'mdr'": askew(pair_coeff=pair("* * mdr 1e8 0.3 1e6 0 0 1 damping mdr 1")),
    "has a velocity, and no fix moves it": askew(fix=UPPER),
    "leaves the plane": askew(**lying()),
    "no sphere at the start": askew(),
    "the nearer one alone": askew(f"fix w all {FLOOR} zplane -0.0101 0.0098"),
    "'set' after a run": askew("run 0", "set type 1 z -0.0101",
                               pair_coeff=pair("* * jkr 1e8 1 0.3 5 damping velocity "
                                               "tangential linear_nohistory 0 0")),
    "no sphere is free": askew("fix d all viscous 0.01", fix=["fix a all nve/noforce"]),
    "'0' after a step": named(askew(), segments=(0, 300, 0)),
}  # fmt: skip
# by the word that the error names
OTHER_STATES = {"leaves the plane": {"omegax": np.ones(2)},
                "no sphere at the start": {"id": np.zeros(0)}}  # fmt: skip


@pytest.fixture(scope="module")
def state(lmp):
    return run_test(askew(), lmp).states[0]


def read(test, state):
    """Return the scene of a test whose variables LAMMPS has nothing to fill in for."""
    log = "".join(f"COMMAND {n}\n{command}\n" for n, command in enumerate(test.commands))
    return read_scene(test, log, state, 2e-6)


@pytest.mark.parametrize("word", NOT_UNDERSTOOD)
def test_what_is_not_understood_is_named(state, word):
    with pytest.raises(NotUnderstoodError, match=re.escape(word)):
        read(NOT_UNDERSTOOD[word], {**state, **OTHER_STATES.get(word, {})})


@pytest.mark.parametrize(
    ("segments", "every"), [((300, 300), 1), ((150_000, 200_000), 5), ((100_000, 99_991), 1)]
)
def test_the_motion_has_samples_at_the_ends_and_between(state, segments, every):
    reading = read(named(askew(), segments=segments), state)
    assert reading.scene.every == every
    assert not any(end % every for end in reading.ends)


@pytest.mark.parametrize(
    "words",
    [
        "hertz 1e8 0 tangential mindlin NULL 0.5 0",
        "hertz 1e8 5 damping none tangential linear_nohistory 0.5 0.3",
        "hertz 1e8 5 tangential linear_history 3e4 0.5 0",
    ],
)
def test_parts_that_do_nothing_are_left_out(words):
    assert granular_law(words.split()).tangential == "none"


@given(st.text(st.characters(categories=("Ll",)), min_size=1, max_size=9))
def test_a_command_that_is_not_in_the_table_is_named(word):
    with pytest.raises(NotUnderstoodError, match=f"'x{word}'"):
        check_words([f"x{word}", "1"])
    with pytest.raises(NotUnderstoodError, match=f"'x{word}'"):
        check_words(["fix", "a", "all", "nve/sphere", f"x{word}"])


def test_values_of_a_file(tmp_path):
    test = read_test(TSUJI)
    assert "variable damping index tsuji" in test.commands
    assert test.commands[-1] == "timestep 1e-7"
    assert (test.segments, test.epsilon, test.judged_segment) == ((3000, 3000), 1e-8, 1)
    assert np.isnan(test.tolerance)
    assert {rows.shape for rows in test.recorded.values()} == {(4, 5)}
    assert test.recorded["run_vel"][0, 4] == -2.7370684220428704e-01
    file = tmp_path / "judged.yaml"
    judged = "analytic_enable: yes\nanalytic_segment: 0\n"
    for tolerance, expected in (("", np.nan), ("analytic_tol: 0.1\n", 0.1)):
        file.write_text(TSUJI.read_text().replace("input_file:", f"{judged}{tolerance}input_file:"))
        test = read_test(file)
        assert test.judged_segment == 0
        assert test.tolerance == pytest.approx(expected, nan_ok=True)


TEXT = TSUJI.read_text()
SEGMENTS = "run_segments: |\n  3000 3000"


@pytest.mark.parametrize(
    ("change", "word"),
    [
        ((SEGMENTS, "run_segments: 100.7 5"), "run_segments = "),
        ((SEGMENTS, "run_segments: '# x'"), "run_segments = "),
        (("pair_style: granular", "pair: granular"), "pair_style"),
        (("epsilon: 1e-08", "epsilon: small"), "epsilon = 'small'"),
        (("run_vel: |2\n    0 ", "run_vel: |2\n    nan "), "run_vel"),
        (("pre_commands: |", "pre_commands: ["), "cannot be read"),
        ((TEXT, "[" * 1000), "cannot be read"),
        ((TEXT, "- 1\n"), "must be a test of unittest/granular"),
        ((TEXT, "pair_style: [a]\n"), "must be a test of unittest/granular"),
        ((TEXT, "\udcff\udcfe\x00"), "cannot be read"),
    ],
)
def test_a_file_that_is_no_test_is_refused_by_file_and_key(tmp_path, change, word):
    file = tmp_path / "broken.yaml"
    assert change[0] in TEXT
    file.write_text(TEXT.replace(*change), errors="surrogateescape")
    with pytest.raises(RequestError) as refused:
        read_test(file)
    assert str(file) in str(refused.value)
    assert word in str(refused.value)
    assert "object has no attribute" not in str(refused.value)
    assert "\n" not in str(refused.value)


def test_a_folder_without_tests_is_refused(tmp_path):
    for path in (tmp_path, tmp_path / "none.yaml"):
        with pytest.raises(RequestError, match=str(path)):
            read_tests(path)
