"""How the incline is shown: the sections of a report, and a film."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from importlib import resources
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from harness.cases.base import path_in
from harness.cases.bench import Bench
from harness.cases.incline.angle import (
    FULL_LADDER,
    QUICK_LADDER,
    Ladder,
    angle_on,
    extrapolated_on,
)
from harness.cases.incline.checks import (
    FRICTIONS,
    PLASTIC_CASE,
    SLIGHT_FRICTIONS,
    first_jobs,
    friction_case,
    ladder_jobs,
    limits_dashpot,
)
from harness.cases.incline.closed_form import angle_or_nan, rebound
from harness.cases.incline.system import Incline
from harness.engines.base import Job, Output
from harness.errors import EngineError
from harness.model.law import CLIPPED, PLASTIC
from harness.report.content import Discs, Drawing, Opening, Section
from harness.theory.incline import INERTIA, STATIC_ANGLE_DEG, critical_angle, rolling_friction

if TYPE_CHECKING:
    from harness.report.figures import Figure

Angles = Mapping[float, float]  # [deg] by friction
Result = TypeVar("Result")
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


# ---- sections


def sections(benches: Mapping[str, Bench]) -> list[Section]:
    """Return the sections of a report on engines: the angle, contacts, friction."""
    return [_opening(benches), Section("The contacts", CONTACTS), *_friction(benches)]


def _opening(benches: Mapping[str, Bench]) -> Section:
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
            limit.draw,
        )
        for bench in benches.values()
        for ladder in (FULL_LADDER, Ladder(), QUICK_LADDER)
        if (limit := _measured(bench, ladder_jobs(PLASTIC_CASE, ladder),
                               extrapolated_on, ladder, PLASTIC_CASE))
    ]  # fmt: skip
    return Section("The critical angle", drawings=tuple(drawings[:1]), opening=opening)


def _friction(benches: Mapping[str, Bench]) -> Iterator[Section]:
    measured: dict[str, Angles] = {}
    judged: dict[str, Angles] = {}
    for bench in benches.values():
        cases = map(friction_case, (*SLIGHT_FRICTIONS, *FRICTIONS))
        angles = {
            case.friction: angle.value
            for case in cases
            if (angle := _measured(bench, first_jobs(case), angle_on, case))
        }
        if angles:
            measured[bench.engine.title] = angles
            limited = limits_dashpot(bench.engine)
            judged[bench.engine.title] = {
                mu: angle for mu, angle in angles.items() if limited and mu in FRICTIONS
            }
    if measured:
        drawing = Drawing(
            "critical-angle-friction",
            "Critical angle over friction",
            f"Equal spheres, k = 1e6 N/m, 50 steps: from {critical_angle():.4f} deg without "
            f"friction to {angle_or_nan(1.0, 'sphere', STATIC_ANGLE_DEG):.4f} deg without slip. "
            "Below: differences of the angles that are judged. Findings are above alone: little "
            "friction, where stiffness and step move the angle by hundredths of a degree, and "
            "codes whose dashpot Coulomb's limit leaves out.",
            partial(over_friction, measured, judged),
        )
        yield Section("Friction", FRICTION, drawings=(drawing,))


def _measured(
    bench: Bench, jobs: Sequence[Job], search: Callable[..., Result], *args: Any
) -> Result | None:
    """Return the result of a search whose first jobs were run, None where they were not."""
    try:
        return search(bench, *args) if bench.has_run(jobs) else None
    except EngineError:  # it has a failed row
        return None


# ---- figure and film


def over_friction(measured: Mapping[str, Angles], judged: Mapping[str, Angles]) -> Figure:
    """Draw the critical angle over friction: theory as a line, angles by friction of each engine.

    The panel below has the differences from theory of those that are judged.
    """
    from harness.report.figures import BLACK, COLOURS, MARKERS, Figure, label, legend_below

    figure = Figure(figsize=(7.2, 5.0), layout="constrained")
    top, bottom = figure.subplots(2, 1, sharex=True, height_ratios=(3, 1))
    most = max(friction for angles in measured.values() for friction in angles)
    frictions = np.concatenate([np.linspace(0.0, 0.12, 41), np.linspace(0.13, most, 20)])
    theory = [angle_or_nan(float(mu), "sphere", STATIC_ANGLE_DEG) for mu in frictions]
    top.plot(frictions, theory, color=BLACK, lw=1.2, label="theory, rigid grain")
    for number, (name, angles) in enumerate(measured.items(), 1):
        look = {
            "marker": MARKERS[number % 6],
            "color": COLOURS[number % 7],
            "mfc": "none",
            "ls": "",
        }
        title = name if judged[name] else f"{name} (findings)"
        top.plot([*angles], [*angles.values()], label=title, **look)
        errors = [
            1e3 * (angle - angle_or_nan(mu, "sphere", STATIC_ANGLE_DEG))
            for mu, angle in judged[name].items()
        ]
        bottom.plot([*judged[name]], errors, **look)
    bottom.axhline(0.0, color=BLACK, lw=1)
    bound = rolling_friction(STATIC_ANGLE_DEG, INERTIA["sphere"])
    if bound <= most:
        top.axvline(bound, color="0.5", ls=":", label=f"rolls without slip from {bound:.4f} on")
    label(top, "", "critical angle (deg)")
    label(bottom, "friction coefficient", "less theory\n(1e-3 deg)")
    legend_below(figure, 3)
    return figure


def discs(case: Incline, output: Output) -> Discs:
    """Return the grain over the row, tilted as it is, with its speed [m/s]."""
    path, d = path_in(output), case.diameter
    sine, cosine = math.sin(case.tilt), math.cos(case.tilt)

    def tilted(along: Any, above: Any) -> tuple[Any, Any]:
        return along * cosine + above * sine, above * cosine - along * sine

    x, y = (path[name] for name in ("x_m", "y_m"))
    places = np.arange(math.floor(float(x.min()) / d), math.ceil(float(x.max()) / d) + 2) * d
    row = np.column_stack([*tilted(places, 0.0 * places), np.full(len(places), 0.5 * d)])
    grain_x, grain_y = tilted(x, y)
    return Discs(
        f"The grain over the bumps at {case.angle:g} deg",
        path["time_s"],
        grain_x[:, None],
        grain_y[:, None],
        np.array([0.5 * case.grain]),
        fixed=row,
        value=np.hypot(path["vx_m_per_s"], path["vy_m_per_s"])[:, None],
        value_label="speed (m/s)",
    )
