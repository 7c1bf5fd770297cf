"""Closed forms of the contact cases, held against the independent integration of the law."""

import pytest

from harness.cases.contact_base.reference import followed
from harness.cases.contact_base.submodels import NORMAL, OLD_NORMAL, SYSTEMS
from harness.cases.registry import get_case
from harness.parameters.contact_rules import Rules

HEAD_ON = get_case("head-on")


@pytest.mark.parametrize("system", SYSTEMS)
@pytest.mark.parametrize("submodel", [*NORMAL, *OLD_NORMAL], ids=lambda one: one.name)
def test_head_on(submodel, system):
    parameters = HEAD_ON.default.replace(**submodel.law, **SYSTEMS[system])
    exact = HEAD_ON.closed_forms(parameters)
    path = followed(HEAD_ON.scene(parameters), Rules()).motion
    integrated = HEAD_ON.observed(parameters, path)
    for name, value in exact.items():
        assert integrated[name] == pytest.approx(value, rel=2e-8), name
    if "hooke" in submodel.name and "viscoelastic" not in submodel.name:
        assert exact
