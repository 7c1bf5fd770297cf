"""The registry: names without imports, groups, and plug-ins with one line for each fault."""

import subprocess
import sys
from importlib.metadata import EntryPoint

import pytest

from harness.cases import registry
from harness.errors import RequestError
from tests.workflows import doubles
from tests.workflows.conftest import registered  # noqa: F401

HERE = "tests.workflows.doubles"


class Distribution:
    def __init__(self, name):
        self.name = name


def point(name, value, package="lib"):
    entry = EntryPoint(name, value, registry.ENTRY_POINT)
    vars(entry)["dist"] = Distribution(package)
    return entry


@pytest.fixture
def installed(monkeypatch):
    """Return a function that installs entry points."""

    def install(*points):
        monkeypatch.setattr(registry, "entry_points", lambda **_: list(points))
        registry._plugins.cache_clear()

    yield install
    registry._plugins.cache_clear()


def test_names_are_listed_without_an_import_of_a_case():
    code = (
        "import sys; from harness.cases.registry import *; names = case_names(); "
        "print(len(names), *[m for m in sys.modules if m.startswith('harness.cases.')])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    count, *modules = done.stdout.split()
    assert int(count) >= 28
    assert set(modules) <= {f"harness.cases.{n}" for n in ("base", "bench", "registry")}


@pytest.mark.usefixtures("registered")
def test_names_groups_and_all():
    assert registry.selected_names() == ["bounce"]
    assert registry.selected_names("others,bounce") == ["wrong", "bounce"]
    assert registry.selected_names("all") == ["bounce", "wrong"]
    assert registry.get_case("bounce") is doubles.CASE


@pytest.mark.usefixtures("registered")
def test_a_case_of_another_package_is_a_case(installed):
    installed(point("wrong2", f"{HERE}:WRONG"), point("bounce2", f"{HERE}:BOUNCE2"))
    assert registry.get_case("bounce2").name == "bounce2"
    assert "bounce2" in registry.selected_names("all")
    assert registry.selected_names("balls") == ["bounce", "bounce2"]


@pytest.mark.usefixtures("registered")
@pytest.mark.parametrize(
    ("name", "value", "words"),
    [
        ("mine", "nowhere:CASE", "nowhere:CASE does not import: ModuleNotFoundError"),
        ("mine", f"{HERE}:K", "is a float, must be an instance of harness.cases.base.Case"),
        ("mine", f"{HERE}:CASE", "has the name 'bounce', must be the same"),
        ("bounce", f"{HERE}:CASE", "package 'dem-harness' has a case of this name"),
    ],
)
def test_a_fault_of_a_plug_in_is_one_line_with_package_and_case(installed, name, value, words):
    installed(point(name, value))
    (fault,) = registry.plugin_faults()
    assert fault.startswith(f"package 'lib', case '{name}': ")
    assert words in fault
    assert "\n" not in fault
    assert name == "bounce" or name not in registry.usable_cases()
    if name != "bounce":
        with pytest.raises(RequestError, match="package 'lib'"):
            registry.get_case(name)


@pytest.mark.usefixtures("registered")
def test_of_two_packages_with_a_case_of_one_name_the_first_is_taken(installed):
    installed(point("bounce2", f"{HERE}:BOUNCE2", "b"), point("bounce2", f"{HERE}:BOUNCE2", "a"))
    (fault,) = registry.plugin_faults()
    assert fault.startswith("package 'b', case 'bounce2': ")
    assert fault.endswith("package 'a' has a case of this name")


@pytest.mark.parametrize(
    ("call", "member", "words"),
    [
        (
            "measure",
            lambda *_: {}["height"],
            r"measure raised KeyError: 'height' \(test_registry.py,",
        ),
        ("measure", lambda *_: {"time_s": "1"}, "measure returned a dict, must return numbers by"),
        ("exact", lambda *_: None, "exact returned a NoneType, must return numbers by the names"),
        ("job", lambda *_: {}, "job returned a dict, must return a Job"),
    ],
)
def test_a_flaw_of_a_call_is_one_line_with_package_case_and_call(call, member, words):
    kind = type("Mine", (doubles.BounceCase,), {call: member, "__module__": __name__})
    arguments = [None] * (2 if call == "measure" else 1)
    with pytest.raises(RequestError, match=f"^package 'tests', case 'bounce': {words}") as caught:
        getattr(kind(), call)(*arguments)
    assert "\n" not in str(caught.value)
