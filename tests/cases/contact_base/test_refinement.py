"""Limits that are too uncertain are refined, or left undecided; none fails for its uncertainty."""

import math
from dataclasses import replace

import numpy as np
import pytest

from harness.cases.contact.limits import FINEST, STEPS, powers, refine, unresolved
from harness.cases.contact.motion import COLUMNS, followed
from harness.cases.contact.verification import verify_trials
from harness.cases.registry import get_case
from harness.cases.verification import Study
from harness.comparison.verdicts import Kind, Tolerance, Verdict, decided, is_undecided, judge
from harness.engines.contract import Engine, Output
from harness.engines.output import SERIES
from harness.engines.traits import Traits
from harness.observables.provenance import Provenance
from harness.parameters.rules import Rules


@pytest.mark.parametrize(
    ("apart", "uncertainty", "verdict"),
    [
        (0.5, 0.5, Verdict.PASS),
        (0.5, 2.0, Verdict.NOT_TESTED),  # agrees, but nobody knows
        (1.5, 0.2, Verdict.FAIL),
        (1.5, 0.7, Verdict.NOT_TESTED),  # no more than it is uncertain by
        (math.nan, 0.1, Verdict.FAIL),
        (0.5, math.nan, Verdict.NOT_TESTED),
    ],
)
def test_a_verdict_needs_an_uncertainty_within_the_tolerance(apart, uncertainty, verdict):
    row = judge("x", Kind.CROSS_CODE, 1.0 + apart, 1.0, Tolerance("", 1.0, 0.0, ""),
                uncertainty=uncertainty)  # fmt: skip
    assert decided(row, "no more runs").verdict is verdict
    assert is_undecided(1.0 + apart, 1.0, uncertainty, 1.0) is (verdict is Verdict.NOT_TESTED)
    if verdict is Verdict.NOT_TESTED:
        assert "undecided: 0.5 apart" in decided(row, "no more runs").note or apart != 0.5
        assert "no more runs" in decided(row, "no more runs").note


OFF = Rules(damping_in_cap="sticking_only")


def sliding(parameters, scene):
    """Return speed and rim speed at the end over the start, by a code that takes steps.

    A sphere on a floor at rest along z. The spring sticks, with its dashpot, up to mu F_n; beyond
    it slides without. Half a kick before the drift and half behind it, with the force at the ends.
    """
    h, m, g = scene.step, parameters.mass, parameters.gravity
    k, mu = parameters.tangential_stiffness, parameters.friction
    eta = parameters.tangential_damping * parameters.damping_coefficient
    k = parameters.normal_stiffness if k is None else k
    u, rim, spring, force = parameters.speed, 0.0, 0.0, 0.0
    for _ in range(scene.steps):
        u, rim = u + 0.5 * h * force / m, rim - 1.25 * h * force / m
        slip = u - rim
        spring += h * slip
        cap = mu * m * g
        if k * abs(spring) > cap:
            spring = math.copysign(cap / k, spring)
            force = -k * spring
        else:
            force = -k * spring - eta * slip
        u, rim = u + 0.5 * h * force / m, rim - 1.25 * h * force / m
    return {"speed_ratio": u / parameters.speed, "rim_speed_ratio": rim / parameters.speed}


def test_what_no_run_resolves_is_in_the_uncertainty():
    case = get_case("slip-to-roll")
    (trial,) = (one for one in case.trials("quick") if one.submodel == "linear_history")
    steps = STEPS["quick"]
    levels = [trial.parameters.replace(steps_per_contact=n) for n in steps]
    integrated = followed(case.scene(levels[-1]), OFF)
    expected = case.observed(levels[-1], integrated.motion)
    # it sticks for less than a step of the finest run, with a dashpot of thrice Coulomb's limit
    first = (
        integrated.intervals[1]
        if integrated.intervals[0].duration == 0.0
        else integrated.intervals[0]
    )
    assert first.duration < case.scene(levels[-1]).step
    runs = [sliding(one, case.scene(one)) for one in levels]
    bounds = unresolved(
        case, levels[-1], integrated, np.array([case.scene(one).step for one in levels])
    )
    terms, shape = powers(trial.parameters), {"kinked": True, "jumps": True}
    blind = refine(terms, steps, runs, **shape)
    honest = refine(terms, steps, runs, **shape, bounds=bounds)
    for name in ("speed_ratio", "rim_speed_ratio"):
        off = abs(blind[name].value - expected[name])
        assert off > blind[name].uncertainty  # what the runs show by themselves
        assert abs(honest[name].value - expected[name]) <= honest[name].uncertainty
    # finer runs resolve it: then nothing is added
    finer = unresolved(case, levels[-1], integrated, np.array([0.2 * first.duration]))
    assert all(float(part.max()) == 0.0 for part in finer.values())


class Jittering(Engine):
    """An engine that leaves what the law asks for, off by what a kink leaves, to and fro."""

    name, title = "jittering", "Jittering"

    def __init__(self, case, size, fault=0.0, cost=1.0):
        self.traits = Traits("", (), "", microseconds_per_step=cost)
        self.case, self.size, self.fault, self.ran = case, size, fault, []
        self.scenes = {}

    def identify(self):
        return Provenance("jittering", "1", (), "", "")

    def refuses(self, job):  # noqa: ARG002
        return ""

    def run(self, jobs):
        return [self.output(self.scenes[frozenset(job.values.items())]) for job in jobs]

    def output(self, scene):
        motion = followed(scene, Rules()).motion
        self.ran.append(scene.step)
        late = self.size * (-1.0) ** len(self.ran) * (scene.step / STEP) ** 2
        velocity = motion.velocity.copy()
        velocity[-1, 0] += self.fault + late
        motion = replace(motion, velocity=velocity)
        columns = {
            column: getattr(motion, part)[:, :, i]
            for part, names in COLUMNS.items()
            for i, column in enumerate(names)
        }
        return Output(
            (), self.identify(), {SERIES: {"step": np.round(motion.time / scene.step), **columns}}
        )


def jittering(size, **more):
    """Return the rows of an impact with friction, and the engine that ran it."""
    kind = type(get_case("oblique"))

    class Remembering(kind):
        def job(self, parameters):
            job = super().job(parameters)
            engine.scenes[frozenset(job.values.items())] = self.scene(parameters)
            return job

    case = Remembering()
    engine = Jittering(case, size, **more)
    trial = next(one for one in case.trials("quick") if one.submodel == "linear_history")
    found = verify_trials(case, engine, Study("quick"), [trial])
    return [one for one in found.checks if one.kind is not Kind.FINDING], engine


STEP = 9e-7
"""[s] of the finest run that every trial has."""

SMALL, LARGE = 1e-3, 10.0
"""[m/s] of a jitter at that step, of 1 m/s."""


def test_a_limit_is_refined_until_it_is_decided():
    rows, engine = jittering(SMALL)
    assert {one.verdict for one in rows} == {Verdict.PASS}
    assert len(engine.ran) > len(STEPS["quick"])
    assert all(one.uncertainty <= one.tolerance for one in rows)


def test_a_limit_that_stays_uncertain_is_not_tested_and_says_why():
    rows, engine = jittering(LARGE)
    undecided = [one for one in rows if one.verdict is Verdict.NOT_TESTED]
    assert undecided
    assert Verdict.FAIL not in {one.verdict for one in rows}
    assert f"{FINEST['quick']} steps of a contact are the finest" in undecided[0].note
    assert len(engine.ran) == len(STEPS["quick"]) + round(math.log2(FINEST["quick"] / 800))


def test_no_run_longer_than_the_level_allows_is_made():
    rows, engine = jittering(LARGE, cost=1e6)
    assert len(engine.ran) == len(STEPS["quick"])
    assert Verdict.NOT_TESTED in {one.verdict for one in rows}


def test_a_fault_beyond_tolerance_and_uncertainty_fails():
    rows, _ = jittering(SMALL, fault=1e-3)
    assert Verdict.FAIL in {one.verdict for one in rows}
