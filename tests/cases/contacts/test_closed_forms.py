"""Closed forms of the contact cases, held against the limit of small steps of the reference."""

import math

import numpy as np
import pytest
from scipy.optimize import brentq

from harness.cases.bench import OWN, Bench
from harness.cases.checks import run_checks
from harness.cases.contacts import oblique
from harness.cases.contacts.contact_case import ContactCase
from harness.results.rows import Kind
from harness.theory.contact import partial_slip_rebound, stiffness_ratio
from tests.cases.contacts.common import CASES, case_named, limits, one_of_each, twin

EXACT = [case for case in CASES if any(case.exact(t.parameters) for t in case.trials)]


@pytest.mark.parametrize("case", EXACT, ids=lambda case: case.name)
def test_the_limit_of_the_reference_is_the_closed_form(case):
    for trial in one_of_each(case):
        exact = case.exact(trial.parameters)
        values = limits(case, trial.parameters) if exact else {}
        for name, value in exact.items():
            width = 2e-4 * case.quantity(name).size(trial.parameters)
            assert values[name] == pytest.approx(value, abs=width), (trial.setup, name)


@pytest.mark.parametrize("ratio", [0.5, 0.999, 1.0, 1.5, 5.0])
def test_a_clipped_contact_ends_whatever_its_damping(ratio):
    case = case_named("head-on")
    law = {"damping": "damping_ratio", "damping_coefficient": ratio, "clipped": True}
    p = case.default.replace(**law)
    values = limits(case, p, steps=int(800 * max(1.0, ratio) ** 2))
    for name, value in case.exact(p).items():
        assert values[name] == pytest.approx(value, rel=1e-5), name


# ---- friction, rolling, twisting

ROLLS = {
    "rolling": "sds", "rolling_stiffness": 1e3, "rolling_damping": 0.5, "rolling_friction": 0.05,
}  # fmt: skip


@pytest.mark.parametrize(
    ("name", "changes", "exact"),
    [("slip-to-roll", {}, set()), ("incline-roll", {}, set()),
     ("incline-roll", {"angle": 60.0}, {"acceleration_ratio"})],
)  # fmt: skip
def test_rolling_resistance_takes_away_the_closed_forms_that_it_changes(name, changes, exact):
    """The momentum about the floor falls by mu_r g / 2 of the time at most: it must be seen."""
    case = case_named(name)
    parameters = case.default.replace(**changes, **ROLLS)
    integrated = limits(case, parameters)
    assert set(case.exact(parameters)) == exact
    for quantity, value in case.exact(case.default.replace(**changes)).items():
        same = integrated[quantity] == pytest.approx(value, abs=1e-4)
        assert same == (quantity in exact), quantity


def of_dmt(p, overlap):
    """Return force, pull-off force [N] and contact radius [m]."""
    pull = 4.0 * math.pi * p.surface_energy * p.effective_radius
    a = math.sqrt(p.effective_radius * overlap)
    return 4.0 / 3.0 * p.moduli[0] * a * overlap - pull, pull, a


def of_jkr(p, overlap):
    """Return the same, whose radius is searched for between its fold and R*."""
    modulus, radius, gamma = p.moduli[0], p.effective_radius, p.surface_energy

    def excess(a):
        return a * a / radius - 2.0 * math.sqrt(math.pi * gamma * a / modulus) - overlap

    a = brentq(excess, (math.pi * gamma * radius**2 / (4.0 * modulus)) ** (1 / 3), radius)
    pull = 3.0 * math.pi * gamma * radius
    tension = 4.0 * math.sqrt(math.pi * gamma * modulus * a**3)
    return 4.0 / 3.0 * modulus * a**3 / radius - tension, pull, a


def trial_of(name, law, system):
    trials = case_named(name).trials
    return next(t.parameters for t in trials if (t.law, t.system) == (law, system))


@pytest.mark.parametrize(("law", "force_at"), [("mindlin, dmt", of_dmt), ("mindlin, jkr", of_jkr)])
def test_attraction_loads_the_limit_of_friction_and_a_dashpot_does_not(law, force_at):
    case, p = case_named("prescribed-motion"), trial_of("prescribed-motion", law, "wall")
    elastic, pull, a = force_at(p, (1.0 - p.lift) * p.overlap)
    # the dashpot pulls at a sphere that is lifted
    force = elastic - p.damping_coefficient * p.mass * a * p.lift * p.overlap / p.duration
    limit = p.friction * (elastic + 2.0 * pull)
    assert 1.2 * p.friction * force < limit
    assert limits(case, p)["lifted_ratio"] == pytest.approx(limit / force, rel=1e-6)


def test_rolling_holds_its_torque_while_twisting_slides():
    p = trial_of("prescribed-motion", "rolling sds, twisting sds, linear_history", "wall")
    # a twist far enough to slide, wherever the one back has left the spring
    p = p.replace(twisting_friction=2e-5)
    values = limits(case_named("prescribed-motion"), p)
    assert values["twisting_ratio"] == pytest.approx(-p.twisting_friction / p.radius)
    # the dashpot of rolling rests, and so does that of the tangential spring, under its own limit
    load = p.normal_stiffness * (1.0 - p.lift) * p.overlap
    spun = p.radius * p.turn / p.duration
    dashpots = p.rolling_damping + p.tangential_damping * p.damping_coefficient
    rested = values["held_ratio"] - values["rolling_ratio"]
    assert rested == pytest.approx(dashpots * spun / load, rel=1e-6)


@pytest.fixture(scope="module")
def bench():
    return Bench(None)


def test_each_law_is_a_finding_and_is_the_curve_of_partial_slip_where_all_slides(bench):
    case = case_named("oblique")
    rows = run_checks(case.name, list(case.own_checks()), bench)
    assert [row.kind for row in rows] == [Kind.FINDING] * len(oblique.LAWS)
    psi = oblique.INCIDENCES
    expected = partial_slip_rebound(psi, oblique.POISSON)
    # at its limit a slider recovers as the contact opens: a law of the total displacement slides
    # to the end while the rebound is beyond -2/3, one of its increments while it is beyond -1
    slides = 7.0 * stiffness_ratio(oblique.POISSON) - 2.0 / 3.0 < psi
    for law, row in zip(oblique.LAWS, rows, strict=True):
        difference = case.rebounds(law, bench, measured=False) - expected
        assert difference[slides] == pytest.approx(0.0, abs=2e-4)
        assert abs(row.difference) == pytest.approx(np.abs(difference).max())
        assert np.abs(difference).max() < 0.5  # laws are no bounds, but stay within half of mu v


def test_the_curve_of_partial_slip_is_drawn_with_the_codes_that_ran_it(bench, monkeypatch):
    monkeypatch.setattr(ContactCase, "checks_up_to", lambda *_: ())  # of the other impacts
    case, engine = case_named("oblique"), twin()
    of_engine = Bench(engine)
    assert case.drawings({"stand-in": of_engine}) == ()
    check = next(c for c in case.checks(engine) if c.quantity == "rebound_difference")
    (row,) = run_checks(case.name, [check], of_engine)
    assert row.difference == 0.0
    (drawing,) = case.drawings({"stand-in": of_engine, OWN: bench})
    labels = drawing.draw().axes[0].get_legend_handles_labels()[1]
    assert len(labels) == 1 + len(oblique.LAWS) + 1


def sliding(name, **fast):
    """Return the parameters of an impact that slides throughout, and its quantities.

    A dashpot would raise mu F_n from touch on, and the spring follows it.
    """
    case = case_named(name)
    p = case.default.replace(friction=0.1, damping="none", **fast)
    return p, limits(case, p)


def test_sliding_throughout_takes_mu_times_the_normal_impulse():
    p, values = sliding("oblique", angle=80.0)
    along, _, fall = p.velocity
    lost = 0.1 * (1.0 + values["normal_restitution"]) * -fall / along
    found = values["tangential_ratio"], values["rim_speed_ratio"]
    assert found == pytest.approx((1.0 - lost, 2.5 * lost), rel=1e-5)
    p, values = sliding("spin", spin=2000.0)
    lost = 0.1 * (1.0 + values["normal_restitution"]) * p.speed / (p.radius * p.spin)
    found = abs(values["gained_speed_ratio"]), values["spin_ratio"]
    assert found == pytest.approx((lost, 1.0 - 2.5 * lost), rel=1e-5)
