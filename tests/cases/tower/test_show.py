"""Sections and figures of the tower."""

from harness.cases.bench import OWN, Bench
from harness.cases.checks import run_checks, selected
from harness.cases.tower.case import CASE
from harness.cases.tower.impulse import impulse_angles
from harness.cases.tower.show import angle_figure
from harness.engines.reference import Reference
from harness.report.figures import draw
from tests.cases.tower.standin import Standin


def test_sections_draw_what_benches_have():
    benches = {"standin": Bench(Standin()), "scenes": Bench(Reference()), OWN: Bench(None)}
    for name in ("standin", "scenes"):
        checks = selected("tower", CASE.checks(benches[name].engine), "quick")
        run_checks("tower", checks, benches[name])
    sections = CASE.sections(benches)
    pictures = [draw(drawing) for section in sections for drawing in section.drawings]
    assert [picture.error for picture in pictures] == [""] * len(pictures)
    opening = sections[0].opening
    assert opening.figure in {picture.drawing.name for picture in pictures}
    assert "10.21" in opening.steps[-1]
    assert "4.74" in opening.steps[-1]
    force = next(p for p in pictures if p.drawing.name == "force-deformable")
    assert "standin" in force.svg
    assert "scenes" not in force.svg
    assert len(sections[0].tables[0].frame) == 8


def test_measured_angles_are_drawn_beside_the_theory():
    frame = impulse_angles(heights=(1, 2), stiffnesses=(1e6,), speeds=(2.0,), laws=("overlap",))
    figure = angle_figure(frame, measured=([1.0, 2.0], [10.0, 8.0]))
    assert "measured" in {text.get_text() for text in figure.legends[0].get_texts()}
