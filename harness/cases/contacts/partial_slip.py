"""Elastic impacts with Mindlin's springs, which stick or slip as a whole, and with partial slip.

Maw, Barber and Fawcett, Wear 38, 101 (1976): the contact of a real sphere sticks inside and slips
outside. The normalised incidence is psi = 2 (1 - nu) / (mu (2 - nu)) times the tangential over the
normal velocity at the contact.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from harness.cases.base import Check, Value
from harness.cases.bench import OWN, Bench
from harness.cases.contacts import tables
from harness.cases.contacts.contact_case import ContactCase
from harness.cases.equal_steps import REASON, ROUND_OFF
from harness.engines.base import scene_job
from harness.errors import EngineError
from harness.model.motion import Floats
from harness.report.content import Drawing
from harness.results.rows import Kind, Tolerance
from harness.theory.contact import partial_slip_rebound, stiffness_ratio

if TYPE_CHECKING:
    from harness.engines.base import Engine, Job
    from harness.report.style import Figure

LAWS = ("mindlin", "mindlin/force", "mindlin_rescale", "mindlin_rescale/force")
INCIDENCES = np.array([0.25, 0.5, 1.0, 1.5, 2.0, 2.5, 3.0, 3.5, 4.0, 4.5, 5.0, 6.0])
FRICTION, POISSON = 0.3, 0.3
STEPS = 400  # of a contact
QUANTITY = "normalised_rebound"
DIFFERENCE = "rebound_difference"


def impacts(case: ContactCase[Any], law: str) -> list[Any]:
    """Return the impacts of an elastic sphere on a wall of its material, 1 m/s to the normal."""
    base = case.default.replace(
        **tables.part("hertz"), damping="none", tangential=law, tangential_damping=0.0,
        friction=FRICTION, steps_per_contact=STEPS,
    )  # fmt: skip
    angles = np.arctan(INCIDENCES * FRICTION / stiffness_ratio(POISSON))
    return [base.replace(angle=math.degrees(a), speed=1.0 / math.cos(a)) for a in angles]


def jobs(case: ContactCase[Any], law: str) -> list[Job]:
    """Return the jobs of the impacts of a law."""
    return [scene_job(case.scene(p)) for p in impacts(case, law)]


def rebounds(case: ContactCase[Any], law: str, bench: Bench, *, measured: bool) -> Floats:
    """Return the rebounds (M,) of a law at :data:`INCIDENCES`, by the engine or the reference."""
    found = []
    for psi, p in zip(INCIDENCES, impacts(case, law), strict=True):
        scene = case.scene(p)
        motion = bench.motion(scene) if measured else bench.reference(scene)
        ratios = case.observe(p, motion)
        slip = ratios["tangential_ratio"] - ratios["rim_speed_ratio"]
        found.append(psi * slip / ratios["normal_restitution"])
    return np.array(found)


def own_checks(case: ContactCase[Any]) -> Iterator[Check]:
    """Yield a finding for each law: its rebound where it is farthest from partial slip."""
    for law in LAWS:
        yield Check(
            setup=f"{law}, wall, partial slip",
            quantity=QUANTITY,
            unit="1",
            measure=partial(_farthest, case, law),
            expected=partial(_expected_at, case, law),
            kind=Kind.FINDING,
            level="default",
        )


def checks(case: ContactCase[Any], engine: Engine) -> Iterator[Check]:
    """Yield the check of the first of these laws that an engine states."""
    for law in LAWS:
        needed = jobs(case, law)
        if not any(engine.refuses(job) for job in needed):
            yield Check(
                setup=f"{law}, wall, partial slip",
                quantity=DIFFERENCE,
                unit="1",
                measure=partial(_difference, case, law),
                expected=0.0,
                tolerance=Tolerance(absolute=ROUND_OFF * float(INCIDENCES[-1]), reason=REASON),
                level="default",
                jobs=needed,
                note="largest difference from the reference of 12 impacts, drawn in the report",
            )
            return


def _difference(case: ContactCase[Any], law: str, bench: Bench) -> float:
    two = (rebounds(case, law, bench, measured=each) for each in (True, False))
    return float(np.abs(np.subtract(*two)).max())


def _farthest(case: ContactCase[Any], law: str, bench: Bench) -> Value:
    reached = bench.once(rebounds, case, law, bench, measured=False)
    at = int(np.abs(reached - partial_slip_rebound(INCIDENCES, POISSON)).argmax())
    note = f"farthest from partial slip at psi = {INCIDENCES[at]:g} of 0.25 to 6, elastic"
    return Value(float(reached[at]), note=note)


def _expected_at(case: ContactCase[Any], law: str, bench: Bench) -> float:
    reached = bench.once(rebounds, case, law, bench, measured=False)
    curve = partial_slip_rebound(INCIDENCES, POISSON)
    return float(curve[int(np.abs(reached - curve).argmax())])


# ---- the figure


def drawing(case: ContactCase[Any], benches: Mapping[str, Bench]) -> Drawing | None:
    """Return Maw's curve with the laws by the reference and all codes that have run them."""
    marks: dict[str, Floats] = {}
    for name, bench in benches.items():
        for law in LAWS if name != OWN else ():
            if bench.has_run(jobs(case, law)):
                try:
                    found = rebounds(case, law, bench, measured=True)
                except EngineError:
                    continue
                marks[f"{bench.engine.title}, {law}"] = found
    if not marks:
        return None
    own = benches.get(OWN) or Bench(None)
    lines = {law: own.once(rebounds, case, law, own, measured=False) for law in LAWS}
    return Drawing(
        "oblique-partial-slip",
        "Laws that stick as a whole, and partial slip",
        "Velocity at the contact after over that before, both over mu times the normal one and "
        "times 2 (1 - nu) / (2 - nu), elastic sphere on a wall of its material, nu = 0.3. Lines: "
        "the laws by the reference under LAMMPS's conventions; marks: codes under their own, each "
        f"within {ROUND_OFF:g} of the reference under these. {STEPS} steps a contact.",
        lambda: figure(lines, marks),
    )


def figure(laws: Mapping[str, Floats], codes: Mapping[str, Floats]) -> Figure:
    """Draw Maw's curve, the rebounds of laws as lines and of codes as marks, each (M,)."""
    from harness.report.style import BLACK, COLOURS, MARKERS, STYLES, legend_below, panels

    drawn = panels(1, 1, width=8.0, height=4.4)
    axes = drawn.axes[0]
    psi = np.linspace(0.0, INCIDENCES[-1], 121)
    name = "partial slip: Maw, Barber and Fawcett 1976"
    axes.plot(psi, partial_slip_rebound(psi, POISSON), color=BLACK, lw=2.0, label=name)
    for number, (law, reached) in enumerate(laws.items(), 1):
        axes.plot(INCIDENCES, reached, color=COLOURS[number], ls=STYLES[number], label=law)
    for number, (code, reached) in enumerate(codes.items()):
        marker = MARKERS[number % len(MARKERS)]
        size = 4.0 + 1.5 * number
        axes.plot(INCIDENCES, reached, marker, color="0.25", mfc="none", ms=size, label=code)
    axes.set(xlabel="normalised incidence", ylabel="normalised rebound")
    legend_below(drawn)
    return drawn
