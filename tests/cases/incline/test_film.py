"""The film of the incline: the grain is drawn where the engine wrote it."""

import math

import numpy as np
import pytest

from harness.cases.incline.film import InclineGrain, InclineMotion
from harness.cases.incline.runs import measured
from harness.cases.incline.system import Incline, Motion
from harness.engines.registry import open_engine


@pytest.mark.parametrize(("angle", "fate"), [(9.5, Motion.TRAPPED), (10.5, Motion.MOVES_ON)])
def test_the_grain_is_drawn_where_the_engine_wrote_it(angle, fate):
    """In a frame turned back by the angle: along the row, and normal to it."""
    case = Incline(angle=angle, stiffness=1e5, wells=4)
    with open_engine("reference") as engine:
        (run,) = measured(engine, [case], "steady", every=20)
    assert run.motion is fate
    motion = InclineMotion(run, np.linspace(0, run.time_s, 15))
    scene = InclineGrain(motion)
    tilt = math.radians(angle)
    for frame, now in enumerate(motion.time):
        scene.picture(frame)
        seen = run.path.time_s <= now
        x, y = scene._grain.center
        along = x * math.cos(tilt) - y * math.sin(tilt)
        normal = x * math.sin(tilt) + y * math.cos(tilt)
        assert along == pytest.approx(run.path.x_m[seen][-1], abs=1e-9)
        assert normal == pytest.approx(run.path.y_m[seen][-1], abs=1e-9)
