"""The engine of another package goes through the suite, as its own tests would have it."""

import sys
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

from harness.cases.bench import Bench
from harness.cases.checks import run_checks
from harness.cases.drop.case import CASE
from harness.engines.scene_jobs import scene_job
from harness.results.rows import Verdict
from harness.solvers import reference
from harness.testing import engine_checks
from tests.engines.test_plane_scenes import LAWS, drop, row, tower

HERE = Path(__file__).parent
README = HERE.parents[1] / "harness" / "engines" / "README.md"


@contextmanager
def importable():
    """Make the example package importable, which need not be installed."""
    sys.path.insert(0, str(HERE / "small_dem"))
    try:
        yield
    finally:
        sys.path.remove(str(HERE / "small_dem"))


def small_dem():
    """Open the engine of the example package."""
    with importable():
        from small_dem.engine import SmallDem
    return SmallDem()


@pytest.mark.parametrize("check", engine_checks(small_dem))
def test_small_dem(check):
    check()


def test_it_qualifies():
    with small_dem() as engine:
        rows = run_checks("drop", [*CASE.checks(engine)], Bench(engine))
    assert {row.verdict for row in rows} == {Verdict.PASS}


ROWS = [
    row(LAWS["plastic"]),
    row(LAWS["attractive"], 8.0, motion="held"),
    row(LAWS["clipped"]).replace(steps=7777),
    drop(LAWS["clipped"], "held", 9.81),
]


@pytest.mark.parametrize("scene", ROWS)
def test_its_motion_is_that_of_the_reference(scene):
    with small_dem() as engine:
        (motion,), rules = engine.motions([scene_job(scene)]), engine.rules(scene)
        assert "lets all spheres touch" in engine.refuses(scene_job(tower(LAWS["elastic"])))
    expected = reference.run(scene, rules)
    assert np.abs(motion.position - expected.position).max() < 1e-12
    assert scene.stages == () or np.abs(motion.stages - expected.stages).max() < 1e-12


def test_the_readme_has_the_example_as_it_is():
    text = (HERE / "small_dem" / "small_dem" / "engine.py").read_text(encoding="utf-8")
    assert f"```python\n{text}```" in README.read_text(encoding="utf-8")
