"""Restitution on the incline: rigid spheres by events beside the reference DEM as it stiffens."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from harness.cases.case_text import Words
from harness.cases.contract import Measured
from harness.cases.incline.closed_forms import PASSAGES, rebound
from harness.cases.incline.critical_angles import critical_angle as critical_angle_in
from harness.cases.incline.critical_angles import critical_angles
from harness.cases.incline.extrapolation import step_limit
from harness.cases.incline.parameters import Incline
from harness.cases.incline.tolerances import RIGID
from harness.cases.runs import complete
from harness.comparison.convergence import Limit, limit
from harness.comparison.verdicts import Check, Kind, finding, judge
from harness.engines.reference.engine import Reference
from harness.hard_sphere.critical_angle import critical_angle, passage
from harness.hard_sphere.passage import MOVES_ON
from harness.parameters.contact import Contact
from harness.report.figures.style import BLUE, GREEN, ORANGE, RED, Figure, label, legend_below
from harness.report.sections import Section, Table
from harness.theory.critical_angle import critical_angle as of_shock
from harness.theory.shock import Reading, shock_from_restitution

WORDS = Words(__file__)

SOLVER = "hard-sphere"
TITLE = "Restitution: rigid spheres by events"

STEPS, FINEST = (100.0, 200.0, 400.0), 400.0
STIFFNESSES = {0.1: (1e6, 1e7, 1e8, 1e9), 0.3: (1e6, 1e7, 1e8, 1e9), 0.5: (1e5, 1e6, 1e7, 1e8)}
"""[N/m] by restitution. At 0.5 the grain still hops where a passage is judged: it is measured by
steady motion, a bisection, and at the finest step, where the step is worth less than that."""

EXPONENTS = (0.5, 1.0)
"""Of 1/k: a contact lasts as k^(-1/2)."""

READINGS: dict[Reading, str] = {"kept": "energy kept", "lost": "velocity lost"}


@dataclass(frozen=True)
class Stiffening:
    """Critical angles [deg] of the reference DEM at one restitution, and their limit."""

    restitution: float
    stiffnesses: tuple[float, ...]
    angles_deg: tuple[float, ...]
    rigid: Limit


def solve_rigid(case: Incline) -> Measured:
    """Return the passage of the grain over rigid spheres of the contact's restitution."""
    fate, energy, _, slid, _ = passage(case.angle, rebound(case.contact))
    moves = float(fate == MOVES_ON)
    values = {"margin_over_mgd": energy, "moves_on": moves, "touching": float(slid)}
    return Measured(values)


def rigid_checks(found: list[Stiffening]) -> Iterator[Check]:
    """Yield the reference DEM's limits against rigid spheres, and both readings beside them."""
    engine = Reference()
    for e, stiffnesses in STIFFNESSES.items():
        own = _stiffening(e, stiffnesses, engine)
        found.append(own)
        name = f"incline: e = {e:g}, reference DEM as k goes to infinity"
        value, error, exact = own.rigid.value, own.rigid.uncertainty, critical_angle(e)
        row = f"{name}, rigid spheres by events"
        yield judge(row, Kind.CROSS_CODE, value, exact, RIGID, uncertainty=error)
        for reading, words in READINGS.items():
            closed = of_shock(shock_from_restitution(e, reading))
            note = "the theory of one shock: the grain hops several times in a well"
            yield finding(f"{name}, one shock ({words})", value, closed, "deg", note, error)


def _stiffening(e: float, stiffnesses: Sequence[float], engine: Reference) -> Stiffening:
    contact = Contact(name=f"e = {e:g}", restitution=e)
    values, errors = [], []
    for k in stiffnesses:
        case = Incline(contact=contact, stiffness=k, steps_per_contact=FINEST)
        if e <= PASSAGES:
            cases = [case.replace(steps_per_contact=steps) for steps in STEPS]
            at = step_limit(complete(critical_angles(cases, engine)))
            values.append(at.value)
            errors.append(at.uncertainty)
        else:
            angle = critical_angle_in(case, method="steady", tolerance_deg=1e-3, engine=engine)
            values.append(angle.value_deg)
            errors.append(angle.uncertainty_deg)
    rigid = limit([1.0 / k for k in stiffnesses], values, errors, EXPONENTS)
    return Stiffening(e, tuple(stiffnesses), tuple(values), rigid)


def rigid_section(found: Sequence[Stiffening]) -> Section:
    """Return rigid spheres beside both readings of the theory, and the reference DEM if it ran."""
    dem = {one.restitution: one for one in found}
    rows = []
    for e in (0.0, *STIFFNESSES):
        one = dem.get(e)
        readings = (of_shock(shock_from_restitution(e, r)) for r in READINGS)
        measured = f"{one.rigid.value:.4f} ± {one.rigid.uncertainty:.1g}" if one else "-"
        rows.append(
            (f"{e:g}", f"{critical_angle(e):.4f}", measured, *(f"{r:.4f}" for r in readings))
        )
    columns = (
        "e",
        "rigid spheres (deg)",
        "reference DEM, k to infinity (deg)",
        *(f"one shock, {words} (deg)" for words in READINGS.values()),
    )
    table = Table("restitution", "", columns, tuple(rows), frozenset(range(len(columns))))
    drawing = WORDS.drawing("critical-angle-restitution", lambda: restitution_figure(found))
    return WORDS.section("rigid", tables=(table,), drawings=(drawing,))


def restitution_figure(found: Sequence[Stiffening]) -> Figure:
    """Draw the critical angle over the restitution."""
    figure = Figure(figsize=(7.5, 4.2))
    axes = figure.add_subplot()
    e = np.linspace(0.0, 0.6, 61)
    axes.plot(e, [critical_angle(x) for x in e], color=BLUE, label="rigid spheres, by events")
    for (reading, words), colour in zip(READINGS.items(), (ORANGE, GREEN), strict=True):
        closed = [of_shock(shock_from_restitution(x, reading)) for x in e]
        axes.plot(e, closed, "--", color=colour, label=f"one shock, {words}")
    for one in found:
        axes.errorbar(
            one.restitution,
            one.rigid.value,
            one.rigid.uncertainty,
            fmt="o",
            color=RED,
            label="reference DEM, k to infinity" if one is found[0] else None,
        )
    label(axes, "restitution e", "critical angle (deg)")
    legend_below(figure)
    return figure
