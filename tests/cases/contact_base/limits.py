"""The limit of small steps of a case's quantities, by the reference."""

from typing import NamedTuple

from harness.model.conventions import Rules
from harness.solvers import reference

STEPS = 800


class Limit(NamedTuple):
    value: float


def limits(case, parameters, rules=None, steps=STEPS):
    """Return 2 y(h/2) - y(h) of each quantity, with h a so many-th of a contact."""
    coarse, fine = (
        case.observed(p, reference.run(case.setup(p), rules or Rules()))
        for p in (parameters.replace(steps_per_contact=n) for n in (steps, 2 * steps))
    )
    return {name: Limit(2.0 * fine[name] - coarse[name]) for name in coarse if name in fine}
