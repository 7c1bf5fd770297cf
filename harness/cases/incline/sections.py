"""Sections of a report on the incline: the answer, angles of engines, friction, a path."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import partial
from importlib import resources

import pandas as pd

from harness.cases.bench import Bench
from harness.cases.incline import figures
from harness.cases.incline.angle import known_angle, known_reference
from harness.cases.incline.checks import (
    CASES,
    EVERY,
    FRICTIONS,
    PATH_ANGLE,
    PLASTIC_CASE,
    SLIGHT_FRICTIONS,
    SOURCE_CLIPPED,
)
from harness.cases.incline.closed_form import angle_with_friction, rebound, rigid_angle
from harness.cases.incline.extrapolation import known_extrapolation
from harness.cases.incline.runs import Run, read
from harness.cases.incline.system import Incline, job_of
from harness.errors import EngineError
from harness.model.contact import CLIPPED, PLASTIC
from harness.report.content import Drawing, Opening, Section, Table
from harness.theory.incline import critical_angle

FIGURE = "critical-angle-extrapolation"
STEPS = (
    "In a well the velocity turns by 60 deg. Without rebound its part along the old path is lost "
    "but for cos 60 deg = 1/2, so a quarter of the energy is left: E becomes (E + m g d sin θ) / 4 "
    "from well to well.",
    "The steady energy is E* = m g d sin θ / 3. The next crest takes C = m g d (1 - cos(30 deg - "
    "θ)).",
    f"E* = C at θ_c = 2 atan(tan(15 deg) / 3) = {critical_angle():.4f} deg: below it the grain is "
    "trapped.",
)
TERMS = (
    ("well", "where the grain touches two fixed spheres; the shock happens there"),
    ("crest", "the highest point of the path, right above a sphere"),
    ("passage", "a grain comes over a crest at rest; the energy left after one well, less that of "
     "the next crest, is 0 at θ_c"),
    ("steady", "the second way to θ_c: long runs, in which the grain moves on or is trapped"),
    ("tail", "the part of a contact in which its dashpot pulls, as it opens; kept, or clipped"),
    ("plastic", "a contact with strong damping and no tail: it hardly rebounds, as in the theory"),
)  # fmt: skip
CONTACTS = f"""\
- *source* (e = 1e-20, tail kept): the attractive tail holds back the contact that opens. The angle
  rises above the closed form by about k^(-1/2) as the step goes to zero; at 50 steps the tail is
  mostly skipped, and the two errors nearly cancel.
- *clipped* (critical damping, no tail): smooth in the step, but it rebounds with
  {rebound(CLIPPED):.3f}.
- *plastic* (damping ratio {PLASTIC.zeta:g}, no tail): first order in the step and nearly in 1/k.
  This is the e = 0 of the theory.

With restitution a grain bounces several times within a well. Neither reading of the theory of one
shock describes it: rigid spheres by events do (`dem-harness theory --restitution`)."""
FRICTION = """\
A grain with friction rolls. The share s of its speed that a shock leaves grows from cos(2 phi) to
(cos(2 phi) + beta) / (1 + beta), and the critical angle falls. Slight friction raises it first: it
retards a grain that hardly spins yet. Between the closed forms a rigid grain is integrated with
Coulomb's limit in shocks and on arcs. The contact's tangential dashpot is beta / (1 + beta) of the
normal one: with equal ones, a shock sticks from mu = tan(phi) on."""


def sections(benches: Mapping[str, Bench]) -> list[Section]:
    """Return the sections of a report on engines; the first one's figures are shown."""
    return [*_opening(benches), *_angles(benches), *_friction(benches), *_paths(benches)]


def _opening(benches: Mapping[str, Bench]) -> Iterator[Section]:
    sketch = resources.files("harness.cases.incline") / "sketch.svg"
    opening = Opening(
        "At what angle does a grain without friction keep moving?",
        sketch.read_text(encoding="utf-8"),
        STEPS,
        "Harper, Dufek and Breard (arXiv:2409.13633), after the model of Quartier et al. (2000)",
        TERMS,
        FIGURE,
    )
    drawings = [
        Drawing(
            FIGURE,
            f"Critical angle, extrapolated: {bench.engine.title}",
            "Plastic contact, by passage. Left: first order in the step; open symbols are limits. "
            "Right: those limits over the stiffness. Dashed: the closed form.",
            partial(figures.extrapolation, found),
        )
        for bench in benches.values()
        if (found := known_extrapolation(bench, PLASTIC_CASE)) is not None
    ]
    yield Section("The critical angle", drawings=tuple(drawings[:1]), opening=opening)


def _angles(benches: Mapping[str, Bench]) -> Iterator[Section]:
    rows = [
        _row(bench, case.replace(stiffness=stiffness))
        for bench in benches.values()
        for case in (*CASES, SOURCE_CLIPPED)
        for stiffness in (1e5, 1e6, 1e7)
    ]
    if frame := [row for row in rows if row]:
        yield Section(
            "The contacts",
            CONTACTS,
            tables=(
                Table(
                    "Critical angles",
                    pd.DataFrame(frame),
                    "By passage, less theory, and less the reference under the engine's rules.",
                ),
            ),
        )


def _row(bench: Bench, case: Incline) -> dict[str, str | float]:
    found, reference = known_angle(bench, case), known_reference(bench, case)
    if found is None:
        return {}
    return {
        "engine": bench.engine.title,
        "contact": f"{case.contact.name}, {case.contact.tail}, m* = {case.contact.mass_text}",
        "k (N/m)": case.stiffness,
        "steps": case.steps_per_contact,
        "angle (deg)": found.value,
        "uncertainty (deg)": found.uncertainty,
        "less theory (deg)": found.value - rigid_angle(case)[0],
        "less reference (deg)": float("nan")
        if reference is None
        else found.value - reference.value,
    }


def _friction(benches: Mapping[str, Bench]) -> Iterator[Section]:
    cases = [
        PLASTIC_CASE.replace(friction=friction, steps_per_contact=50.0)
        for friction in (*SLIGHT_FRICTIONS, *FRICTIONS)
    ]
    points = {
        bench.engine.title: [
            (case.friction, found.value) for case in cases if (found := known_angle(bench, case))
        ]
        for bench in benches.values()
    }
    if points := {name: series for name, series in points.items() if series}:
        rolling = angle_with_friction(1.0, "sphere", 30.0)[0]
        yield Section(
            "Friction",
            FRICTION,
            drawings=(
                Drawing(
                    "critical-angle-friction",
                    "Critical angle over friction",
                    f"Equal spheres, k = 1e6 N/m, 50 steps: from {critical_angle():.4f} deg "
                    f"without friction to {rolling:.4f} deg without slip.",
                    partial(figures.over_friction, points),
                ),
            ),
        )


def _paths(benches: Mapping[str, Bench]) -> Iterator[Section]:
    for bench in benches.values():
        try:
            run = _passage(bench, PLASTIC_CASE.replace(angle=PATH_ANGLE))
        except EngineError:
            continue
        drawing = Drawing(
            "path-over-the-bumps",
            f"A passage in {bench.engine.title}",
            "From 10 deg behind a crest through one well; the run ends where the contact has "
            "settled.",
            partial(figures.path_over_the_bumps, {f"{PATH_ANGLE:g} deg, {run.fate}": run}),
        )
        yield Section("A passage", drawings=(drawing,))
        return


def _passage(bench: Bench, case: Incline) -> Run:
    job = job_of(case, "passage", EVERY)
    if reason := bench.refusal(job):
        raise EngineError(reason)
    return read(case, "passage", bench.output(job), EVERY)
