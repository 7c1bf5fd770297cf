"""Engines by name: those of this package and of others, and the options that they take."""

import sys
from importlib.metadata import EntryPoint

import pytest

from harness.engines import registry
from harness.engines.lammps.engine import Lammps
from harness.engines.process import Limits
from harness.engines.registry import (
    ENGINES,
    chosen_options,
    engine_class,
    engine_names,
    fingerprint_of,
    open_engine,
)
from harness.errors import EngineError, EngineMissingError, RequestError
from tests.engines.struck import STRUCK_ELASTIC

PLUGIN = """
from typing import Literal
from harness.engines.base import Engine, Traits

class Half(Engine):
    name = "half"

class Mine(Engine):
    name = "mine"
    traits = Traits("pip install mine", ("1",), "")

    def __init__(self, program: str | None = None, scheme: Literal["euler", "verlet"] = "euler",
                 order: int = 2, gap: float | None = None):
        self.options = (program, scheme, order, gap)

    def identify(self):
        raise NotImplementedError

class Unborn(Mine):
    def __init__(self):
        raise KeyError("x\\ny")

NOT_A_CLASS = 1
"""


class Point(EntryPoint):
    """An entry point of a package that is not installed."""

    def __init__(self, name, value, package):
        super().__init__(name, value, registry.GROUP)
        vars(self)["dist"] = type("Dist", (), {"name": package})()


@pytest.fixture
def plugins(tmp_path, monkeypatch):
    """Return a function that installs entry points of engines."""
    (tmp_path / "mine.py").write_text(PLUGIN)
    (tmp_path / "broken.py").write_text("import no_such_library\n")
    (tmp_path / "leaves.py").write_text("raise SystemExit('bye\\nbye')\n")
    monkeypatch.syspath_prepend(tmp_path)

    def install(*points):
        monkeypatch.setattr(registry, "entry_points", lambda group: points)  # noqa: ARG005
        registry._plugins.cache_clear()

    yield install
    registry._plugins.cache_clear()
    for name in ("mine", "broken", "leaves"):
        sys.modules.pop(name, None)


@pytest.mark.parametrize(
    ("name", "options", "message"),
    [
        ("granoo", {}, r"^--engine 'granoo' is not known: must be one of lammps, .*reference"),
        ("lammps", {"lmp": "sh", "launcher": "no-such-mpirun -np 2"}, r"--mpirun 'no-such-mpirun'"),
        ("lammps", {"lmp": "sh", "launcher": '"'}, r"--mpirun '\"' cannot be read"),
        ("lammps", {"lmp": "lmp 'x"}, '--lmp "lmp \'x" cannot be read: No closing quotation'),
        (
            "lammps",
            {"lmp": "/nowhere/lmp -sf omp"},
            "^--lmp .*: no such executable; give",
        ),
        ("liggghts", {"lmp": "lmp"}, "--engine-option liggghts.lmp=lmp: engine 'liggghts' takes"),
        ("reference", {"program": "sh"}, "--program reference=sh: engine 'reference' takes the op"),
        ("lammps", {"options": {"colour": "red"}}, "--engine-option lammps.colour=red: engine"),
        ("lammps", {"options": {"workers": "two"}}, "lammps.workers=two: must be a valid integer"),
        ("lammps", {"options": {"workers": "-1"}}, "workers = -1: must be at least 1"),
        ("lammps", {"options": {"limits": "soon"}}, "lammps.limits=soon: must be a valid number"),
        ("lammps", {"options": {"limits": "nan"}}, "lammps.limits=nan: must be a finite number"),
        ("lammps", {"options": {"limits": "-1"}}, "lammps.limits=-1: must be greater than 0"),
        ("lammps", {"options": {"limits": "1e308"}}, "must be less than or equal to 2000000"),
    ],
)
def test_a_wrong_engine_program_or_option_is_named(name, options, message):
    with pytest.raises(RequestError, match=message):
        open_engine(name, **options)


def test_options_are_read_as_the_engine_declares_them():
    given = {"workers": "2", "limits": "7.5", "lmp": None}
    named = Limits(seconds=7.5, patience=0.0)  # no run has longer
    assert chosen_options("lammps", given) == {"workers": 2, "limits": named}


def test_an_engine_of_another_package_opens_by_its_name_with_its_options(plugins):
    plugins(Point("mine", "mine:Mine", "mine-dem"))
    assert engine_names() == [*ENGINES, "mine"]
    options = {"scheme": "verlet", "order": "3", "gap": "1e-3"}
    with open_engine("mine", program="sh", options=options) as engine:
        assert engine.options == ("sh", "verlet", 3, 1e-3)
    with pytest.raises(RequestError, match=r"mine\.scheme=rk4: must be 'euler' or 'verlet'"):
        open_engine("mine", options={"scheme": "rk4"})


@pytest.mark.parametrize(
    ("value", "reason"),
    [
        ("broken:X", "ModuleNotFoundError: No module named 'no_such_library'"),
        ("leaves:X", r"\(SystemExit: bye\)"),
        ("mine:Nothing", "AttributeError: module 'mine' has no attribute"),
        ("mine:NOT_A_CLASS", "is no subclass of harness.engines.base"),
        ("mine:Half", "class Half has no identify, traits"),
    ],
)
def test_an_engine_that_is_broken_is_named_with_its_package_and_harms_no_other(
    plugins, value, reason
):
    plugins(Point("bad", value, "bad-dem"), Point("mine", "mine:Mine", "mine-dem"))
    assert engine_names() == [*ENGINES, "bad", "mine"]
    with pytest.raises(
        EngineMissingError, match=f"^engine 'bad' of package 'bad-dem'.*{reason}"
    ) as error:
        engine_class("bad")
    assert "\n" not in str(error.value)
    assert engine_class("mine").name == "mine"
    assert engine_class("lammps") is Lammps


def test_an_engine_that_cannot_be_made_is_named_and_has_no_fingerprint(plugins):
    plugins(Point("unborn", "mine:Unborn", "mine-dem"))
    with pytest.raises(
        EngineError, match="'mine' of package 'mine': __init__ raised KeyErr"
    ) as error:
        open_engine("unborn")
    assert "\n" not in str(error.value)
    assert fingerprint_of("unborn", {}) is None


def test_a_class_is_an_engine_for_a_try(plugins, tmp_path, monkeypatch):
    plugins()
    assert engine_class("mine:Mine").name == "mine"
    with pytest.raises(RequestError, match=r"^--engine 'mine:Half': class Half has no identify"):
        open_engine("mine:Half")
    (tmp_path / "here").mkdir()
    (tmp_path / "here" / "own_engine.py").write_text(PLUGIN)
    monkeypatch.chdir(tmp_path / "here")
    monkeypatch.setattr(sys, "path", [p for p in sys.path if p not in ("", str(tmp_path))])
    assert engine_class("own_engine:Mine").__module__ == "own_engine"


@pytest.mark.parametrize("name", ["kratos", "liggghts", "yade"])
def test_the_integrator_of_an_engine_is_the_scheme_of_its_rules(name):
    kind = engine_class(name)
    assert kind.rules(STRUCK_ELASTIC).scheme == kind.traits.integrator.replace("-", "_")
