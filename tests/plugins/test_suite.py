"""The engine and the case of other packages, as their own tests would have them."""

import sys
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

from harness.cases.bench import Bench
from harness.cases.checks import run_checks
from harness.cases.drop import CASE as DROP
from harness.engines.base import scene_job
from harness.results.rows import Verdict
from harness.solvers import reference
from harness.testing import engine_checks
from tests.engine_doubles import Twin
from tests.engines.test_plane_scenes import LAWS, drop, row, tower

HERE = Path(__file__).parent
ROOMS = HERE.parents[1] / "harness"


@contextmanager
def importable():
    """Make the example packages importable, which need not be installed."""
    folders = [str(HERE / name) for name in ("small_dem", "ball_on_sphere")]
    sys.path[:0] = folders
    try:
        yield
    finally:
        sys.path[:] = [place for place in sys.path if place not in folders]


def small_dem():
    """Open the engine of the example package."""
    with importable():
        from small_dem.engine import SmallDem
    return SmallDem()


def ball_on_sphere():
    """Return the case of the example package."""
    with importable():
        from ball_on_sphere.case import CASE
    return CASE


@pytest.mark.parametrize("check", engine_checks(small_dem))
def test_small_dem(check):
    check()


def test_it_qualifies():
    with small_dem() as engine:
        rows = run_checks("drop", [*DROP.checks(engine)], Bench(engine))
    assert {row.verdict for row in rows} == {Verdict.PASS}


ROWS = [
    row(LAWS["plastic"]),
    row(LAWS["attractive"], 8.0, motion="held"),
    row(LAWS["clipped"]).replace(steps=7777),
    drop(LAWS["clipped"], "held", 9.81),
    tower(LAWS["attractive"]),
]


@pytest.mark.parametrize("scene", ROWS)
def test_its_motion_is_that_of_the_reference(scene):
    with small_dem() as engine:
        (motion,), rules = engine.motions([scene_job(scene)]), engine.rules(scene)
    expected = reference.run(scene, rules)
    assert np.abs(motion.position - expected.position).max() < 1e-12
    assert scene.stages == () or np.abs(motion.stages - expected.stages).max() < 1e-12


def ball_rows(engine):
    case = ball_on_sphere()
    return run_checks(case.name, [*case.checks(engine)], Bench(engine))


def test_the_case_holds_in_the_engine():
    with small_dem() as engine:
        assert [row.verdict for row in ball_rows(engine)] == 7 * [Verdict.PASS]


def test_a_stiffness_off_by_1e_6_turns_every_contact_time():
    rows = ball_rows(Twin(lambda scene: scene.replace(law=stiffer(scene.law))))
    failed = {row.setup for row in rows if row.verdict is Verdict.FAIL}
    assert failed == {*ball_on_sphere().presets}


def stiffer(law):
    return law.replace(normal_stiffness=law.normal_stiffness * (1.0 + 1e-6))


@pytest.mark.parametrize(
    ("room", "file"),
    [
        ("engines", "small_dem/small_dem/engine.py"),
        ("cases", "ball_on_sphere/ball_on_sphere/case.py"),
    ],
)
def test_a_readme_has_its_example_as_it_is(room, file):
    text = (HERE / file).read_text(encoding="utf-8")
    page = (ROOMS / room / "README.md").read_text(encoding="utf-8")
    assert f"```python\n{text}```" in page
