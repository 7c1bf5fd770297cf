"""Another machine rounds differently: what is recorded must be the same on it."""

import numpy as np
import pytest

from harness.reproduction import claims
from harness.solvers.chain import forces
from tests.reproduction.ledger.test_perturbed import as_it_is, module_of, section

SECTIONS = (
    "introduction", "background_energy", "methods_scales", "methods_pair",
    "methods_chain", "discussion", "appendix_chains", "beyond",
)  # fmt: skip


def records(ledger):
    return [{k: str(v) for k, v in row.to_json().items()} for row in ledger.statements]


def rounded_differently(compare, seed):
    """Return ``compare`` for numbers that are off by a few units in the last place."""
    random = np.random.default_rng(seed)

    def perturbed(source, *, found, printed=None, corrected=None, **others):
        def off(values):
            shape = np.shape(values)
            return values * (1 + 1e-15 * random.uniform(-1, 1, shape)) + np.where(
                np.asarray(values) == 0, 3e-17 * random.uniform(-1, 1, shape), 0.0
            )

        named = claims.named_source(source)
        printed = named.printed(**others) if printed is None else printed
        corrected = named.corrected(**others) if corrected is None else corrected
        printed, found, corrected = (np.asarray(v, float) for v in (printed, found, corrected))
        stated = off(printed) if printed.ndim else printed  # a number that is printed is exact
        given = {"printed": stated, "found": off(found), "corrected": off(corrected)}
        return compare(named, **given, **others)

    return perturbed


@pytest.mark.parametrize("seed", [0, *(pytest.param(n, marks=pytest.mark.slow) for n in (1, 2))])
@pytest.mark.parametrize("name", SECTIONS)
def test_round_off_changes_no_record(monkeypatch, name, seed):
    before = records(as_it_is(name))
    module = module_of(name)
    if hasattr(module, "compare"):
        monkeypatch.setattr(module, "compare", rounded_differently(claims.compare, seed))
    assert records(section(name)) == before


def test_compressions_that_round_differently_are_recorded_alike(monkeypatch):
    """Equations A4 and A5 used to show the sample with the largest round-off."""
    before = records(as_it_is("appendix_chains"))
    random, recovered = np.random.default_rng(1), forces.compressions

    def perturbed(centres, diameter):
        found = recovered(centres, diameter)
        return found + 1e-15 * random.uniform(-1, 1, found.shape)

    monkeypatch.setattr(forces, "compressions", perturbed)
    assert records(section("appendix_chains")) == before
