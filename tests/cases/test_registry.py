"""Cases are found by folder and by entry point; a bad plug-in touches nothing else."""

import subprocess
import sys
from collections import defaultdict
from importlib.metadata import EntryPoint

import pytest

from harness.cases import registry
from harness.cases.contract import Case
from harness.cases.drop.case import TEMPLATE, Drop
from harness.cases.incline.case import InclineCase
from harness.cli.cases import cases
from harness.errors import RequestError
from harness.observables.provenance import Observable


class Ball(Case):
    name, group, summary = "ball", "contacts", "A ball."
    parameters = Drop
    quantities = (Observable("height_m", "m", "", "of the bounce"),)
    template = TEMPLATE

    def job(self, parameters):
        raise NotImplementedError

    def read(self, parameters, output, traits):
        raise NotImplementedError


class Unitless(Ball):
    name = "unitless"
    quantities = (Observable("height", "", "", "of the bounce"),)


class Unverified(Ball):
    name = "unverified"
    verified_by = "tests.cases.test_registry:BallVerification"


GOOD, UNITLESS, UNVERIFIED, NONE = Ball(), Unitless(), Unverified(), object()


def point(name, value):
    return EntryPoint(name, value, registry.GROUP)


HERE = "tests.cases.test_registry"
POINTS = [
    point("ball", f"{HERE}:GOOD"),
    point("unitless", f"{HERE}:UNITLESS"),
    point("unverified", f"{HERE}:UNVERIFIED"),
    point("nothing", f"{HERE}:NONE"),
    point("broken", "no_such_package.case:CASE"),
    point("incline", "another_package.case:CASE"),
    point("misnamed", f"{HERE}:GOOD"),
]


@pytest.fixture
def plugged(monkeypatch):
    monkeypatch.setattr(registry, "entry_points", lambda **_: POINTS)


def test_the_folders_are_the_cases():
    assert {"drop", "incline"} <= set(registry.built_in())
    assert isinstance(registry.get_case("incline"), InclineCase)
    assert all(case.name == name for name, case in registry.all_cases().items())
    assert registry.faults() == ()


def test_names_and_quantities_of_cases_import_no_numerics():
    code = (
        "import sys; from harness.workflows.verification import Selection;"
        "assert Selection('tower,oblique').names('default') == ('tower', 'oblique');"
        "assert not {name for name in sys.modules if name.startswith('harness.cases.incline')};"
        "from harness.cases.registry import get_case;"
        "[get_case(name).quantities for name in ('drop', 'incline')];"
        "assert not {'numba', 'scipy', 'matplotlib', 'pandas'} & set(sys.modules)"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


def test_a_case_of_another_package_is_one_like_the_others(plugged):  # noqa: ARG001
    assert registry.get_case("ball") is GOOD
    assert "ball" in registry.case_names()
    assert "ball" in registry.all_cases()
    assert isinstance(registry.get_case("incline"), InclineCase)


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("unitless", "quantity 'height' has no unit"),
        ("unverified", "verified_by = 'tests.cases.test_registry:BallVerification': .*has no attr"),
        ("nothing", "is no case but object"),
        ("broken", "does not import: ModuleNotFoundError"),
        ("misnamed", "its case has the name 'ball'"),
    ],
)
def test_a_case_that_cannot_be_used_is_named_in_one_line_with_its_package(plugged, name, words):  # noqa: ARG001
    with pytest.raises(RequestError, match=words) as told:
        registry.get_case(name)
    assert "\n" not in str(told.value)
    assert str(told.value).startswith("package '")
    assert str(told.value) in registry.faults()


def test_a_case_cannot_take_the_name_of_one_of_ours(plugged):  # noqa: ARG001
    (fault,) = [line for line in registry.faults() if "'another_package.case'" in line]
    assert "name of a case of dem-harness itself" in fault
    assert set(registry.all_cases()) - {"ball"} == set(registry.built_in())


def test_cases_are_chosen_by_name_group_or_all():
    assert set(registry.cases_named("drop, incline")) == {"drop", "incline"}
    assert list(registry.cases_named("drop,incline,drop")) == ["drop", "incline"]
    assert "drop" in registry.cases_named("contacts")
    assert "incline" not in registry.cases_named("contacts")
    assert set(registry.cases_named("all")) == set(registry.all_cases())
    assert "incline" in registry.cases_named("")
    assert "drop" not in registry.cases_named("")
    assert {"drop", "incline"} <= set(registry.cases_named("contacts,incline"))


@pytest.mark.parametrize("text", ["nobody", "incline,nobody", "all,nobody"])
def test_a_word_that_is_neither_name_nor_group_is_refused_with_those_that_are(text):
    with pytest.raises(RequestError, match=r"--cases 'nobody' is not known: must be all, a group"):
        registry.cases_named(text)


def test_a_text_without_a_name_and_an_unknown_case_are_refused():
    with pytest.raises(RequestError, match="names no case"):
        registry.cases_named(", ")
    with pytest.raises(RequestError, match="case 'nobody' is not known: must be one of"):
        registry.get_case("nobody")


def test_the_list_of_cases_names_those_that_cannot_be_used(plugged, capsys):  # noqa: ARG001
    cases(json=True)
    told = capsys.readouterr().err.splitlines()
    assert told == [f"dem-harness: {fault}" for fault in registry.faults()]
    assert len(told) == 6


def test_the_name_of_a_quantity_has_one_unit_and_one_meaning_over_all_cases():
    declared = defaultdict(set)
    for quantity in (
        one for case in map(registry.get_case, registry.built_in()) for one in case.quantities
    ):
        assert "" not in (quantity.unit, quantity.meaning)
        declared[quantity.name].add((quantity.unit, quantity.shape, quantity.meaning))
    assert {name for name, meanings in declared.items() if len(meanings) > 1} == set()
