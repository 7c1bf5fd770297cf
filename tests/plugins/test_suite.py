"""The engine and the case of other packages, as their own tests would have them."""

from importlib import import_module
from pathlib import Path

import pytest

from harness.cases.bench import Bench
from harness.cases.checks import run_checks
from harness.cases.drop import CASE as DROP
from harness.results.rows import Verdict
from harness.testing import engine_checks
from tests.engine_doubles import Twin

HERE = Path(__file__).parent
ROOMS = HERE.parents[1] / "harness"


def example(package, module):
    """Import a module of an example package, which need not be installed."""
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(HERE / package)
        return import_module(f"{package}.{module}")


def small_dem():
    """Open the engine of the example package."""
    return example("small_dem", "engine").SmallDem()


BALL = example("ball_on_sphere", "case").CASE


@pytest.mark.parametrize("check", engine_checks(small_dem))
def test_small_dem(check):
    check()


def test_it_qualifies():
    with small_dem() as engine:
        rows = run_checks("drop", [*DROP.checks(engine)], Bench(engine))
    assert {row.verdict for row in rows} == {Verdict.PASS}


def ball_rows(engine):
    return run_checks(BALL.name, [*BALL.checks(engine)], Bench(engine))


def test_the_case_holds_in_the_engine():
    with small_dem() as engine:
        assert [row.verdict for row in ball_rows(engine)] == 7 * [Verdict.PASS]


def test_a_stiffness_off_by_1e_6_turns_every_contact_time():
    def stiffer(scene):
        stiffness = scene.law.normal_stiffness * (1.0 + 1e-6)
        return scene.replace(law=scene.law.replace(normal_stiffness=stiffness))

    rows = ball_rows(Twin(stiffer))
    assert {row.setup for row in rows if row.verdict is Verdict.FAIL} == {*BALL.presets}


@pytest.mark.parametrize(("room", "file"), [
    ("engines", "small_dem/small_dem/engine.py"), ("cases", "ball_on_sphere/ball_on_sphere/case.py")
])  # fmt: skip
def test_a_readme_has_its_example_as_it_is(room, file):
    text = (HERE / file).read_text(encoding="utf-8")
    page = (ROOMS / room / "README.md").read_text(encoding="utf-8")
    assert f"```python\n{text}```" in page
