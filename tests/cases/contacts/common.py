"""The contact cases, and the limit of small steps of their quantities."""

from harness.cases.registry import GROUPS, get_case
from harness.model.conventions import Rules
from harness.solvers import reference
from tests.engine_doubles import Twin

NAMES = [
    name for name, home in GROUPS["contacts"].items() if home.startswith("harness.cases.contacts")
]
STEPS = 800  # of a contact, of the coarser run of a limit
case_named = get_case
CASES = [get_case(name) for name in NAMES]


def limits(case, parameters, rules=None, steps=STEPS):
    """Return 2 y(h/2) - y(h) of each quantity, with h a so many-th of a contact."""
    coarse, fine = (
        p.observe(reference.run(case.scene(p), rules or Rules()))
        for p in (parameters.replace(steps_per_contact=n) for n in (steps, 2 * steps))
    )
    return {name: 2.0 * fine[name] - coarse[name] for name in coarse}


def one_of_each(case):
    """Return trials in which each law and each system occurs, of level quick where there are."""
    trials = sorted(case.trials, key=lambda trial: trial.level != "quick")
    chosen = {}
    for trial in trials:
        if trial.law not in chosen or trial.system not in chosen:
            chosen |= {trial.law: trial, trial.system: trial}
    return list({id(trial): trial for trial in chosen.values()}.values())


def twin(*changes, declared=None, **more):
    """Return the reference as an engine of the plain conventions, with faults."""
    return Twin(*changes, declared=declared or Rules(), **more)
