"""The generated script of a case: its variables, at full precision, and the committed text."""

from hypothesis import given
from hypothesis import strategies as st

from harness.cases.drop import TEMPLATE, Drop, values_of
from harness.engines.lammps.engine import Lammps

SCRIPT = Lammps.script(TEMPLATE)
TEXT = "\n".join(li for li in SCRIPT.text.splitlines() if li and not li.startswith("#"))


def texts(case):
    """Return what reaches LAMMPS of a case."""
    return {name: Lammps.literal(value) for name, value in values_of(case).items()}


def test_the_committed_input_is_generated(inputs):
    assert (inputs / SCRIPT.name).read_text(encoding="utf-8") == SCRIPT.text


@given(st.floats(0.0, 1e-2), st.floats(1e5, 1e12))
def test_numbers_reach_lammps_at_full_precision(gap, stiffness):
    variables = texts(Drop(gap=gap, stiffness=stiffness))
    assert float(variables["gap"]) == gap
    assert float(variables["stiffness"]) == stiffness
    assert " " not in "".join(variables.values())
