"""Mindlin's laws beside partial slip: alike where all slides, apart where a part sticks."""

import numpy as np
import pytest

from harness.cases.oblique import INCIDENCES, LAWS, POISSON
from harness.cases.registry import get_case
from harness.cases.verification import Study
from harness.comparison.verdicts import Kind
from harness.comparison.verification import Findings
from harness.theory.contact import partial_slip_rebound, stiffness_ratio


def test_each_law_is_a_finding_and_is_the_curve_where_all_slides():
    case = get_case("oblique")
    found = case.verification.run_solvers(Study("default"))
    assert [check.kind for check in found.checks] == [Kind.FINDING] * len(LAWS)
    expected = partial_slip_rebound(INCIDENCES, POISSON)
    # at its limit a slider recovers as the contact opens: a law of the total displacement slides
    # to the end while the rebound is beyond -2/3, one of its increments while it is beyond -1
    slides = 7.0 * stiffness_ratio(POISSON) - 2.0 / 3.0 < INCIDENCES
    assert slides.any()
    for law, check in zip(LAWS, found.checks, strict=True):
        apart = found.evidence[law] - expected
        assert apart[slides] == pytest.approx(0.0, abs=2e-4)
        assert abs(check.difference) == pytest.approx(np.abs(apart).max())
        # the laws are no bounds, but stay within half of mu v
        assert np.abs(apart).max() < 0.5
    assert case.display.sections(None, found, {}) == []


def test_the_shortest_level_leaves_it_out():
    assert get_case("oblique").verification.run_solvers(Study("quick")) == Findings("oblique")
