"""A coefficient, radius, density or velocity off by a millionth turns a row of its case."""

import pytest

from harness.errors import EngineError, RequestError
from harness.model.law import COEFFICIENTS
from harness.solvers import reference
from tests.cases.contacts.common import CASES

OFF = 1.0 + 1e-6
NOTHING_MOVES = {  # by case: where physics says that nothing can move
    "drag": {"normal_stiffness", "radius"},  # no contact, and the mass stays
    # two held spheres conduct by the radius of the circle that overlap and R* make
    "heat": {"normal_stiffness", "youngs_modulus", "poisson_ratio", "velocity"},
    "pull-off": {"mass"},  # forces of a prescribed motion
    "prescribed-motion": {"mass"} if False else set(),
}


def changes(scene):
    """Yield scenes with a coefficient, radius, mass, velocity or spin off by 1e-6, by name."""
    for name in sorted(COEFFICIENTS):
        if value := getattr(scene.law, name):
            factor = 2.0 - OFF if name in ("bulk_share", "restitution") else OFF
            yield name, lambda n=name, v=value * factor: scene.replace(
                law=scene.law.replace(**{n: v})
            )
    first, *rest = scene.bodies
    for name in ("radius", "mass"):
        other = {name: getattr(first, name) * OFF}
        yield name, lambda o=other: scene.replace(bodies=(first.replace(**o), *rest))
    for name in ("velocity", "angular_velocity"):
        if any(value := getattr(first, name)) and not scene.segments:
            other = {name: tuple(x * OFF for x in value)}
            yield name, lambda o=other: scene.replace(bodies=(first.replace(**o), *rest))


def turned(case, trial, changed):
    """Return whether a row of a trial fails with a changed scene."""
    p = trial.parameters
    expected = case.observe(p, reference.run(case.scene(p)))
    try:
        found = case.observe(p, reference.run(changed()))
    except (EngineError, RequestError, ValueError):
        return True
    return any(
        not abs(found[name] - expected[name])
        <= case.tolerance(p, case.quantity(name)).width(expected[name])
        for name in case.names(p)
    )


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_what_is_off_by_a_millionth_turns_a_row_of_each_law(case):
    """In one of the systems of the law, at some level."""
    unseen = {}
    laws = {}
    for trial in case.trials():
        laws.setdefault(trial.law, []).append(trial)
    for law, trials in laws.items():
        left = {}
        for trial in trials:
            for name, changed in changes(case.scene(trial.parameters)):
                if left.get(name, True) and turned(case, trial, changed):
                    left[name] = False
                left.setdefault(name, True)
        missed = {name for name, unturned in left.items() if unturned}
        if missed - NOTHING_MOVES.get(case.name, set()):
            unseen[law] = sorted(missed)
    assert not unseen
