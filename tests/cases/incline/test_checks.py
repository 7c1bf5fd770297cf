"""The checks of the incline: an honest engine holds, and each planted fault turns its row."""

from dataclasses import replace
from functools import cache
from typing import ClassVar

import numpy as np
import pytest

from harness.cases.bench import Bench
from harness.cases.checks import run_checks, selected
from harness.cases.incline.case import CASE
from harness.cases.incline.checks import DISC, PLASTIC_CASE, near_critical, same_path
from harness.engines.reference import Reference
from harness.engines.registry import engine_class
from harness.model.scene import Scene
from harness.report.page import draw
from harness.results.rows import Kind, Verdict
from harness.store.committed import known_defects
from tests.cases.common import verdicts
from tests.cases.scene_faults import coefficient, diameters, grain, scaled, turned
from tests.engine_doubles import Twin

PATHS = "*/largest difference of the path"
PATH = "*steps, 10.2 deg/largest difference of the path"  # without friction
COARSE = "*50 steps, 10.2 deg/largest difference of the path"
ROUGH_PATH = "*friction*/largest difference of the path"
SHOCK = "*/largest error of the energy after each shock"
ANGLE = "plastic contact, k = 1e6 N/m, 100 steps/critical_angle_deg"
CRESTS = "*/largest error of the energy at 5 crests"
LIMIT = "*infinity/critical_angle_deg"  # of 24 searches


@cache
def quick():
    return [*CASE.checks_up_to(Reference(), "quick")]


def rows_of(engine, only="*"):
    return run_checks("incline", selected("incline", quick(), "quick", only), Bench(engine))


@pytest.fixture(scope="module")
def honest():
    bench = Bench(Twin())
    return run_checks("incline", quick(), bench), bench


def test_an_honest_engine_holds_in_every_row(honest):
    rows, _ = honest
    assert verdicts(rows) == {Verdict.PASS, Verdict.FINDING}
    assert {check.level for check in quick()} == {"quick"}
    assert {row.kind for row in rows} == {Kind.ANALYTIC, Kind.CROSS_CODE, Kind.FINDING}
    assert len({row.key for row in rows}) == len(rows) <= 25


def test_the_limit_is_the_closed_form_within_its_uncertainty(honest):
    rows, bench = honest
    (limit,) = [r for r in rows if "infinity" in r.setup and r.unit == "deg"]
    assert abs(limit.difference) < limit.uncertainty < limit.tolerance
    (check,) = [check for check in quick() if check.setup == limit.setup]
    off = replace(check, expected=(1.0 + 1e-3) * check.expected)
    assert verdicts(run_checks("incline", [off], bench)) == {Verdict.FAIL}


def test_sections_draw_what_was_run_and_run_nothing(monkeypatch):
    # the curve of the theory takes a second
    monkeypatch.setattr("harness.cases.incline.case.rigid_angle", lambda _: (10.0, "a line"))
    bench, only = Bench(Twin()), "*50 steps, friction 0.35*"
    run_checks("incline", selected("incline", CASE.checks(Twin()), "full", only), bench)
    before = len(bench._runs._futures)
    idle = Bench(Reference())
    sections = CASE.sections({"stand-in": bench, "idle": idle, "harness": Bench(None)})
    assert len(bench._runs._futures) == before
    assert sections[0].opening is not None
    (picture,) = [draw(drawing) for section in sections for drawing in section.drawings]
    assert picture.error == ""
    (legend,) = sections[-1].drawings[0].draw().legends
    names = [text.get_text() for text in legend.get_texts()]
    assert "Twin" in names
    assert idle.engine.title not in names  # it has no point


# ---- planted faults: the fault, and the rows of which one must turn


def written(change):
    """Return a fault of the tables that an engine writes: columns by name to changed ones."""
    return lambda output: replace(
        output, tables={name: {**t, **change(t)} for name, t in output.tables.items()}
    )


def without(rows):
    """Leave out samples of the path."""

    def change(table):
        path = "step" in table and len(table["step"]) > 50
        return {n: np.delete(column, rows, axis=0) for n, column in table.items()} if path else {}

    return written(change)


def nan(values):
    values = np.array(values)
    values[len(values) // 2] = np.nan
    return values


def slack(scene: Scene) -> Scene:
    """Keep the tail that the law clips, and clip the one that it keeps."""
    return scene.replace(law=scene.law.replace(clipped=not scene.law.clipped))


SCENE_FAULTS = {
    "angle": (turned(), PATH),
    "gravity": (scaled("gravity"), PATH),
    "stiffness": (coefficient("normal_stiffness"), PATH),
    "damping": (coefficient("damping_coefficient"), PATH),
    "diameter": (diameters(), PATH),
    "step": (scaled("step"), PATH),
    "mass": (grain("mass"), PATH),
    "tail": (slack, PATH),
    "inertia": (grain("inertia", 1 + 1e-6), ROUGH_PATH),
    "friction": (coefficient("friction", 1 + 1e-6), ROUGH_PATH),
    "tangential stiffness": (coefficient("tangential_stiffness", 1 + 1e-6), ROUGH_PATH),
    "tangential damping": (coefficient("tangential_damping", 1 + 1e-6), ROUGH_PATH),
    "no friction": (lambda s: s.replace(law=PLASTIC_CASE.law), "*friction 0.5/critical_angle_deg"),
    "angle by 1e-4 deg": (turned(1e-5), ANGLE),
    "slope by 1e-3": (turned(1e-3), LIMIT),
    "slope by 1e-4": (turned(1e-4), CRESTS),
    "slope by 1 %": (turned(-1e-2), SHOCK),
}
VX, VY = "vx_m_per_s", "vy_m_per_s"
OUTPUT_FAULTS = {
    "velocities swapped": written(lambda t: {VX: t[VY], VY: t[VX]}),
    "place by 1e-9": written(lambda t: {"x_m": (1 + 1e-9) * t["x_m"]}),
    "clock": written(lambda t: {"time_s": (1 + 1e-6) * t["time_s"]}),
    "NaN": written(lambda t: {VY: nan(t[VY])}),
    "last sample": without([-1]),
    "one sample": without([40]),
    "first samples": without(range(30)),
}


@pytest.mark.parametrize("fault", [
    pytest.param(fault, marks=[pytest.mark.slow] if only == LIMIT else [])
    for fault, (_, only) in SCENE_FAULTS.items()
])  # fmt: skip
def test_a_fault_in_what_is_run_turns_a_row(fault):
    change, only = SCENE_FAULTS[fault]
    assert Verdict.FAIL in verdicts(rows_of(Twin(change), only))


@pytest.mark.parametrize("fault", OUTPUT_FAULTS)
def test_a_fault_in_what_is_written_turns_a_row(fault):
    rows = rows_of(Twin(change_output=OUTPUT_FAULTS[fault]), PATH)
    assert verdicts(rows) == {Verdict.FAIL}


def test_an_engine_in_another_scheme_than_it_declares_is_off_its_reference():
    class Other(Twin):
        def rules(self, scene):
            return super().rules(scene).replace(scheme="mfix_euler")

    engine = Other()
    engine._motion = Reference()._motion
    rows = rows_of(engine, ANGLE)
    assert Verdict.FAIL in verdicts(rows)


# ---- a known defect


def test_a_disc_that_turns_as_a_sphere_is_the_known_defect_of_lammps():
    def as_sphere(scene):
        return scene.replace(bodies=tuple(body.replace(inertia=None) for body in scene.bodies))

    class Omp(Twin):
        def identify(self):
            return replace(super().identify(), how="executable, -sf omp")

    defects = [defect.replace(engine="twin") for defect in known_defects() if defect.command]
    check = same_path(near_critical(DISC))
    engines = {Omp(as_sphere): "known defect", Twin(as_sphere): "fail", Omp(): "pass"}
    for engine, verdict in engines.items():
        (row,) = run_checks("incline", [check], Bench(engine), defects=defects)
        assert row.verdict == verdict


# ---- LAMMPS


class Changed(engine_class("lammps")):
    """LAMMPS with values of its scripts off by a factor."""

    factors: ClassVar = {}

    def task(self, job):
        off = {name: job.values[name] * self.factors[name] for name in self.factors}
        return super().task(replace(job, values={**job.values, **off}))


@pytest.fixture(scope="module")
def lammps(lammps_here):  # noqa: ARG001
    with Changed(workers=1) as engine:
        yield engine


@pytest.mark.live
@pytest.mark.parametrize(
    ("factors", "only"),
    [
        ({}, PATHS),
        ({}, CRESTS),
        ({"angle": 1 + 1e-7}, COARSE),
        ({"stiffness": 1 + 1e-7}, COARSE),
        ({"gravity": 1 + 1e-7}, COARSE),
        ({"steps_per_contact": 1 + 1e-7}, COARSE),
        ({"friction": 1 + 1e-6}, "*friction 0.1*" + PATHS[1:]),
    ],
    ids=str,
)
def test_lammps_is_the_reference_and_a_fault_in_its_values_turns_a_row(
    lammps, monkeypatch, factors, only
):
    monkeypatch.setattr(Changed, "factors", factors)
    assert verdicts(rows_of(lammps, only)) == {Verdict.FAIL if factors else Verdict.PASS}


def test_a_slow_engine_has_its_limit_at_the_longest_level_alone():
    class Slow(Reference):
        def __init__(self):
            super().__init__()
            self.traits = replace(self.traits, microseconds_per_step=10.0)

    checks = [*CASE.checks(Slow())]
    assert {c.level for c in checks if "infinity" in c.setup} == {"full"}
    in_default = {c.setup for c in checks if c.level != "full"}
    assert in_default < {c.setup for c in CASE.checks(Reference())}
