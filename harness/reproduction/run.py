"""Recompute the source: its statements as a run of rows, and the report with its figures."""

from __future__ import annotations

import math
import platform
import time
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import pandas as pd
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from harness import __version__
from harness.cases.bench import OWN, Bench
from harness.cases.tower.impulse import (
    SPEEDS,
    STIFFNESSES,
    angle_figure,
    angle_from_impulse_ratio,
    structure_end,
    turnaround,
)
from harness.cases.tower.parameters import LAWS, Tower
from harness.errors import RequestError
from harness.report.content import Drawing, Section, Table, power
from harness.report.figures import (
    BLACK,
    BLUE,
    COLOURS,
    MARKERS,
    ORANGE,
    RED,
    STYLES,
    axis,
    label,
    legend_below,
    panels,
)
from harness.report.page import report_files
from harness.reproduction import CASE, REPRODUCED, STATUSES, Statement, chains, incline, towers
from harness.results.rows import table
from harness.store.cache import EngineChoice, opened
from harness.store.runs import Meta, Run, write_run

TITLE = "Harper, Dufek and Breard (arXiv:2409.13633), recomputed"
INTRODUCTION = """\
Each statement of the source that can be recomputed is a row: the printed value is expected, the
value comes by an independent route. A statement that does not hold is a finding; where a correction
makes it hold, a second row shows that. Nothing here is typed in."""

Progress = Callable[[str, int, int], None]


def subjects(bench: Bench | None) -> list[Iterator[Statement]]:
    """Return the statements by subject, in the order of the source; ``bench`` runs the incline."""
    return [
        chains.springs(), towers.rigid_limit(), incline.energies(), incline.energy_sums(),
        incline.angles(), incline.shocks(), incline.contact_and_rest(), incline.mfix_scheme(),
        incline.on_engine(bench), incline.rigidity(), incline.times(), towers.separation(),
        incline.rescaled_impulse(), chains.pairs(), towers.two_particles(),
        towers.three_particles(), chains.boundaries(), towers.transfer(), towers.collapse(),
        towers.three_on_a_base(), towers.impulses_over_height(), towers.angles_over_height(),
        chains.series_energy(), towers.energy_scaling(), chains.lengths(), chains.deformations(),
        chains.examples(), chains.contacts(), towers.packets(), towers.window(), chains.errata(),
        incline.errata(), towers.errata(),
    ]  # fmt: skip


@dataclass(frozen=True, repr=False)
class Reproduction(Run):
    """A run of rows, and the statements that the rows are of."""

    statements: Sequence[Statement] = ()


def reproduce(*, engine: EngineChoice = None, progress: Progress = lambda *_: None) -> Reproduction:
    """Recompute all statements of the source and return their rows.

    ``engine`` runs the incline: an open one, or a name, LAMMPS unless given, whose runs are kept.
    Raise EngineError for an engine that cannot be opened.
    """
    with opened(engine) as running:
        return recomputed(subjects(Bench(running)), progress)


def recomputed(
    parts: Sequence[Iterator[Statement]], progress: Progress = lambda *_: None
) -> Reproduction:
    """Return the rows of statements by subject."""
    started, clock = datetime.now(UTC).isoformat(timespec="seconds"), time.monotonic()
    statements: list[Statement] = []
    for done, part in enumerate(parts, 1):
        statements += part
        progress("parts of the source", done, len(parts))
    rows = [row for statement in statements for row in statement.rows]
    engines = {row.engine: row.version for row in rows if row.engine != OWN}
    meta = Meta(level="default", cases=(CASE,), engines=engines | {OWN: __version__},
                started=started, seconds=time.monotonic() - clock,
                platform=f"{platform.system()} {platform.machine()}",
                harness_version=__version__)  # fmt: skip
    return Reproduction(table(rows), meta, statements=statements)


def write_reproduction(run: Reproduction, folder: Path) -> None:
    """Write rows, pages and figures into a new folder. Raise RequestError as ``write_run`` does."""
    write_run(run, folder, report_files(run, sections(run), title=TITLE, headline=headline(run)))


def statuses(run: Reproduction) -> dict[str, str]:
    """Return the status of each statement by its key."""
    return {statement.key: statement.status.text for statement in run.statements}


def headline(run: Reproduction) -> str:
    """Return how many statements have each status."""
    return ", ".join(f"{number} {status}" for status, number in _counts(run).items() if number)


def _counts(run: Reproduction) -> dict[str, int]:
    numbers = Counter(statement.status for statement in run.statements)
    return {status.text: numbers[status] for status in STATUSES}


def sections(run: Reproduction) -> list[Section]:
    """Return the ledger of statements, the errata with their evidence, and the figures."""
    ledger, errata = [], []
    for statement in run.statements:
        row, status = statement.rows[0], statement.status
        text = {"where": statement.where, "the source states": statement.text}
        values = {
            "recomputed": row.value, "printed": row.expected,
            "unit": "" if row.unit == "1" else row.unit, "note": row.note,
        }  # fmt: skip
        ledger.append({**text, "status": status, **values})
        if statement.correction and status != REPRODUCED:
            evidence = f"{row.value:.7g} recomputed, {row.expected:.7g} as printed"
            errata.append({**text, "correction": statement.correction, "evidence": evidence,
                           "status": status.text})  # fmt: skip
    return [
        Section("Statements", INTRODUCTION, (
            Table("Status of the statements", pd.DataFrame([_counts(run)])),
            Table("Ledger", pd.DataFrame(ledger)),
        )),
        Section("Errata", "What has to be changed for a statement to hold.", (
            Table("Corrections", pd.DataFrame(errata)),
        )),
        Section("Figures", drawings=drawings()),
    ]  # fmt: skip


# ---- figures

TIME = "time t/t0"
HEIGHTS = range(1, 20)
TOUCHING = 1e-3  # [-] of the peak: a contact that a figure shows
EXACT = "Deformable law, exact propagator"


def drawings() -> tuple[Drawing, ...]:
    """Return the figures that the source's can be compared with, in its order."""
    figures: tuple[tuple[str, str, str, Callable[[], Figure]], ...] = (
        ("fig-06-two-and-three", "Velocity and deformation of two and three particles",
         f"{EXACT}, 1e6 N/m, 2 m/s, no gravity, last particle free.", two_and_three),
        ("fig-07-error", "Error of the peak deformation against stiffness",
         "Two particles by RK4. The source reports an error that falls, below 0.5 % from 1e4 N/m "
         "on.", error_against_stiffness),
        ("fig-08-force", "Force and contacts of 2, 3, 10 and 20 particles",
         f"{EXACT}, 1e6 N/m, 2 m/s.", force_and_contacts),
        ("fig-09-collapse", "Collapse across rigidity",
         f"{EXACT}, ten particles, 2 m/s: force over v0 sqrt(k m).", collapse),
        ("fig-10-ratio", "Impulse ratio against height",
         f"{EXACT}, turnaround window, the source's six runs.", impulse_ratios),
        ("fig-11-angle", "Critical angle against height",
         "From the same impulses, which rescale the velocity lost (solid) or kept (dashed). The "
         "band is published.", critical_angles),
        ("fig-13-energy", "Energy scaling",
         "Critical angle of alpha = 1/sqrt(n), which has no asymptote.", energy_scaling),
        ("fig-14-separation", "Contacts of the grain over time",
         f"{EXACT}, 1e6 N/m, 2 m/s: when the grain touches anything.", separation),
        ("fig-15-structure", "Critical angle of the structure window",
         "Missing points: the chain never swings from all contacts to one.", structure_window),
        ("fig-16-window", "Choice of the window",
         "Approach of grain and base, with the time of its maximum.", window_selection),
    )  # fmt: skip
    return tuple(
        Drawing(name, f"Figure {int(name[4:6])} of the source: {title}", caption, draw)
        for name, title, caption, draw in figures
    )


def two_and_three() -> Figure:
    """Draw velocities and deformations of two and of three particles."""
    figure = panels(2, 2, 4.2, 2.5)
    for column, count in enumerate((2, 3)):
        motion = towers.free_collision(count)
        above, below = figure.axes[column], figure.axes[2 + column]
        for i in range(count):
            look: dict[str, Any] = {"color": COLOURS[i], "ls": STYLES[i]}
            above.plot(motion.time_over_t0, motion.velocities[:, i], label=f"particle {i + 1}",
                       **look)  # fmt: skip
            below.plot(motion.time_over_t0, 1e3 * motion.deformations[:, i], **look)
        label(above, TIME, axis("velocity", "m/s"), f"{count} particles")
        label(below, TIME, axis("deformation", "mm"))
    legend_below(figure, 3)
    return figure


def error_against_stiffness() -> Figure:
    """Draw the error of the largest deformation for a scaled and a fixed step."""
    figure = panels(1, 1, 6.4, 3.6)
    axes = figure.axes[0]
    names = ("50 steps per contact time", f"one step, {towers.STEP:g} s")
    for i, (name, errors) in enumerate(zip(names, towers.peak_errors(), strict=True)):
        look: dict[str, Any] = {"color": COLOURS[i + 1], "marker": MARKERS[i], "ls": STYLES[i]}
        axes.loglog(towers.ERROR_STIFFNESSES, errors, label=name, **look)
    axes.plot([1e4, 1e6], [0.5, 0.5], color="0.5", lw=3, label="source: falling, and below this")
    label(axes, axis("stiffness", "N/m"), axis("error of the peak deformation", "%"))
    legend_below(figure)
    return figure


def force_and_contacts() -> Figure:
    """Draw the force on the grain and the contacts of its chain over time."""
    figure = panels(2, 4, 2.6, 2.2)
    for column, height in enumerate((1, 2, 9, 19)):
        tower = towers.run(Tower(height=height))
        above, below = figure.axes[column], figure.axes[4 + column]
        above.plot(tower.time_over_t0, 1e-3 * tower.grain_force, color=BLUE)
        contacts = tower.contacts_above(TOUCHING * float(tower.grain_force.max()))
        below.step(tower.time_over_t0, contacts, where="post", color=BLACK)
        label(above, "", axis("force", "kN") if column == 0 else "", f"{height + 1} particles")
        label(below, TIME, "contacts" if column == 0 else "")
    return figure


def collapse() -> Figure:
    """Draw scaled forces of three stiffnesses."""
    figure = panels(1, 1, 6.4, 3.4)
    for i, stiffness in enumerate(STIFFNESSES):
        tower = towers.run(Tower(height=9, stiffness=stiffness))
        force = tower.grain_force / (tower.tower.speed * tower.tower.omega)
        figure.axes[0].plot(tower.time_over_t0, force, color=COLOURS[i], ls=STYLES[i],
                            label=f"k = {power(stiffness)} N/m")  # fmt: skip
    label(figure.axes[0], TIME, "force / (v0 sqrt(k m))")
    legend_below(figure, 3)
    return figure


def separation() -> Figure:
    """Draw when the grain touches anything, for chains of several lengths."""
    figure = panels(1, 1, 7.0, 2.8)
    heights = (1, 2, 3, 9, 19)
    for row, height in enumerate(heights):
        bars = [(begin, end - begin) for begin, end in towers.intervals(height)]
        figure.axes[0].broken_barh(bars, (row - 0.3, 0.6), color=COLOURS[row + 1])
    figure.axes[0].set_yticks(range(len(heights)), [f"{n + 1} particles" for n in heights])
    label(figure.axes[0], TIME, "")
    return figure


def window_selection() -> Figure:
    """Draw the approach of grain and base with its maximum, and the end of the structure window."""
    figure = panels(1, 3, 2.9, 2.6)
    for axes, height in zip(figure.axes, (2, 3, 4), strict=True):
        tower = towers.run(Tower(height=height))
        t0 = tower.tower.contact_time
        axes.plot(tower.time_over_t0, 1e3 * tower.compression, color=BLUE, label="approach")
        axes.axvline(turnaround(tower) / t0, color=BLACK, ls="--", label="largest approach")
        try:
            end = structure_end(tower) / t0
        except RequestError:
            end = math.nan
        axes.axvline(end, color=ORANGE, ls=":", label="end of the structure window")
        label(axes, TIME, axis("approach", "mm"), f"{height + 1} particles")
    legend_below(figure, 3)
    return figure


def impulse_ratios() -> Figure:
    """Draw alpha(n) of the six runs."""
    figure = panels(1, 1, 6.4, 3.8)
    for (stiffness, speed), alpha in towers.ratios().items():
        k, v = STIFFNESSES.index(stiffness), SPEEDS.index(speed)
        look: dict[str, Any] = {"color": COLOURS[k + 1], "marker": MARKERS[k], "ls": STYLES[v]}
        name = f"{power(stiffness)} N/m, {speed:g} m/s"
        figure.axes[0].plot(list(alpha), list(alpha.values()), ms=4, label=name, **look)
    label(figure.axes[0], "height n (contacts)", "impulse ratio alpha(n)")
    legend_below(figure, 3)
    return _whole_heights(figure)


def critical_angles() -> Figure:
    """Draw theta_c(n) of the six runs, by both readings."""
    figure = angle_figure(towers.impulses("deformable"))
    figure.set_size_inches(7.6, 5.2)  # room for the legend
    return _whole_heights(figure)


def energy_scaling() -> Figure:
    """Draw the critical angle of alpha = 1/sqrt(n), and that of the impulses."""
    figure = panels(1, 1, 6.4, 3.8)
    axes, alpha = figure.axes[0], towers.ratios()[towers.MEDIAN]
    impulses = [angle_from_impulse_ratio(alpha[n]) for n in HEIGHTS]
    scaled = [towers.scaled_angle(n) for n in HEIGHTS]
    axes.plot(HEIGHTS, scaled, marker="o", color=RED, label="1/sqrt(n)")
    axes.plot(HEIGHTS, impulses, marker="s", color=BLUE, ls="--", label="impulses, 1e6 N/m, 2 m/s")
    label(axes, "height n (contacts)", axis("critical angle", "deg"))
    legend_below(figure)
    return _whole_heights(figure)


def structure_window() -> Figure:
    """Draw the critical angle of the structure window by law."""
    angles = pd.concat(towers.structure_angles(law) for law in LAWS)
    return _whole_heights(angle_figure(angles[angles["height"] <= 6], readings=("lost",)))


def _whole_heights(figure: Figure) -> Figure:
    for axes in figure.axes:
        axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    return figure
