"""Say and draw what a report shows of a contact case.

Formulas of the law in a line each, errors over the step, force over overlap, the curves of a
cell's page (the law as a line, an engine's samples as points), and how to run each again.
"""

from __future__ import annotations

import math
import re
import shlex
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from harness.cases.contact.impact import overlap_of, published, relative_velocity
from harness.cases.contact.limits import (
    SCAN_STEPS,
    Evidence,
    Failed,
    RefinedTrial,
    Scanned,
    Tried,
    curve,
    rows_of,
)
from harness.cases.contact.motion import Array, Motion, asked_for, followed
from harness.cases.display import Display
from harness.cases.verification import places
from harness.comparison.verification import Findings
from harness.engines.registry import DEFAULT
from harness.parameters.allowed import unit_in
from harness.parameters.law import ContactLaw
from harness.parameters.rules import Rules
from harness.parameters.scene import ZERO, ContactScene, Vector
from harness.parameters.submodels import (
    ADHESION,
    BULK,
    EQUAL_E,
    EQUAL_G,
    NORMAL,
    RIGID,
    ROLLING,
    TANGENTIAL,
    TWISTING,
    TWO_E,
    TWO_G,
    YIELD,
)
from harness.report import style
from harness.report.sections import CellText, Drawing, Line, Plot, Section, Table
from harness.shown import in_words

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from harness.cases.contact.contact_case import ContactCase


def formulas(law: ContactLaw) -> Iterator[tuple[str, str]]:
    """Yield each part of a law that is there, and its formula."""
    for part, formula in _parts(law):
        two = formula.replace(EQUAL_E, TWO_E).replace(EQUAL_G, TWO_G)
        yield part, two if law.two_materials else formula


def _parts(law: ContactLaw) -> Iterator[tuple[str, str]]:
    """Yield parts and formulas for two bodies of one material."""
    yield "normal force", NORMAL[law.normal].formula
    if law.yield_stress is not None:
        yield "yield", YIELD
    if law.normal == "mdr" and law.surface_energy:
        yield "adhesion", ADHESION
    if law.bulk_response:
        yield "bulk response", BULK
    dashpot = law.dashpot.formula
    if law.damping != "none":
        ends = ", and no attraction" if law.clipped else ""
        dashpot = f"F_n = F + eta_n d(delta)/dt{ends}; {dashpot}"
    yield "normal damping", dashpot
    if law.tangential != "none":
        limit = "F_t is at most mu |F_n|"
        mine = RIGID if law.normal == "mdr" and "mindlin" in law.tangential else ""
        formula = f"{TANGENTIAL[law.tangential].formula}{mine}; eta_t = x_t eta_n; {limit}"
        yield "tangential force", formula
    if law.rolling != "none":
        yield "rolling resistance", ROLLING[law.rolling].formula
    if law.twisting != "none":
        yield "twisting resistance", TWISTING[law.twisting].formula


INVARIANCES = {
    "turned": "the scene is turned: z points across all axes; the motion is turned back",
    "mirrored": "the turned scene in a mirror; held against the turned one",
    "moved": "the turned scene from a frame that moves at a constant speed",
    "in other units": "lengths and times 4096 times smaller, at the same density and speed",
    "axes exchanged": "x, y and z take one another's places, walls with them",
    "renumbered": "the bodies in the opposite order",
    "reversed in time": "from the end of the run, all velocities reversed; elastic contacts only",
    "newton on": "each pair of particles is computed once, its force given to both",
    "thin neighbour skin": "a list of neighbours that ends closer to the spheres",
    "neighbours at every step": "the list of neighbours is made anew at every step",
    "neighbours from bins": "the list of neighbours is made from bins in place of all pairs",
    "stiffnesses as input": "the input has Hertz's stiffness 4/3 E* in place of modulus and ratio",
    "over a periodic boundary": "the contact lies across a boundary that is periodic",
    "2 ranks": "the contact lies across two ranks of MPI",
    "4 ranks": "the contact lies across ranks of MPI, four in all",
    "with LAMMPS's defaults": "newton on, bins, particles sorted: a script that sets nothing",
    "particles sorted": "particles change their order in memory during the run",
    "continued without setup": "stopped between two samples and continued without setup of forces",
    "continued with a setup": "stopped between two samples and continued with forces set up anew",
    "restarted": "written to a restart file between two samples, read back and continued",
}
"""What was changed of a run, by invariance; what may differ is the reason of its tolerance."""

COLUMNS = 2
BELOW: dict[str, Any] = {
    "ncols": 2,
    "fontsize": "x-small",
    "loc": "upper center",
    "bbox_to_anchor": (0.5, -0.22),
}
"""Where a panel has its legend: inside it would hide lines."""
OLD = "old"
"""The first word of submodels of an earlier interface."""


def errors_over_step(
    refined: Sequence[RefinedTrial], name: str, words: str, engine: str
) -> style.Figure:
    """Draw the error of a quantity over the steps of a contact, one line a submodel.

    ``words`` name it with its unit.
    """
    figure, placed = _panels(refined)
    steps = sorted({1.0 / h for trial in refined for x in trial.limits.values() for h in x.h})
    for axes, members in placed:
        for number, trial in enumerate(members):
            reached, expected = trial.limits.get(name), trial.references.get(name)
            if reached is not None and expected is not None:
                error = np.abs(reached.y - expected.value)
                error[error == 0.0] = np.nan
                axes.plot(
                    1.0 / reached.h, error, **_look(number, trial), marker=style.MARKERS[number % 6]
                )
        axes.set(
            xscale="log", yscale="log", xlabel="steps of a contact", ylabel=f"error of {words}"
        )
        style.few_ticks(axes, steps, most=4)
        axes.legend(**BELOW)
    figure.suptitle(engine, fontsize="medium", x=0.01, ha="left")
    return figure


def force_over_overlap(refined: Sequence[RefinedTrial], engine: str) -> style.Figure:
    """Draw the normal force over the overlap of each submodel, at the finest step."""
    figure, placed = _panels(refined)
    for axes, members in placed:
        for number, trial in enumerate(members):
            overlap, _ = overlap_of(trial.trial.parameters, trial.motion)
            touching = overlap > -0.05 * overlap.max()
            force = trial.motion.force[touching, 0, 2]
            axes.plot(1e6 * overlap[touching], force, **_look(number, trial))
        axes.set(xlabel="overlap (µm)", ylabel="force on the sphere (N)")
        axes.legend(**BELOW)
    figure.suptitle(engine, fontsize="medium", x=0.01, ha="left")
    return figure


def _panels(
    refined: Sequence[RefinedTrial],
) -> tuple[style.Figure, list[tuple[Axes, list[RefinedTrial]]]]:
    """Return axes for each family of submodels, the first word of their names."""
    families: dict[str, list[RefinedTrial]] = {}
    for trial in {trial.trial.submodel: trial for trial in reversed(refined)}.values():
        families.setdefault(re.split(r"[ ,_/]", trial.trial.submodel)[0], []).insert(0, trial)
    names = list(families)[::-1]
    columns = min(COLUMNS, len(names))
    figure = style.panels(-(-len(names) // columns), columns, width=8.0 / columns, height=3.3)
    for axes in figure.axes[len(names) :]:
        axes.remove()
    placed = []
    for name, axes in zip(names, figure.axes, strict=True):
        axes.set_title("earlier styles" if name == OLD else name)
        placed.append((axes, families[name]))
    return figure, placed


def _look(number: int, trial: RefinedTrial) -> dict[str, Any]:
    return {
        "color": style.COLOURS[number % len(style.COLOURS)],
        "ls": style.STYLES[number % len(style.STYLES)],
        "mfc": "none",
        "lw": 1.2,
        "label": in_words(trial.trial.submodel),
    }


def codes_over_parameter(
    case: ContactCase[Any], codes: Sequence[tuple[str, Sequence[Scanned]]]
) -> style.Figure:
    """Draw what codes found, by their titles, on the law under the default rules."""
    families = sorted({points.family for _, scanned in codes for points in scanned})
    figure = style.panels(1, len(families), width=8.0 / len(families), height=4.6)
    x, scan = np.array(case.scan.values), case.scan
    fields = type(case.default).model_fields
    unit = unit_in(fields[scan.parameter].description or "")
    units = {quantity.name: quantity.unit for quantity in case.quantities}
    for axes, family in zip(figure.axes, families, strict=True):
        here = [
            (code, points)
            for code, scanned in codes
            for points in scanned
            if points.family == family
        ]
        for number, name in enumerate(dict.fromkeys(points.submodel for _, points in here)):
            law = curve(case, rows_of(case, name), Rules())
            axes.plot(
                x,
                law,
                color=style.COLOURS[0],
                ls=style.STYLES[number],
                lw=1.0,
                label=in_words(name),
            )
        for code, points in here:
            number = [title for title, _ in codes].index(code)
            colour = style.COLOURS[1 + number % (len(style.COLOURS) - 1)]
            axes.plot(x, points.expected, color=colour, lw=0.7)
            axes.plot(
                x,
                points.measured,
                style.MARKERS[number % len(style.MARKERS)],
                color=colour,
                mfc="none",
                ms=4.0 + 1.5 * number,
                label=f"{code} ({points.apart:.0e})",
            )
        name = in_words(scan.quantity, units[scan.quantity])
        axes.set_ylabel(style.quantity(name, units[scan.quantity]))
        axes.set_xlabel(style.quantity(in_words(scan.parameter), unit))
        axes.legend(fontsize="x-small", ncols=2, loc="upper center", bbox_to_anchor=(0.5, -0.18))
    return figure


POINTS = 60
"""Of a curve, at least."""

DRAWN = 1e-10
"""[overlap, speed of the contact] local error of a step, for a line on a page."""

MOST_SAMPLES = 60
"""Of an engine, that are drawn."""

ANGLES = np.array([*range(5, 61, 5), 70.0, 80.0, 85.0])
"""[deg] of the velocity at the contact to the normal. Closer where a law takes turns between
sticking and sliding."""


def errors_plot(case: ContactCase[Any], trial: RefinedTrial) -> Plot:
    """Return the error of each quantity over the steps of a contact."""
    units = {quantity.name: quantity.unit for quantity in case.quantities}
    lines = []
    for name, reached in trial.limits.items():
        expected = trial.references.get(name)
        if expected is not None:
            scale = 1.0 if units[name] == "1" else abs(expected.value) or 1.0
            error = np.abs(reached.y - expected.value) / scale
            lines.append(Line(in_words(name, units[name]), 1.0 / reached.h, error))
    return Plot(
        "Error over the step",
        "Distance from what the law asks for, relative for what has a unit.",
        "steps of a contact",
        "error",
        tuple(lines),
        logarithmic=True,
        group=trial.trial.system,
    )


def trial_plot(case: ContactCase[Any], trial: Tried, engine: str) -> Plot:
    """Return what a page shows of a trial in an engine, beside the errors: motion or ratio."""
    # of mdr between spheres an integration takes seconds at glancing angles, or minutes
    slow = trial.finest.normal == "mdr" and trial.finest.partner != "wall"
    if case.over_angle is None or slow:
        return motion_plot(case, trial, engine)
    return ratio_plot(case, trial, engine, case.over_angle)


def motion_plot(case: ContactCase[Any], trial: Tried, engine: str) -> Plot:
    """Return the motion of a trial: the law integrated, and an engine's samples if it left some.

    The samples alone of a motion that no scene has.
    """
    parameters, integrated = trial.finest, case.is_integrated(trial.finest)
    x_name, y_name = case.axes(parameters)
    drawn = [("the law", _law(case.scene(parameters), trial.rules), 1)] if integrated else []
    if isinstance(trial, RefinedTrial):
        drawn.append((engine, trial.motion, _thinned(trial.motion) if integrated else 1))
    lines = [
        Line(f"{name}, {by}" if name else by, x[::every], y[::every], marked=by == engine)
        for by, motion, every in drawn
        for name, (x, y) in case.curves(parameters, motion).items()
    ]
    # a code that tells no forces has no points in a figure of forces
    sampled = any(line.marked and np.isfinite(line.y).any() for line in lines)
    samples = "samples of the run with the finest step" if sampled else f"no points of {engine}"
    title = f"{y_name.partition(' (')[0]} over {x_name.partition(' (')[0]}"
    return Plot(
        title[:1].upper() + title[1:],
        f"The law integrated; {samples}."
        if integrated
        else "Samples of the run with the finest step; the closed form is that of the quantities.",
        x_name,
        y_name,
        tuple(lines),
        group=trial.trial.system,
    )


def _law(scene: ContactScene, rules: Rules) -> Motion:
    """Return the motion of a scene with samples enough for a line."""
    every = _finer(scene)
    if every == scene.every:  # as it was integrated when it was judged
        return followed(scene, rules).motion
    return followed(replace(scene, every=every), rules, DRAWN).motion


def _thinned(motion: Motion) -> int:
    """Return how many samples of a motion stand for one that is drawn."""
    return max(1, len(motion.time) // MOST_SAMPLES)


def _finer(scene: ContactScene) -> int:
    """Return a sampling that leaves enough points, if it can be one that divides the scene's."""
    wanted = max(1, scene.steps // POINTS)
    if scene.every <= wanted:
        return scene.every
    divides = next(n for n in range(wanted, 0, -1) if scene.every % n == 0)
    return divides if 4 * divides >= wanted else wanted


@dataclass(frozen=True)
class OverAngle:
    """A ratio over the angle of the velocity at the contact to the normal.

    ``quantity`` is that ratio and ``parameter`` what sets the angle; ``value`` gives the parameter
    of an angle [deg], ``angle`` the angle of a run, ``sent`` velocity [m/s] and angular velocity
    [rad/s] of the sphere, and ``ratio`` the quantity for what is left of the velocity at the
    contact: the literature's curve.
    """

    quantity: str
    parameter: str
    title: str
    y: str
    value: Callable[[Any, float], float]
    angle: Callable[[Any], float]
    sent: Callable[[Any], tuple[Vector, Vector]]
    ratio: Callable[[Any, Array], Array]


def ratio_plot(case: ContactCase[Any], trial: Tried, engine: str, over: OverAngle) -> Plot:
    """Return a ratio over the angle: the law, the literature's curve, and an engine's limit."""
    parameters = trial.finest
    values = [over.value(parameters, float(angle)) for angle in ANGLES]
    of_law = expected_scan(case, trial, over.parameter, values, over.sent)
    lines, note = [Line("the law", ANGLES, of_law[over.quantity])], "The law integrated"
    curve = published(parameters, _restitution(case, trial))
    if curve is not None:
        lines.append(Line(curve.name, curve.angles, over.ratio(parameters, curve.ratio)))
        note += f"; {curve.source}"
    if isinstance(trial, RefinedTrial):
        reached = trial.limits[over.quantity].value
        lines.append(Line(engine, [over.angle(parameters)], [reached], marked=True))
        note += f"; {engine} in the limit of a small step"
    else:
        note += f"; {engine} has no point here"
    return Plot(
        over.title,
        f"{note}.",
        "angle to the normal (deg)",
        over.y,
        tuple(lines),
        group=trial.trial.system,
    )


def _restitution(case: ContactCase[Any], trial: Tried) -> float:
    """Return the restitution at the normal velocity of a trial, without friction to act.

    Of an oblique impact the normal turns, and what comes back along the first is not all of it.
    """
    base = case.scene(trial.finest)
    before = base.bodies[0].velocity[2]
    bodies = tuple(replace(body, omega=ZERO) for body in base.bodies)
    bodies = (replace(bodies[0], velocity=(0.0, 0.0, before)), *bodies[1:])
    motion = followed(replace(base, bodies=bodies, every=base.steps), trial.rules, DRAWN).motion
    return float(relative_velocity(motion)[-1, 2]) / -before


def expected_scan(
    case: ContactCase[Any],
    trial: Tried,
    name: str,
    values: Sequence[float],
    sent: Callable[[Any], tuple[Vector, Vector]],
) -> Mapping[str, Array]:
    """Return the quantities of an impact that the law asks for, over values of a parameter.

    ``sent`` tells velocity [m/s] and angular velocity [rad/s] of the sphere from the parameters.
    A run lasts twice as long as that of the trial: a slower impact is over by then.
    """
    base = case.scene(trial.finest)
    rows = []
    for value in values:
        changed = trial.finest.replace(**{name: float(value)})
        velocity, omega = sent(changed)
        first = replace(base.bodies[0], velocity=velocity, omega=omega)
        steps = 2 * base.steps
        scene = replace(base, bodies=(first, *base.bodies[1:]), steps=steps, every=steps)
        rows.append(case.observed(changed, followed(scene, trial.rules, DRAWN).motion))
    return {quantity: np.array([row[quantity] for row in rows]) for quantity in rows[0]}


class ContactDisplay(Display):
    """Shows errors over the step, all codes on the law, and a page for each cell of the matrix."""

    case: ContactCase[Any]

    def drawings(self, evidence: Evidence) -> Sequence[Drawing]:
        """Return the figures of a case: the error of a quantity over the step."""
        return (errors_drawn(self.case, evidence),)

    def sections(
        self, main: Findings | None, solvers: Findings, engines: Mapping[str, Findings]
    ) -> Sequence[Section]:
        """Return one section with the figures of a case.

        Values, errors and runs are on pages of the matrix's cells, those of other engines, too.
        """
        if main is None or not main.evidence:
            return ()
        case, evidence = self.case, main.evidence
        drawings = tuple(self.drawings(evidence)) if evidence.refined and evidence.drawn else ()
        with_evidence = [findings for findings in engines.values() if findings.evidence]
        scans = [
            (findings.evidence.engine_title, findings.evidence.scans) for findings in with_evidence
        ]
        if any(scanned for _, scanned in scans):
            drawings = (codes_drawn(case, scans), *drawings)
        # the main engine may stand beside itself, with more submodels
        by_engine = {findings.engine: findings for findings in (main, *with_evidence)}
        cells = tuple(cell for engine in by_engine.values() for cell in self._cells(engine))
        text = (case.summary, case.formula)
        return (Section(f"Contact: {case.name}", text, (), (), drawings, cells),)

    def _cells(self, findings: Findings) -> Iterator[CellText]:
        """Yield the text of each submodel, in all its systems in the order of the case."""
        case, evidence = self.case, findings.evidence
        systems = [*case.systems]
        by_submodel: dict[str, list[Tried]] = {}
        for trial in evidence.tried:
            by_submodel.setdefault(trial.trial.submodel, []).append(trial)
        for name, cell in by_submodel.items():
            cell.sort(key=lambda trial: systems.index(trial.trial.system))
            failed = [trial for trial in cell if isinstance(trial, Failed)]
            formula = Table(
                "The law",
                "n points to the first sphere, m* and R* are the reduced mass and radius.",
                ("part", "formula"),
                (*formulas(cell[0].finest.law), *_rules(case, cell)),
            )
            yield CellText(
                case.name,
                name,
                findings.engine,
                evidence.engine_title,
                (
                    case.summary,
                    f"Expected: {case.formula}",
                    *(
                        f"{trial.trial.system}: {evidence.engine_title} {trial.why}."
                        for trial in failed
                    ),
                ),
                (*_asked_of(case, failed), formula, _parameters(cell)),
                tuple(pair for trial in cell for pair in _commands(case, trial, findings.engine)),
                partial(self._plots, cell, evidence),
                frozenset(name for trial in cell for name in _inputs(case, trial)),
                INVARIANCES,
            )

    def _plots(self, cell: Sequence[Tried], evidence: Evidence) -> Sequence[Plot]:
        """Return the plots of a submodel; without the curves of the law at level quick."""
        plots = []
        for trial in cell:
            plots += [trial_plot(self.case, trial, evidence.engine_title)] if evidence.drawn else []
            plots += [errors_plot(self.case, trial)] if isinstance(trial, RefinedTrial) else []
        return plots


def _commands(case: ContactCase[Any], trial: Tried, engine: str) -> Iterator[tuple[str, str]]:
    """Yield what repeats a trial: by the harness, and by hand."""
    system = trial.trial.system
    place = places(case.name, trial.trial.submodel, system)[-1]
    engines = "" if engine == DEFAULT else f" --engine {engine}"
    verify = f"dem-harness verify --only {shlex.quote(place)}{engines}"
    yield f"{system}: its rows, on the whole ladder of steps", verify
    yield f"{system}: the case at its coarsest step", _again(case, trial, engine)
    if trial.command:
        which = "that failed" if isinstance(trial, Failed) else "with the finest step"
        yield f"{system}: the run {which}", trial.command


def _inputs(case: ContactCase[Any], trial: Tried) -> tuple[str, str]:
    """Return the names of the scripts that state a trial: of all variants, or of its own."""
    job = case.job(trial.trial.parameters)
    return job.template.name, f"{job.template.name}-{job.variant}"


def _asked_of(case: ContactCase[Any], failed: Sequence[Failed]) -> Iterator[Table]:
    """Yield a table of the references of trials that failed."""
    units = {quantity.name: quantity.unit for quantity in case.quantities}
    rows = tuple(
        (
            trial.trial.system,
            in_words(name, units[name]),
            f"{expected.value:.9g}",
            units[name].removeprefix("1"),
            expected.kind,
        )
        for trial in failed
        for name, expected in trial.references.items()
        if math.isfinite(expected.value)
    )
    if rows:
        yield Table(
            "What the law asks for",
            "Where the run left nothing to be held against it.",
            ("system", "quantity", "reference", "unit", "by"),
            rows,
        )


def _rules(case: ContactCase[Any], cell: Sequence[Tried]) -> Iterator[tuple[str, str]]:
    """Yield the rules of the engine that are not the default ones and matter, in any system."""
    changed: dict[str, Any] = {}
    for trial in cell:
        rules = asked_for(case.scene(trial.finest), trial.rules)
        changed |= rules.model_dump(exclude_defaults=True)
    for name, value in changed.items():
        meaning = (Rules.model_fields[name].description or "").partition("] ")[2]
        yield f"rule: {in_words(name)}", f"{in_words(str(value))} ({meaning})"


def _parameters(cell: Sequence[Tried]) -> Table:
    """Return the parameters of the first system, with units, and where the others differ."""
    rows = []
    for name, field in type(cell[0].finest).model_fields.items():
        values = [getattr(trial.finest, name) for trial in cell]
        if any(value is not None for value in values):
            unit, _, meaning = (field.description or "[-] ").removeprefix("[").partition("] ")
            texts = [_as_text(value) for value in values]
            text_of_all = (
                texts[0]
                if len({*texts}) == 1
                else "; ".join(
                    f"{trial.trial.system}: {text}" for trial, text in zip(cell, texts, strict=True)
                )
            )
            rows.append((in_words(name), text_of_all, "" if unit == "-" else unit, meaning))
    head = ("parameter", "value", "unit", "meaning")
    caption = "Of the run with the finest step; with --set NAME=VALUE, its words joined by _."
    return Table("Parameters", caption, head, tuple(rows))


def _as_text(value: Any) -> str:
    if value is None:
        return "none"
    return f"{value:.9g}" if isinstance(value, float) else str(value).lower()


def errors_drawn(case: ContactCase[Any], evidence: Evidence) -> Drawing:
    """Return the figure of the errors of a case's first quantity."""
    from harness.report.style import quantity

    first = next(
        candidate
        for candidate in case.quantities
        if candidate.name == (case.drawn_quantity or candidate.name)
    )
    words = in_words(first.name, first.unit)
    return Drawing(
        f"{case.name}-errors",
        f"{case.name}: error over the step",
        f"How far the {words} is from what the law asks for, over the steps of a contact; a panel "
        "for each family of submodels.",
        lambda: errors_over_step(
            evidence.refined, first.name, quantity(words, first.unit), evidence.engine_title
        ),
    )


def codes_drawn(case: ContactCase[Any], codes: Sequence[tuple[str, Sequence[Scanned]]]) -> Drawing:
    """Return the figure of a case with all codes, by their titles, on the reference curves."""
    return Drawing(
        f"{case.name}-codes",
        f"{case.name}: all codes on the reference curve",
        "Lines: the law integrated, black under the default rules, in colour under a code's own; "
        f"marks: codes, {SCAN_STEPS} steps a contact. Behind a name: how far it is at most from "
        "the law under its own rules, as a part of the largest value.",
        lambda: codes_over_parameter(case, codes),
    )


def _again(case: ContactCase[Any], trial: Tried, engine: str) -> str:
    settings = " ".join(f"--set {name}={value}" for name, value in _changes(case, trial))
    return f"dem-harness run {case.name} --engine {engine} {settings}"


def _changes(case: ContactCase[Any], trial: Tried) -> Iterator[tuple[str, Any]]:
    """Yield what a trial changes of the default parameters."""
    base = dict(case.default)
    for name, value in trial.trial.parameters:
        if value is not None and base[name] != value:
            yield name, str(value).lower() if isinstance(value, bool) else value
