"""``harness.workflows`` gives functions: never a module, all of them by Tab, each with its help."""

import inspect
import pkgutil
import subprocess
import sys

import pytest

from harness import workflows
from harness.cases.drop.case import Drop
from harness.cases.drop.case import job_of as drop_job
from harness.cases.incline.system import Incline
from harness.engines.reference import Reference
from harness.errors import RequestError
from harness.parameters.tower import Tower
from harness.store.cache import opened


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


def test_importing_the_package_imports_none_of_them():
    script = (
        "import sys; import harness.workflows;"
        "print(sorted({'numpy', 'pydantic', 'pandas', 'harness.cases'} & set(sys.modules)))"
    )
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=True
    )
    assert done.stdout == "[]\n"


CASE = Incline()


@pytest.mark.parametrize(
    "call",
    [
        lambda **named: workflows.critical_angle(CASE, **named),
        lambda **named: workflows.critical_angles([CASE], **named),
        lambda **named: workflows.extrapolated_critical_angle(**named),
        lambda **named: workflows.tower(Tower(), **named),
        lambda **named: workflows.impulse_table(heights=(1,), **named),
        lambda **named: workflows.impulse_angles(heights=(1,), **named),
        lambda **named: workflows.run("incline", **named),
        lambda **named: workflows.film("incline", **named),
        lambda **named: workflows.verify(**named),
        lambda **named: workflows.compare_with_baseline(**named),
    ],
)
@pytest.mark.parametrize("fresh", [False, True])
def test_each_function_takes_the_name_of_an_engine_and_refuses_an_unknown_one(call, fresh):
    with pytest.raises(RequestError, match="no-such-engine"):
        call(engine="no-such-engine", fresh=fresh)


def test_an_engine_of_a_name_keeps_its_runs_and_fresh_makes_them_again(tmp_path, monkeypatch):
    monkeypatch.setenv("DEM_HARNESS_HOME", str(tmp_path))
    jobs = [drop_job(Drop(duration=0.1))]
    for fresh, counts in ((False, (1, 0)), (False, (0, 1)), (True, (1, 0))):
        with opened("reference", fresh=fresh) as engine:
            engine.run(jobs)
            assert (engine.ran, engine.read) == counts


def test_an_open_engine_is_used_as_it_is():
    with Reference() as engine, opened(engine) as same:
        assert same is engine
