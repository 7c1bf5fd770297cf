"""Which codes follow one law, what becomes of means that differ, what is left to level default."""

from dataclasses import replace

import pytest

from harness.cases.bulk.equivalence import Sample, equivalence
from harness.cases.bulk.rules import differing, law_of
from harness.cases.bulk.seeds import MARGIN, Runs, too_slow
from harness.cases.penetration import CASE
from harness.cases.verification import Study
from harness.comparison.verdicts import Verdict
from harness.engines.registry import engine_class

LAWS = {
    name: law_of(engine_class(name).traits) for name in ("lammps", "liggghts", "yade", "kratos")
}


def test_lammps_and_liggghts_follow_one_law_yade_and_kratos_others():
    assert LAWS["lammps"] == LAWS["liggghts"]
    assert "attracts" in LAWS["lammps"]
    assert len(set(LAWS.values())) == 3


def test_the_laws_are_those_declared_with_the_contact_models():
    assert "grows by increments; the dashpot never attracts" in LAWS["yade"]
    assert "shrinks with the overlap" in LAWS["kratos"]
    assert "dashpot along the surface that is tied to the normal one" in LAWS["kratos"]
    yade = engine_class("yade").traits
    mindlin = yade.contact_models[-1]
    states = {**mindlin.states, "tangential": ("mindlin",)}
    other = replace(yade, contact_models=(replace(mindlin, states=states),))
    assert "times the stiffness of the overlap as it is; the dashpot never" in law_of(other)


@pytest.mark.parametrize(
    ("ratio", "laws", "verdict"),
    [
        (1.0, ("a", "a"), Verdict.PASS),
        (1.0, ("a", "b"), Verdict.PASS),
        (1.2, ("a", "a"), Verdict.FAIL),
        (1.2, ("a", "b"), Verdict.FINDING),
    ],
)
def test_means_that_differ_are_a_failure_under_one_law_and_a_finding_between_two(
    ratio, laws, verdict
):
    one, other = Sample("one", (ratio,) * 5), Sample("other", (1.0,) * 5)
    check = differing(equivalence("x", one, other, MARGIN), "one", laws[0], "other", laws[1])
    assert check.verdict is verdict
    assert ("one: a; other: b" in check.note) == (laws[0] != laws[1])
    assert check.value == pytest.approx(ratio)


def test_engines_of_two_laws_are_compared_by_the_case():
    row = dict.fromkeys(CASE.equivalent, 1.0)
    far = {**row, CASE.equivalent[0]: 2.0}
    one = Runs("LAMMPS", (row,) * 5, law=LAWS["lammps"])
    for code, verdict in (("liggghts", Verdict.FAIL), ("yade", Verdict.FINDING)):
        checks = list(CASE.compared([one, Runs(code, (far,) * 5, law=LAWS[code])]))
        assert [check.verdict for check in checks[:2]] == [verdict, Verdict.PASS]


@pytest.mark.parametrize("code", ["yade", "kratos"])
def test_slow_codes_are_not_tested_at_level_quick_with_the_reason(code):
    engine = engine_class(code).__new__(engine_class(code))
    engine._scheme = "Velocity_Verlet"
    found = CASE.verification.run(engine, Study("quick"))
    assert [check.name for check in found.checks] == CASE.names(engine)
    assert {check.verdict for check in found.checks} == {Verdict.NOT_TESTED}
    assert "level default runs it" in found.checks[0].note
    assert found.evidence is None
    assert not too_slow(engine, "default")
    assert not too_slow(engine_class("lammps").__new__(engine_class("lammps")), "quick")
