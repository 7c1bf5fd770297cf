"""What a report shows of the incline: the answer with its derivation, the contacts, friction."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from importlib import resources
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from harness.cases.bench import Bench
from harness.cases.incline.checks import (
    FRICTIONS,
    PLASTIC_CASE,
    SLIGHT_FRICTIONS,
    first_jobs,
    friction_case,
    ladder_jobs,
)
from harness.cases.incline.closed_form import rebound, rigid_angle
from harness.cases.incline.search import (
    FULL_LADDER,
    QUICK_LADDER,
    Ladder,
    angle_on,
    extrapolated_on,
)
from harness.engines.base import Job
from harness.errors import EngineError, Unsupported
from harness.model.law import CLIPPED, PLASTIC
from harness.report.content import Drawing, Opening, Section
from harness.theory.incline import (
    INERTIA,
    STATIC_ANGLE_DEG,
    critical_angle,
    rolling_friction,
)

if TYPE_CHECKING:
    from harness.report.figures import Figure

Result = TypeVar("Result")

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
CONTACTS_TEXT = f"""\
- *source* (e = 1e-20, tail kept): the attractive tail holds back the contact that opens. The angle
  rises above the closed form by about k^(-1/2) as the step goes to zero; at 50 steps the tail is
  mostly skipped, and the two errors nearly cancel.
- *clipped* (critical damping, no tail): smooth in the step, but it rebounds with
  {rebound(CLIPPED):.3f}.
- *plastic* (damping ratio {PLASTIC.zeta:g}, no tail): first order in the step and nearly in 1/k.
  This is the e = 0 of the theory.

With restitution a grain bounces several times within a well. Neither reading of the theory of one
shock describes it: rigid spheres by events do (`dem-harness theory --restitution`)."""
FRICTION_TEXT = """\
A grain with friction rolls. The share s of its speed that a shock leaves grows from cos(2 phi) to
(cos(2 phi) + beta) / (1 + beta), and the critical angle falls. Slight friction raises it first: it
retards a grain that hardly spins yet. Between the closed forms a rigid grain is integrated with
Coulomb's limit in shocks and on arcs. The contact's tangential dashpot is beta / (1 + beta) of the
normal one: with equal ones, a shock sticks from mu = tan(phi) on."""


def sections(benches: Sequence[Bench]) -> list[Section]:
    """Return the sections of a report on the engines of some benches; nothing is run for it."""
    return [_opening(benches), Section("The contacts", CONTACTS_TEXT), *_friction(benches)]


def _opening(benches: Sequence[Bench]) -> Section:
    drawings = [
        Drawing(
            "critical-angle-extrapolation",
            f"Critical angle, extrapolated: {bench.engine.title}",
            "Plastic contact, by passage. Left: first order in the step; open symbols are limits. "
            "Right: those limits over the stiffness. Dashed: the closed form.",
            limit.draw,
        )
        for bench in benches
        for ladder in (FULL_LADDER, Ladder(), QUICK_LADDER)
        if (limit := _measured(bench, ladder_jobs(PLASTIC_CASE, ladder),
                               extrapolated_on, ladder, PLASTIC_CASE))
    ]  # fmt: skip
    sketch = resources.files(__package__) / "sketch.svg"
    opening = Opening(
        "At what angle does a grain without friction keep moving?",
        sketch.read_text(encoding="utf-8"),
        STEPS,
        "Harper, Dufek and Breard (arXiv:2409.13633), after the model of Quartier et al. (2000)",
        TERMS,
        figure=drawings[0] if drawings else None,
    )
    return Section("The critical angle", opening=opening)


def _friction(benches: Sequence[Bench]) -> Iterator[Section]:
    cases = [friction_case(friction) for friction in (*SLIGHT_FRICTIONS, *FRICTIONS)]
    measured = {
        bench.engine.title: {
            case.friction: angle.value
            for case in cases
            if (angle := _measured(bench, first_jobs(case), angle_on, case))
        }
        for bench in benches
    }
    if any(measured.values()):
        drawing = Drawing(
            "critical-angle-friction",
            "Critical angle over friction",
            f"Equal spheres, k = 1e6 N/m, 50 steps: from {critical_angle():.4f} deg without "
            f"friction to {rigid_angle(friction_case(1.0))[0]:.4f} deg without slip. With little "
            "friction stiffness and step move the angle by hundredths of a degree, and so does a "
            "dashpot that Coulomb's limit leaves out.",
            partial(over_friction, measured),
        )
        yield Section("Friction", FRICTION_TEXT, drawings=(drawing,))


def _measured(
    bench: Bench, jobs: Sequence[Job], search: Callable[..., Result], *args: Any
) -> Result | None:
    """Return the result of a search whose first jobs were run, None where they were not."""
    try:
        return search(bench, *args) if bench.has_run(jobs) else None
    except (EngineError, Unsupported):  # it has a row
        return None


def over_friction(measured: Mapping[str, Mapping[float, float]]) -> Figure:
    """Draw the critical angle over friction: theory as a line, angles [deg] of each engine."""
    from harness.report.figures import BLACK, COLOURS, MARKERS, label, legend_below, panels

    figure = panels(1, 1, 7.2, 4.2)
    (axes,) = figure.axes
    most = max(friction for angles in measured.values() for friction in angles)
    frictions = np.concatenate([np.linspace(0.0, 0.12, 41), np.linspace(0.13, most, 20)])
    theory = [rigid_angle(friction_case(float(mu)))[0] for mu in frictions]
    axes.plot(frictions, theory, color=BLACK, lw=1.2, label="theory, rigid grain")
    for number, (name, angles) in enumerate(measured.items(), 1):
        look: dict[str, Any] = {
            "marker": MARKERS[number % 6],
            "color": COLOURS[number % 7],
            "mfc": "none",
        }
        axes.plot([*angles], [*angles.values()], label=name, ls="", **look)
    bound = rolling_friction(STATIC_ANGLE_DEG, INERTIA["sphere"])
    if bound <= most:
        axes.axvline(bound, color="0.5", ls=":", label=f"rolls without slip from {bound:.4f} on")
    label(axes, "friction coefficient", "critical angle (deg)")
    legend_below(figure, 3)
    return figure
