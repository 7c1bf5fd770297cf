import math

import numpy as np
import pytest

from harness.cases.incline.film import InclineGrain, InclineMotion, angles_beside, incline_film
from harness.cases.incline.runs import measured
from harness.cases.incline.system import Incline, Motion
from harness.engines.registry import open_engine
from harness.errors import RequestError
from harness.report.film import gif

CASES = [Incline(angle=angle, stiffness=1e5, wells=4) for angle in (9.5, 10.5)]


@pytest.fixture(scope="module")
def engine():
    with open_engine("reference") as opened:
        yield opened


@pytest.fixture(scope="module")
def motion(engine):
    runs = tuple(measured(engine, CASES, "steady", every=20))
    assert [run.motion for run in runs] == [Motion.TRAPPED, Motion.MOVES_ON]
    return InclineMotion("n", "Title", "words", runs, np.linspace(0, runs[1].time_s, 15))


def test_grains_are_drawn_where_the_engine_wrote_them(motion):
    """In a frame turned back by the angle: along the row, and normal to it."""
    scene = InclineGrain(motion)
    for frame, now in enumerate(motion.time):
        scene.picture(frame)
        for row, lane in enumerate(scene._lanes):
            path, tilt = lane.run.path, math.radians(lane.run.case.angle)
            seen = path.time_s <= now
            x, y = lane.grain.center
            along = x * math.cos(tilt) - y * math.sin(tilt)
            normal = x * math.sin(tilt) + y * math.cos(tilt) + 2.05 * row
            assert along == pytest.approx(path.x_m[seen][-1], abs=1e-9)
            assert normal == pytest.approx(path.y_m[seen][-1], abs=1e-9)


def test_the_fate_is_told_once_it_is_known(motion):
    scene = InclineGrain(motion)
    below, above = scene._lanes
    scene.show(0)
    assert below.words.get_text() == "9.50 deg: 0 crests passed"
    scene.show(motion.time.size - 1)
    assert below.words.get_text().endswith("turns back, trapped")
    assert above.words.get_text() == "10.50 deg: 4 crests passed, moves on"


def test_a_film_says_what_was_run(engine):
    film = incline_film(engine, CASES, 20)
    assert film.frames == 20
    assert film.title == "The grain over the bumps at 9.50 deg, 10.50 deg"
    assert "At 9.50 deg it is trapped after" in film.caption
    assert "At 10.50 deg it moves on over 4 crests" in film.caption
    assert len(gif(film.picture, film.frames)) < 1e6


def test_angles_are_clear_of_the_uncertainty():
    assert angles_beside(10.2, 0.001) == (10.15, 10.25)
    assert angles_beside(10.2, 0.1) == (9.9, 10.5)
    assert angles_beside(0.02, 0.0)[0] == 0.0


@pytest.mark.parametrize("count", [0, 4])
def test_a_film_has_room_for_three_rows(engine, count):
    with pytest.raises(RequestError, match=f"{count} angles: must be from 1 to 3"):
        incline_film(engine, [Incline()] * count, 20)
