"""``harness.workflows`` gives functions: never a module, all of them by Tab, each with its help."""

import inspect
import pkgutil
import subprocess
import sys

import pytest

from harness import workflows


def test_no_function_has_the_name_of_a_module():
    modules = {module.name for module in pkgutil.iter_modules(workflows.__path__)}
    assert not modules & set(workflows.__all__)


def test_each_name_is_a_function_with_help_also_after_all_modules_are_imported():
    for module in pkgutil.iter_modules(workflows.__path__):
        __import__(f"harness.workflows.{module.name}")
    for name in workflows.__all__:
        found = getattr(workflows, name)
        assert inspect.isfunction(found), name
        assert found.__doc__, name
        home = getattr(sys.modules[found.__module__], name)
        assert inspect.unwrap(home) is inspect.unwrap(found), name


def test_tab_finds_them():
    assert set(workflows.__all__) <= set(dir(workflows))


def test_importing_the_package_imports_none_of_them():
    script = (
        "import sys; import harness.workflows;"
        "print(sorted({'numpy', 'pydantic', 'pandas', 'harness.cases'} & set(sys.modules)))"
    )
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=True
    )
    assert done.stdout == "[]\n"


def test_what_is_not_there_is_an_attribute_error():
    with pytest.raises(AttributeError, match="no attribute 'nothing'"):
        _ = workflows.nothing
