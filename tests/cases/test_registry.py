"""The registry, plug-ins with one line for each fault, and digests of the input of a bench."""

import subprocess
import sys
from importlib.metadata import EntryPoint
from itertools import compress
from types import SimpleNamespace

import pytest

from harness.cases import registry
from harness.cases.bench import Bench
from harness.cases.registry import usable_cases
from harness.engines.base import scene_job
from harness.engines.registry import open_engine
from harness.errors import BrokenCaseError, RequestError
from harness.results.compare import differ
from harness.results.rows import KEY
from harness.store.committed import accepted_rows
from tests.cases.test_defects import SLIDING, Code
from tests.workflows import doubles
from tests.workflows.conftest import registered  # noqa: F401

HERE = "tests.workflows.doubles"


def point(name, value, package="lib"):
    entry = EntryPoint(name, value, registry.ENTRY_POINT)
    vars(entry)["dist"] = SimpleNamespace(name=package)
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
    assert registry.hidden_cases() == ({"lib:bounce": fault} if name == "bounce" else {})
    assert name == "bounce" or name not in registry.usable_cases()
    if name != "bounce":
        with pytest.raises(BrokenCaseError, match="package 'lib'"):
            registry.get_case(name)


@pytest.mark.usefixtures("registered")
def test_of_two_packages_with_a_case_of_one_name_the_first_is_taken(installed):
    installed(point("bounce2", f"{HERE}:BOUNCE2", "b"), point("bounce2", f"{HERE}:BOUNCE2", "a"))
    (fault,) = registry.plugin_faults()
    assert fault.startswith("package 'b', case 'bounce2': ")
    assert fault.endswith("package 'a' has a case of this name")
    assert registry.hidden_cases() == {"b:bounce2": fault}


@pytest.mark.parametrize(
    ("call", "member", "words"),
    [
        ("measure", lambda *_: {}["height"], "raised KeyError: 'height' .test_registry.py,"),
        ("measure", lambda *_: {"time_s": "1"}, "returned a dict, must return numbers by"),
        ("exact", lambda *_: None, "returned a NoneType, must return numbers by the names"),
        ("job", lambda *_: {}, "returned a dict, must return a Job"),
    ],
)
def test_a_flaw_of_a_call_is_one_line_with_package_case_and_call(call, member, words):
    kind = type("Mine", (doubles.BounceCase,), {call: member, "__module__": __name__})
    arguments = [None] * (2 if call == "measure" else 1)
    line = f"^package 'tests', case 'bounce': {call} {words}"
    with pytest.raises(RequestError, match=line) as caught:
        getattr(kind(), call)(*arguments)
    assert "\n" not in str(caught.value)


# ---- digests of the input


@pytest.mark.parametrize(("error", "other"), [(1e-15, False), (-1e-11, False), (1e-7, True)])
def test_the_rounding_of_another_cpu_is_the_same_input(error, other):
    """A step follows from an integration, whose last digits depend on the CPU and on scipy."""
    jobs = [scene_job(SLIDING.replace(step=SLIDING.step * (1.0 + e))) for e in (0.0, error)]
    one, two = ([Bench(Code()).inputs_digest([job])] for job in jobs)
    assert list(differ(one, two)) == [other]


@pytest.mark.parametrize("name", ["penetration", "drum"])
def test_published_beds_are_the_same_input_for_each_user(name, tmp_path, monkeypatch):
    """The bed lies in a file in the cache of a user."""
    case, digests = usable_cases()[name], set()
    for home in ("one", "another one"):
        monkeypatch.setenv("DEM_HARNESS_HOME", str(tmp_path / home))
        digests.add(Bench(Code()).inputs_digest([case.job(case.presets["published"])]))
    assert len(digests) == 1


def test_the_accepted_run_had_the_input_of_the_checks_on_any_machine(lammps_here):  # noqa: ARG001
    """Nothing runs: other input is no change of the engine, and fails every verification."""
    with open_engine("lammps") as engine:
        accepted = accepted_rows({engine.name: engine.identify().engine_version})
        expected = dict(zip(accepted[list(KEY)].itertuples(index=False, name=None),
                            accepted["inputs"], strict=True))  # fmt: skip
        bench, pairs = Bench(engine), {}
        for case in usable_cases().values():
            for check in case.checks_up_to(engine, "quick"):
                key = (case.name, check.setup, check.quantity, engine.name, check.check)
                if key in expected:
                    pairs[key] = expected[key], bench.inputs_digest(check.jobs)
    assert [*compress(pairs, differ(*zip(*pairs.values(), strict=True)))] == []
    assert len(pairs) > len([text for text in expected.values() if text]) - len(accepted) / 2
