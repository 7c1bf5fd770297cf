"""A coefficient, radius, density or velocity off by a millionth turns a row of its case."""

from fnmatch import fnmatchcase

import pytest

from harness.cases.checks import ROUND_OFF
from harness.cases.contacts.contact_case import motion_difference
from harness.errors import EngineError, RequestError
from harness.model.law import COEFFICIENTS
from harness.solvers import reference
from tests.cases.contacts.common import CASES

OFF = 1.0 + 1e-6
DASHPOTS = {"damping_coefficient", "tangential_damping", "restitution"}
NOTHING_MOVES = [  # case, law, coefficients: where physics says that nothing can move
    ("bounce", "old hertz/history", {"friction"}),  # nothing slips along the normal
    ("head-on", "old hertz/history*", {"friction"}),
    ("*", "mdr*bulk*", {"bulk_share", "yield_stress"}),  # the bulk takes all, from any share on
    ("drag", "*", {"normal_stiffness", "radius"}),  # no contact, and the mass stays
    ("curved-wall", "linear_nohistory", {"friction"}),  # its dashpot never reaches the limit
    # the overlap follows the swing, a thousand times as slow as the contact: 4e-10 of the motion
    ("curved-wall", "hooke, velocity", {"damping_coefficient"}),
    ("incline-rest", "*", {"friction"}),  # it rolls and does not slide
    ("rolling-resistance", "*", {"friction"}),
    ("incline-rest", "*elastic", {"tangential_damping"}),  # a part of no dashpot
    ("rolling-resistance", "*elastic", {"tangential_damping"}),
    ("incline-roll", "*, clipped", {"restitution"}),  # at rest along the normal
    ("slip-to-roll", "*, clipped", {"restitution"}),
    ("prescribed-motion", "*", {"mass"}),  # where no dashpot has m*
    ("pull-off", "*", {"mass"}),
    ("prescribed-motion", "old hooke", {"friction"}),  # they stick
    ("prescribed-motion", "mindlin, coeff_restitution", {"friction"}),
    ("prescribed-motion", "*2/7*", {"friction"}),
    ("prescribed-motion", "linear_nohistory", {"friction"}),
    ("prescribed-motion", "*of Ai", {"rolling_friction"}),
    ("prescribed-motion", "twisting sds, linear_history, *", {"twisting_stiffness"}),  # slides
    ("spin", "rolling sds, linear_history", {"rolling_damping", "rolling_stiffness"}),  # slides
    # it turns about the normal: nothing slips
    ("twist", "*", {"friction", "tangential_stiffness", *DASHPOTS}),
]


def expected_misses(case, law):
    """Return the coefficients of a law that need not turn a row of a case."""
    rows = [row for row in NOTHING_MOVES if fnmatchcase(case, row[0]) and fnmatchcase(law, row[1])]
    return {name for *_, names in rows for name in names}


def changes(scene):
    """Yield scenes with a coefficient, radius, mass, velocity or spin off by 1e-6, by name."""
    for name in sorted(COEFFICIENTS):
        if value := getattr(scene.law, name):
            off = {name: value * (2.0 - OFF if name in ("bulk_share", "restitution") else OFF)}
            yield name, lambda off=off: scene.replace(law=scene.law.replace(**off))
    first, *rest = scene.bodies
    bodies = {"radius": first.radius * OFF, "mass": first.mass * OFF}
    for name in ("velocity", "angular_velocity"):
        if any(value := getattr(first, name)) and not scene.segments:
            bodies[name] = tuple(x * OFF for x in value)
    for name, value in bodies.items():
        off = {name: value}
        yield name, lambda off=off: scene.replace(bodies=(first.replace(**off), *rest))


def turned(case, trial, plain, changed):
    """Return whether a row of a trial fails with a changed scene."""
    p = trial.parameters
    try:
        motion = reference.run(changed())
        if motion_difference(trial.scene, motion, plain) > ROUND_OFF:
            return True
        values = p.observe(motion)
    except (EngineError, RequestError, ValueError):
        return True
    expected = p.observe(plain)
    return any(
        not abs(values[name] - expected[name]) <= ROUND_OFF * case.quantity(name).size(p)
        for name in case.names(p)
    )


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_what_is_off_by_a_millionth_turns_a_row_of_each_law(case):
    """In one of the systems of the law, at some level."""
    by_law = {}  # whether a row turned, by name
    for trial in case.trials:
        seen, still = by_law.setdefault(trial.law, {}), expected_misses(case.name, trial.law)
        left = {n: c for n, c in changes(trial.scene) if n not in still and not seen.get(n)}
        if left:
            plain = reference.run(trial.scene)
            seen |= {name: turned(case, trial, plain, changed) for name, changed in left.items()}
    missed = {law: [name for name in seen if not seen[name]] for law, seen in by_law.items()}
    assert not {law: names for law, names in missed.items() if names}
