"""The formulas are those that the source prints: values worked out by hand from its lines."""

import math

import numpy as np
import pytest

from harness.reproduction.claims import SOURCES

X = np.array([0.0, 0.9, 1.85, 2.8])


def of_chain(n, **numbers):
    return {"x": X[:n], "n": n, "i": np.arange(1, n + 1), "r_0": 0.5, **numbers}


BY_HAND = [
    ("eq-1", {"k": 6.0, "n": 3}, 2.0),
    ("table-1-well", {"theta": 30.0}, 0.0),
    ("table-1-gain", {"theta": 30.0}, 0.5),
    ("table-1-first-shock", {"E_0": 1.0, "dE": 0.5, "shock": 0.25}, 0.375),
    # E_0 E^3 + dE E (E^2 + E^2 + 1)
    ("eq-2", {"n": 3, "E_0": 8.0, "dE": 1.0, "shock": 0.5}, 1.0 + 0.5 * 1.5),
    # E_0 E^5 + dE E (E^4 + E^4 + E^2 + E + 1)
    ("eq-2", {"n": 5, "E_0": 32.0, "dE": 1.0, "shock": 0.5}, 1.0 + 0.5 * 1.875),
    ("eq-3", {"x": 0.5, "n": 2}, 1.75),
    ("eq-3-index", {"x": 0.5, "n": 2}, 1.75),
    ("eq-4", {"n": 2, "E_1": 1.0, "dE": 1.0, "shock": 0.5}, 0.5 + 0.5 * 0.5 / 0.5),
    ("eq-5", {"dE": 3.0, "shock": 0.25}, 1.0),
    ("eq-6", {"theta": 30.0, "shock": 0.25, "divisor": 2.0}, 1 / 3),
    ("eq-7", {"before": 4.0, "after": 1.0}, 0.5625),
    ("eq-8", {"before": 2.0, "e": 1.0}, 2.0),
    ("eq-9", {"e": 0.0}, 0.25),
    ("eq-10", {"k": 1e5, "P": 10.0}, 1e4),
    ("eq-12", {"k": 4.0, "m": 1.0, "gamma": 0.0, "factor": 1.0}, math.pi / 2),
    ("eq-12", {"k": 5.0, "m": 1.0, "gamma": 1.0, "factor": 1.0}, math.pi / 2),
    ("text-effective-mass", {"m_1": 2.0, "m_2": 2.0}, 1.0),
    ("eq-13", {"v_0": 1.0, "v_s": 0.5, "alpha": 0.5}, 0.5625),
    ("eq-13-direction", {"alpha": 0.5}, 0.5625),
    ("eq-14", {"k": 3.0, "dx": 2.0}, 6.0),
    ("eq-pair-distance", {"r_0": 0.5, "dx": 0.2}, 0.8),
    ("eq-15", {"k": 10.0, "m": 2.0, "r_0": 0.5, "x_1": 0.0, "x_2": 0.9, "sign": 1.0}, 0.5),
    ("eq-16", of_chain(2), (0.5 - 0.9) / 2),
    ("eq-16", of_chain(3), (-0.5 - 3 * 0.9 + 1.85) / 3),
    ("eq-17", {"x": 0.9, "b": 0.45}, 1.35),
    ("eq-series-force", {"k": 3.0, "c": 0.2}, 1.0),
    ("eq-u-1", {"k": 3.0, "c": 2.0}, 6.0),
    ("eq-u-2", {"k": 3.0, "c": 0.3}, 0.09),
    ("text-u-n", {"n": 3}, 3),
    ("text-u-n-particles", {"n": 3}, 3),
    ("eq-18", {"k": 10.0, "n": 3, "c_n": 0.2}, 3.0),
    ("eq-a1", {"x": 0.9, "b": 0.45}, 1.35),
    ("eq-a2", of_chain(2, b_0=0.1), -1.8 + 0.2),
    ("eq-chain-length", of_chain(3, b_0=0.1), 3.7 - 1.8 - 0.2),
    ("eq-a3", {"x": 0.9, "b": 0.45, "r_0": 0.5}, 0.1),
    ("eq-a6", {"dx": np.array([0.5, 0.4, 0.1]), "i": np.arange(3)}, 0.5 - (0.4 - 0.1)),
    ("eq-four", of_chain(4), (-2.8 + 3 * 1.85 - 5 * 0.9) / 4),
    ("eq-a8", {"r_0": 0.5, "dx": 0.2}, 0.8),
    ("beyond-4", {"n": 3}, 6),
]


def test_values():
    for key, numbers, expected in BY_HAND:
        assert SOURCES[key].printed(**numbers) == pytest.approx(expected, abs=1e-15), key


def test_every_formula_is_worked_out_by_hand():
    elsewhere = {"eq-11", "eq-four-inserted"}  # test_methods, and below
    with_formula = {key for key, source in SOURCES.items() if source.formula}
    assert with_formula == {key for key, _, _ in BY_HAND} | elsewhere


def test_line_of_the_example_is_right_for_one_b_0_less():
    """With - b_0 for - 2b_0 the printed line has the root that the next line prints."""
    first = SOURCES["eq-four"].printed(**of_chain(4))
    line = SOURCES["eq-four-inserted"].printed(**of_chain(4, b_0=first))
    assert line == pytest.approx(first, abs=1e-15)
