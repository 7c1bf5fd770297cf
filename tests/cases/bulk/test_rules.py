"""Which codes follow one law, what becomes of means that differ, what is left to level default."""

import math
from dataclasses import replace
from functools import partial

import pytest
from scipy.integrate import solve_ivp

from harness.cases.bulk.equivalence import Sample, equivalence
from harness.cases.bulk.rules import Law, differing, law_of, with_tail
from harness.cases.bulk.seeds import MARGIN, Runs, effect, too_slow
from harness.cases.contract import Measured
from harness.cases.penetration import CASE
from harness.cases.verification import Study
from harness.comparison.verdicts import Triage, Verdict
from harness.engines.registry import engine_class
from harness.theory.contact import damping_ratio

LAWS = {
    name: law_of(engine_class(name).traits) for name in ("lammps", "liggghts", "yade", "kratos")
}


def test_lammps_and_liggghts_follow_one_law_yade_and_kratos_others():
    assert LAWS["lammps"] == LAWS["liggghts"]
    assert "attracts" in LAWS["lammps"].words
    assert len({law.words for law in LAWS.values()}) == 3


def test_the_values_of_a_law_state_it_in_scripts():
    job = CASE.job(CASE.default)
    values = LAWS["kratos"].stated(job.values)
    assert values["tangential"] == "mindlin_rescale/force"
    assert values["clipped"] == "yes"
    # sqrt(k_t/k_n) = sqrt(4 G*/E*) of nu = 0.2
    assert values["tangential_damping"] == pytest.approx((1.6 / 1.8) ** 0.5)
    for name in ("restitution", "steel_restitution"):
        assert values[name] == with_tail(job.values[name])
    same = {name: values[name] for name in job.values if not name.endswith("restitution")}
    assert same == {name: job.values[name] for name in same}
    own = LAWS["lammps"].stated(job.values)
    assert {name: own[name] for name in job.values} == job.values


def rebound(restitution, attracts):
    """Return the restitution of Hertz's spring with the dashpot of one that has a tail, or not.

    x'' = -x^1.5 - 2 sqrt(5/6) zeta sqrt(1.5) x^0.25 x' from x = 0 at speed 1, until the overlap is
    gone, or the force.
    """
    eta = 2.0 * math.sqrt(1.25) * damping_ratio(restitution)

    def force(_, state):
        x = max(state[0], 0.0)
        return [state[1], -(x**1.5) - eta * x**0.25 * state[1]]

    def over(time, state):
        x = max(state[0], 0.0)
        left = x if attracts else x**1.25 + eta * state[1]
        return 1.0 if time < 1e-3 else left

    over.terminal = True
    path = solve_ivp(
        force, (0, 50), [1e-12, 1.0], events=over, rtol=1e-10, atol=1e-12, max_step=0.05
    )
    return -path.y[1, -1]


@pytest.mark.parametrize("restitution", [0.3, 0.4, 0.45, 0.5, 0.8])
def test_a_restitution_without_a_tail_is_that_of_the_same_dashpot(restitution):
    """The fit is within 3e-4 of the restitution; a law with a tail would miss it by far more."""
    stated = with_tail(restitution)
    assert rebound(stated, attracts=False) == pytest.approx(restitution, abs=3e-4)
    assert rebound(stated, attracts=True) == pytest.approx(stated, abs=1e-5)
    assert abs(rebound(restitution, attracts=False) - restitution) > 0.005


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
    first, second = map(Law, laws)
    check = differing(equivalence("x", one, other, MARGIN), "one", first, "other", second)
    assert check.verdict is verdict
    assert ("one: a; other: b" in check.note) == (laws[0] != laws[1])
    assert check.value == pytest.approx(ratio)


RUNS = partial(Runs, equivalent=CASE.equivalent)


def test_runs_that_are_all_the_same_are_one_run_whatever_time_they_took():
    """A code that ignores the seed, or answers all jobs with one output, has no spread."""
    row = dict.fromkeys(CASE.equivalent, 1.0)
    seeds = [{**row, "seed": seed} for seed in range(5)]
    same = [{**row, "microseconds_per_particle_step": 0.1 * seed} for seed in range(5)]
    one, other = (RUNS(name, tuple(r)) for name, r in (("one", seeds), ("other", same)))
    assert {c.verdict for c in CASE.verification.compared([one, one])} == {Verdict.PASS}
    for pair in ([one, other], [other, one]):
        checks = list(CASE.verification.compared(pair))
        assert {check.verdict for check in checks} == {Verdict.NOT_TESTED}
        assert "of their own in other" in checks[0].note


@pytest.mark.parametrize("broken", [math.nan, math.inf])
def test_a_mean_that_is_no_number_fails_under_any_two_laws(broken):
    """What an engine's rules do to a mean is a finding; that it has none is not."""
    row = dict.fromkeys(CASE.equivalent, 1.0)
    seeds = tuple({**row, "seed": seed} for seed in range(5))
    faulty = (*seeds[1:], {**seeds[0], CASE.equivalent[0]: broken})
    one, other = RUNS("one", seeds, law=Law("a")), RUNS("other", faulty, law=Law("b"))
    first, *rest = CASE.verification.compared([one, other])
    assert (first.verdict, first.triage) == (Verdict.FAIL, Triage.NAN)
    assert {check.verdict for check in rest} == {Verdict.PASS}
    assert effect(first).verdict is Verdict.FAIL


(SYSTEM,) = CASE.systems("quick")
RULED = RUNS("Main", (), rules="Other", system=SYSTEM.name)
UNDER = {
    "same": (1.0, 1.1, Law("b"), Verdict.PASS),
    "another friction in the other code": (1.3, 1.1, Law("b"), Verdict.FAIL),
    "undecided": (1.05, 1.1, Law("b"), Verdict.NOT_TESTED),
    "rules that are stated in part": (1.3, 1.1, Law("near"), Verdict.FINDING),
}


@pytest.mark.parametrize("name", UNDER)
def test_a_code_is_held_against_the_main_one_under_its_own_rules(name):
    """Whatever the rules do, the verdict is of the code; what they do is a finding of a size."""
    ratio, effect, law, verdict = UNDER[name]
    spread = (0.96, 1.04, 1.0, 1.02, 0.98)

    def rows(mean):
        return tuple(dict.fromkeys(CASE.equivalent, mean * part) for part in spread)

    ruled = replace(RULED, rows=rows(effect), law=law)
    other = RUNS("Other", rows(effect * ratio), law=Law("b"), main=ruled, system=SYSTEM.name)
    main = RUNS("Main", rows(1.0), law=Law("a"), system=SYSTEM.name)
    checks = {c.name: c for c in CASE.verification.compared([main, other])}
    depth = CASE.equivalent[0]
    held = checks[f"penetration: Main under the rules of Other against Other: {depth}"]
    assert held.verdict is verdict
    rule = checks[f"penetration: Main under the rules of Other against Main: {depth}"]
    assert rule.verdict is Verdict.FINDING
    assert rule.value == pytest.approx(effect)
    assert "what the rules do" in rule.note
    assert "interval of the ratio" in rule.note
    own = checks[f"penetration: Main against Other: {depth}"]
    assert own.verdict is Verdict.FINDING


class Fake:
    """An engine with the rules of a code, whose depth its rules move, and a fault."""

    workers = 4

    def __init__(self, code, name="", fault=1.0):
        self.name, self.title = name or code, name or code
        self.traits, self.fault, self.ran = engine_class(code).traits, fault, []
        self.refused = "" if code == "lammps" else "its script has no variable 'tangential'"

    def refuses(self, job):
        return self.refused if "tangential" in job.values else ""

    def run(self, jobs):
        self.ran += [job.values for job in jobs]
        return [(job.values, self.fault, self.traits) for job in jobs]


@pytest.fixture
def faked(monkeypatch):
    """Let the depth be larger by a tenth where the spring is no displacement."""

    def measured(_, trial, output, traits):  # noqa: ARG001
        values, fault, rules = output
        spring = values.get("tangential", law_of(rules).values["tangential"])
        depth = fault * (1.0 if spring == "mindlin" else 1.1) * (1.0 + 0.02 * (trial.seed % 3 - 1))
        row = {quantity.name: 1e-9 * trial.seed for quantity in CASE.quantities}
        return Measured(row | dict.fromkeys(CASE.equivalent, depth))

    monkeypatch.setattr(type(CASE), "measured", measured)
    monkeypatch.setattr(type(CASE), "curves", lambda *_: ())


def held(main, *others):
    """Return the rows that hold engines against one another, by their names."""
    study = Study("default")
    CASE.verification.run(main, study)
    beside = replace(study, role="other")
    findings = {engine.name: CASE.verification.run(engine, beside) for engine in (main, *others)}
    assert not findings[main.name].checks  # they are among those of the main role
    checks = CASE.verification.compare(findings)
    assert len({check.name for check in checks}) == len(checks)
    return {check.name: check for check in checks}


@pytest.mark.parametrize(("fault", "verdict"), [(1.0, Verdict.PASS), (1.2, Verdict.FAIL)])
@pytest.mark.usefixtures("faked")
def test_the_main_engine_runs_the_rules_of_another_and_a_fault_in_that_one_fails(fault, verdict):
    main, other = Fake("lammps"), Fake("yade", fault=fault)
    checks = held(main, other)
    depth = CASE.equivalent[0]
    ruled = checks[f"penetration: lammps under the rules of yade against yade: {depth}"]
    assert ruled.verdict is verdict
    effect = checks[f"penetration: lammps under the rules of yade against lammps: {depth}"]
    assert (effect.verdict, effect.value) == (Verdict.FINDING, pytest.approx(1.1))
    law = law_of(engine_class("yade").traits)
    stated = [values for values in main.ran if values.get("tangential") == "mindlin/force"]
    assert len(stated) == CASE.seeds["default"]
    assert stated[0] == law.stated(CASE.job(CASE.default).values)


@pytest.mark.usefixtures("faked")
def test_a_main_engine_that_states_no_other_rules_leaves_no_verdict():
    checks = held(Fake("yade"), Fake("lammps"))
    rules = [check for name, check in checks.items() if "the rules of lammps" in name]
    assert {check.verdict for check in rules} == {Verdict.NOT_TESTED}
    assert "its script has no variable 'tangential'" in rules[0].note


@pytest.mark.parametrize("code", ["yade", "kratos"])
def test_slow_codes_are_not_tested_at_level_quick_with_the_reason(code):
    engine = engine_class(code).__new__(engine_class(code))
    engine._scheme = "Velocity_Verlet"
    found = CASE.verification.run(engine, Study("quick"))
    assert [check.name for check in found.checks] == CASE.verification.names(engine, SYSTEM)
    assert {check.verdict for check in found.checks} == {Verdict.NOT_TESTED}
    assert "level default runs it" in found.checks[0].note
    assert not found.evidence
    assert not too_slow(engine, "default", SYSTEM)
    published = CASE.systems("default")[1]
    assert "beyond the 3 us of level default" in too_slow(engine, "default", published)
    assert not too_slow(engine, "full", published)
    assert not too_slow(engine_class("lammps").__new__(engine_class("lammps")), "quick", SYSTEM)
