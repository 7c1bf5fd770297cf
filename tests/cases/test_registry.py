"""Cases are found by folder and by entry point; a bad plug-in touches nothing else."""

import csv
import subprocess
import sys
from collections import defaultdict
from importlib import import_module
from importlib.metadata import EntryPoint
from pathlib import Path

import pytest

from harness.cases import contract, registry
from harness.cases.contract import Case
from harness.cases.display import Display
from harness.cases.drop.case import TEMPLATE, Drop
from harness.cases.incline.case import InclineCase
from harness.cases.verification import Verification
from harness.cli.cases import cases
from harness.errors import RequestError
from harness.observables.provenance import Observable

BASELINE = Path(__file__).parents[2] / "reports" / "baseline"


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


def test_what_verifies_and_shows_a_case_is_there():
    for case in registry.all_cases().values():
        assert isinstance(case.verification, Verification)
        assert isinstance(case.display, Display)
        assert case.verification.case is case.display.case is case


def test_listing_names_imports_no_numerics():
    code = (
        "import sys; from harness.cases.registry import case_names; names = case_names();"
        "assert 'incline' in names;"
        "assert not {'numba', 'scipy', 'matplotlib', 'pandas'} & set(sys.modules)"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


def test_a_kept_verification_is_known_by_names_that_import_no_case():
    code = (
        "import sys; from harness.workflows.verification import Selection;"
        "assert Selection(None).names('default') == ('incline', 'tower');"
        "assert Selection('tower,oblique').names('default') == ('tower', 'oblique');"
        "assert not {'numba', 'scipy', 'matplotlib', 'pandas'} & set(sys.modules);"
        "assert not {name for name in sys.modules if name.startswith('harness.cases.incline')}"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


def test_asking_a_case_for_its_quantities_imports_neither_numba_nor_scipy():
    code = (
        "import sys; from harness.cases.registry import get_case;"
        "[get_case(name).quantities for name in ('drop', 'incline')];"
        "assert not {'numba', 'scipy', 'matplotlib', 'pandas'} & set(sys.modules), "
        "{'numba', 'scipy', 'matplotlib', 'pandas'} & set(sys.modules)"
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


def ambiguous(cases):
    """Return the names of quantities that have another unit or meaning in another case."""
    declared = defaultdict(set)
    for case in cases:
        for quantity in case.quantities:
            declared[quantity.name].add((quantity.unit, quantity.shape, quantity.meaning))
    return {name for name, meanings in declared.items() if len(meanings) > 1}


def test_the_name_of_a_quantity_has_one_unit_and_one_meaning_over_all_cases():
    cases = [registry.get_case(name) for name in registry.built_in()]
    assert ambiguous(cases) == set()
    assert all(quantity.unit and quantity.meaning for case in cases for quantity in case.quantities)


@pytest.mark.parametrize(
    ("unit", "meaning"), [("m", "largest overlap of the samples"), ("1", ""), ("mm", "")]
)
def test_a_name_with_another_unit_or_meaning_is_found(unit, meaning):
    head_on = registry.get_case("head-on")
    (ours,) = [one for one in head_on.quantities if one.name == "largest_overlap_m"]

    class Other(Ball):
        quantities = (Observable(ours.name, unit, "", meaning or ours.meaning),)

    assert ambiguous([head_on, Other()]) == {"largest_overlap_m"}
    Other.quantities = (ours,)
    assert ambiguous([head_on, Other()]) == set()


def test_a_name_in_the_baseline_has_the_unit_that_its_case_declares():
    """Records also have names that no case declares; in those a name has one case."""
    declared = {
        (name, one.name): one.unit.removeprefix("1")
        for name, case in registry.all_cases().items()
        for one in case.quantities
    }
    units, undeclared = defaultdict(set), defaultdict(set)
    for path in (one for one in BASELINE.glob("*.csv") if ".series" not in one.name):
        with path.open(encoding="utf-8", newline="") as file:
            for row in csv.DictReader(file):
                case, name = row["case"], row["quantity"]
                units[name].add(row["unit"])
                if (case, name) not in declared:
                    undeclared[name].add(case)
                assert declared.get((case, name), row["unit"]) == row["unit"], (path.name, name)
    assert {name: found for name, found in units.items() if len(found) > 1} == {}
    assert {name: found for name, found in undeclared.items() if len(found) > 1} == {}
    assert units["largest_overlap_m"] == {"m"}


@pytest.mark.parametrize(
    ("member", "place"),
    [
        ("expected_rows", "`planned` of the verification"),
        ("verify_beside", "`study.role`"),
        ("by_default", "unless others are named"),
        ("verify", "`run`, a member of the class that `verified_by` names"),
        ("planned", "`verified_by`"),
        ("regression", "TOML file"),
        ("sections", "`shown_by`"),
    ],
)
def test_a_case_with_a_member_of_an_earlier_version_is_refused_by_name_and_place(member, place):
    with pytest.raises(TypeError, match=rf"Old\.{member}: is not called any more: .*{place}"):
        type("Old", (InclineCase,), {member: None})


def test_what_lay_in_the_contract_is_found_there_still():
    """By packages that were written for it."""
    for module, names in contract._MOVED.items():
        for name in names:
            assert getattr(contract, name) is getattr(import_module(module), name)
    with pytest.raises(AttributeError, match="'nothing'"):
        _ = contract.nothing
