"""The report of the study of layers: angles over thickness, softness, changes, and a film."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.artist import Artist
from matplotlib.collections import EllipseCollection
from matplotlib.figure import Figure
from numpy.typing import NDArray

from harness.cases.layers.averages import REJECTED, Mean, ModelLimit, mean_of
from harness.cases.layers.changes import (
    STOP,
    TEST,
    Compared,
    box_of,
    interval,
    same_system,
    seeds_of,
    signed,
    softness_elsewhere,
)
from harness.cases.layers.conclusion import StudyAngles, grouped
from harness.cases.layers.extents import (
    LIMIT,
    SINGLE_CRITICAL_DEG,
    THICKNESS,
    arms_of,
    core_seconds,
    cost_seen,
)
from harness.cases.layers.system import Layers, job_of
from harness.cases.source_angles import READINGS, source_angles
from harness.engines.contract import Job
from harness.engines.output import SERIES, Output
from harness.observables.reference import PEYNEAU_ROUX, ReferencePoints
from harness.report.film import Film, Scene
from harness.report.sections import Drawing, Section, Table
from harness.report.style import BLACK, COLOURS, MARKERS, ORANGE, RED, SKY, legend_below
from harness.report.style import Figure as ShownFigure
from harness.theory.incline import critical_angle

POINT_SHIFT = 0.04
"""Of a thickness, by which the points of two stiffnesses are set apart so that both are seen."""

LIMIT_SHIFT = 7e-4
"""[1/d] between the limits of places, left of zero, so that all are seen."""


def angle_over_thickness(results: StudyAngles, points: ReferencePoints | None) -> ShownFigure:
    """Draw means with intervals and fits, the paper's readings, single grain, bulk, a user's."""
    figure = ShownFigure(figsize=(7.4, 5.6), layout="constrained")
    axes = figure.add_subplot()
    last = max(h for _, h in results.angles)
    fine = np.geomspace(1.0, 1.5 * last, 60)
    for number, stiffness in enumerate(results.stiffnesses):
        look: dict[str, Any] = {"color": COLOURS[1 + number % 4]}
        layers = results.layers(stiffness)
        means = [results.mean(stiffness, h) for h in layers]
        shift = 1.0 + POINT_SHIFT * (number - (len(results.stiffnesses) - 1) / 2)
        axes.errorbar(
            [h * shift for h in layers],
            [mean.value for mean in means],
            [mean.half_width for mean in means],
            marker=MARKERS[number % 6],
            ls="none",
            capsize=3,
            label=f"layers, k d/(m g) = {stiffness:g}",
            **look,
        )
        fit = results.fits.get(stiffness)
        if fit is not None:
            law = rf"${fit.limit.value:.2f} + {fit.amplitude:.2f}\,h^{{-{fit.exponent.value:.2f}}}$"
            name = f"fit at {stiffness:g}: {law}"
            axes.plot(fine, fit.curve(fine), lw=1.0, label=name, **look)
    heights = list(range(1, max(last, 10) + 1))
    expected = [source_angles(n, "deformable") for n in heights]
    for (reading, words), (style, colour) in zip(
        READINGS.items(), (("--", ORANGE), (":", SKY)), strict=True
    ):
        angles = [of_height[reading] for of_height in expected]
        name = f"the paper, n deformable particles, {words}"
        axes.plot(heights, angles, style, marker=".", color=colour, label=name)
    axes.axhline(critical_angle(), color=BLACK, lw=0.9, ls="-.",
                 label=f"single grain on a row, {critical_angle():.4f} deg")  # fmt: skip
    low = PEYNEAU_ROUX.value - PEYNEAU_ROUX.uncertainty
    axes.axhspan(low, low + 2 * PEYNEAU_ROUX.uncertainty, color="0.82", zorder=0,
                 label=f"bulk ({PEYNEAU_ROUX.who})")  # fmt: skip
    if points is not None:
        name = points.name.replace("$", r"\$")  # a file's name is no formula
        axes.plot(points.heights, points.angles_deg, "*", color=BLACK, ms=9, mfc="none", label=name)
    axes.set(xscale="log", xlabel="layers h, particles n", ylabel="angle of stop (deg)")
    ticks = [tick for tick in (1, 2, 4, 8, 12, 20, 40) if tick <= 2 * last]
    axes.set_xticks(ticks, [str(tick) for tick in ticks])
    axes.minorticks_off()
    axes.set_ylim(bottom=0.0)
    legend_below(figure, 2)
    return figure


def angle_over_box(places: Sequence[Compared]) -> ShownFigure:
    """Draw the angle of stop against 1/length of the box, with models through three or more."""
    figure = ShownFigure(figsize=(7.4, 4.6), layout="constrained")
    axes = figure.add_subplot()
    for number, some in enumerate(places):
        values = {1.0 / length: mean for length, mean in some.boxes.items()}
        look: dict[str, Any] = {"color": COLOURS[number % len(COLOURS)]}
        axes.errorbar(
            [*values], [value.value for value in values.values()],
            [value.half_width for value in values.values()],
            marker=MARKERS[number % len(MARKERS)], ls="none", capsize=3, label=some.place, **look,
        )  # fmt: skip
        limit = some.box_limit()
        if limit is not None:
            fine = np.linspace(0.0, max(values), 50)
            for model in limit.kept:
                axes.plot(fine, model.curve(fine), lw=0.8, alpha=0.7, **look)
            aside = LIMIT_SHIFT * (1 + number)
            mean = limit.mean
            axes.errorbar(-aside, mean.value, mean.half_width, capsize=3, lw=1.6, **look)
    axes.set(xlabel="1 / length of the box (1/d)", ylabel="angle of stop (deg)")
    axes.set_xlim(left=-LIMIT_SHIFT * (len(places) + 2))
    axes.axvline(0.0, color="0.6", lw=0.7)
    legend_below(figure, 2)
    return figure


def sections_of(results: StudyAngles, points: ReferencePoints | None) -> tuple[Section, ...]:
    """Return the sections; those without runs are left out."""
    sections = []
    if results.angles:
        sections += [_thickness(results, points), _softness(results)]
    if results.places:
        sections += [_changes(results.places), _boxes(results.places), _own_runs(results.places)]
    return (*sections, *_limit(results), *_cost(results))


STOPPING = (
    "Seeds of these means were added until Student's interval was below 0.3 deg, a rule that looks "
    "at the interval and not at the angle. Such stopping leaves the mean without bias, but the "
    "interval is a little too narrow: simulated for a scatter of 0.2 to 0.6 deg and 3 to 14 seeds, "
    "it covers the mean in 90 to 95 % of cases. Runs on the same base differ when they are split "
    "over two ranks, as the flow is chaotic; they are averaged seed by seed, {between}."
)


def _thickness(results: StudyAngles, points: ReferencePoints | None) -> Section:
    def draw() -> Figure:

        return angle_over_thickness(results, points)

    rows: list[tuple[str, ...]] = []
    for some in grouped(results.arms[THICKNESS]).values():
        row, system = some[0], same_system(some, results.arms)
        stop = mean_of([*seeds_of(system).values()])
        runs = {(row["seed"], row["ranks"]) for row in system if row[STOP] is not None}
        rows.append(
            (
                str(row["layers"]),
                f"{row['stiffness_over_weight']:g}",
                f"{row['length_d']} x {row['width_d']}",
                f"{stop.value:.2f}",
                f"{stop.half_width:.2f}",
                f"{stop.scatter:.2f}",
                str(stop.count),
                str(len(runs)),
                str(sum(row[STOP] is None for row in some)),
                f"{mean_of([*seeds_of(some, 'rest_coordination').values()]).value:.2f}",
            )
        )
    rows.sort(key=lambda row: (float(row[0]), float(row[1])))
    head = ("layers", "k d/(m g)", "box (d)", "angle of stop (deg)", "95 % interval (± deg)",
            "scatter of a seed (deg)", "seeds", "runs", "undecided",
            "contacts at rest")  # fmt: skip
    table = Table(
        "Angle of stop", "Means over seeds, disordered base, 0.1 deg per diameter.", head,
        tuple(rows),
    )  # fmt: skip
    fits = [
        f"k d/(m g) = {stiffness:g}: theta(h) = theta_inf + A h^(-1/nu) gives theta_inf = "
        f"{interval(fit.limit)} deg, 1/nu = {interval(fit.exponent)}, A = {fit.amplitude:.2f} deg, "
        f"of {min(results.layers(stiffness))} to {max(results.layers(stiffness))} layers in equal "
        "boxes."
        for stiffness, fit in sorted(results.fits.items())
    ]
    if not fits:
        fits = [
            "No law is fitted over the thickness: that takes five thicknesses in equal boxes, as "
            "level full has them. Boxes differ here, and the angle depends on the box."
        ]
    bulk = (
        f"Bulk, {PEYNEAU_ROUX.name}: {PEYNEAU_ROUX.value} ± {PEYNEAU_ROUX.uncertainty} deg "
        f"({PEYNEAU_ROUX.who})."
    )
    drawing = Drawing(
        "angle-over-thickness",
        "Angle of stop against thickness",
        "Layers of frictionless spheres on a disordered base, by stiffness (points of one "
        "thickness are set apart by 4 % so that all are seen), with the fit over the thickness "
        "where there is one; the paper's two readings of a column of n deformable particles, "
        "the critical angle of the single grain, and the bulk.",
        draw,
    )
    text = STOPPING.format(between=_between_ranks(results))
    return Section("Thickness", (text,), (*fits, bulk), (table,), (drawing,))


def _between_ranks(results: StudyAngles) -> str:
    """Return the standard deviation of runs on one base, of pairs on different ranks."""
    squares = []
    for some in grouped(results.arms[THICKNESS]).values():
        system = same_system(some, results.arms)
        counts = sorted({row["ranks"] for row in system})
        by_rank = [seeds_of([r for r in system if r["ranks"] == n]) for n in counts]
        if len(by_rank) == 2:
            shared = set(by_rank[0]) & set(by_rank[1])
            squares += [0.5 * (by_rank[0][seed] - by_rank[1][seed]) ** 2 for seed in shared]
    if not squares:
        return "of which there are none here"
    root = math.sqrt(sum(squares) / len(squares))
    return f"a standard deviation of {root:.2f} deg between runs on {len(squares)} bases"


def _softness(results: StudyAngles) -> Section:
    rows = [
        (str(h), f"{mean.value:+.3f}", f"{mean.half_width:.3f}", str(mean.count), mean.word)
        for h, mean in results.softness().items()
    ]
    soft, stiff = results.stiffnesses[0], results.stiffnesses[-1]
    head = ("layers", "difference (deg)", "95 % interval (± deg)", "pairs", "by the test")
    caption = f"Angle of stop at {soft:g} minus that at {stiff:g} weights, paired by seed."
    tables = [Table("Softness", caption, head, tuple(rows))]
    elsewhere = softness_elsewhere(results.places)
    if elsewhere:
        more = [
            (str(h), f"{length} x {width}", f"{rate:g}", f"{mean.value:+.3f}",
             f"{mean.half_width:.3f}", str(mean.count), mean.word)
            for (h, length, width, rate), mean in elsewhere.items()
        ]  # fmt: skip
        elsewhere_head = ("layers", "box (d)", "rate (deg per d)", *head[1:])
        tables.append(
            Table(
                "Softness elsewhere", "The same in other boxes and at another rate of lowering.",
                elsewhere_head, tuple(more),
            )
        )  # fmt: skip
    return Section("Softness", (TEST,), tables=tuple(tables))


HELD_AGAINST = (
    "One thing is changed at a time, in runs of their own, and judged by the same test as "
    "softness. Each change was stated in the code before one of its runs was made, half the rate "
    "at four soft layers and twice the rate at four stiff ones after the first results at twice "
    "the rate; seeds are as many as there was time for. A box is held against the next smaller "
    "one. Of a box with fewer than four seeds the scatter is that of the next smaller box, unless "
    "its own is more. At level default four and eight layers were first studied in 16 x 8 and "
    "12 x 6 d. Soft ones stopped lower in boxes about 1.5 times as long and wide, which by a rule "
    "stated before took their place at both stiffnesses. Trajectories are chaotic: what is split "
    "over ranks, or takes another step, is another run of the same flow. Of twenty independent "
    "changes that do nothing, one excludes zero by chance."
)


def _changes(places: Sequence[Compared]) -> Section:
    changes = [change for place in places for change in place.changes]
    other = [c for c in changes if c.paired and c.independent.word != c.word]
    listed = "; ".join(
        f"{c.name} at {c.place} {c.independent.word} ({signed(c.independent)})" for c in other
    )
    item = (
        f"Pairing: of {sum(c.paired for c in changes)} paired changes Welch's test "
        f"says something else in {len(other)}{': ' + listed if listed else ''}."
    )
    tables = tuple(_of_changes(place) for place in places if place.changes)
    return Section("What else could move the angle", (HELD_AGAINST,), (item,), tables)


def _of_changes(place: Compared) -> Table:
    rows = [
        (
            change.name,
            str(change.mean.count),
            f"{change.mean.value:.3f}",
            f"{change.difference.value:+.3f}",
            f"{change.difference.half_width:.3f}",
            f"{change.difference.count} pairs" if change.paired else "Welch",
            change.word,
        )
        for change in place.changes
    ]
    head = ("change", "seeds", "angle (deg)", "difference (deg)", "95 % interval (± deg)",
            "test", "by the test")  # fmt: skip
    row = place.reference[0]
    stop = mean_of([*seeds_of(place.reference).values()])
    return Table(
        f"One change at a time, {place.place}",
        f"{place.place[:1].upper()}{place.place[1:]}, in a box of {box_of(row)} d, "
        f"{row['rate_deg']:g} deg per diameter, {row['steps_per_contact']:g} steps per contact, "
        f"disordered base: {interval(stop)} deg, {stop.count} seeds.",
        head,
        tuple(rows),
    )


MODELS = (
    "Limits by lines through means weighted by their intervals: an endless box by models linear in "
    "1/length, in its square and in its cube, a slow descent by models linear in the rate and in "
    f"its root. A model whose chi-squared is exceeded by chance in less than {REJECTED:.0%} of "
    "cases is rejected. The limit is the middle of the intervals of the other models and its "
    "uncertainty half their range: the distance between models is in it."
)


def _boxes(places: Sequence[Compared]) -> Section:
    rows = []
    for place in places:
        endless = place.box_limit()
        if endless is not None:
            lengths = ", ".join(f"{length:g}" for length in place.boxes)
            rows.append((f"{place.place}, endless box", f"{lengths} d", endless))
        rows += [
            (f"{place.place}, {box_of(row)} d, slow", "rates", limit)
            for row, limit in place.rate_limits()
        ]
    tables = []
    if rows:
        head = ("limit", "of", "model", "limit (deg)", "95 % interval (± deg)", "chance", "counts")
        body = [line for words, values, limit in rows for line in _of_limit(words, values, limit)]
        tables.append(
            Table("Limits", "Each model, and the limit by those that count.", head, tuple(body))
        )  # fmt: skip
    drawn = [place for place in places if len(place.boxes) > 1]

    def draw() -> Figure:

        return angle_over_box(drawn)

    caption = (
        "Mean angle over seeds with its 95 % interval, in boxes about twice as long as wide; where "
        "there are three or more, the models that count, and at zero the interval of their limit."
    )
    drawing = Drawing("angle-over-box", "Angle of stop against the box", caption, draw)
    return Section(
        "Limits of box and rate", (MODELS,), (), tuple(tables), (drawing,) if drawn else ()
    )


def _of_limit(words: str, values: str, limit: ModelLimit) -> list[tuple[str, ...]]:
    variable = "1/length" if "endless" in words else "rate"
    lines = [
        (words, values, f"{variable}^{model.power:g}", f"{model.limit.value:.2f}",
         f"{model.limit.half_width:.2f}", f"{model.chance:.3f}",
         "yes" if model in limit.kept else "no")
        for model in limit.models
    ]  # fmt: skip
    mean = limit.mean
    return [*lines, (words, values, "all that count", f"{mean.value:.2f}",
                     f"{mean.half_width:.2f}", "", "")]  # fmt: skip


def _own_runs(places: Sequence[Compared]) -> Section:
    head = ("place", "quantity", "seeds", "angle (deg)", "difference (deg)",
            "95 % interval (± deg)", "by the test")  # fmt: skip
    starts = [(place, start) for place in places for start in place.starts]
    definitions = [(place, definition) for place in places for definition in place.definitions]
    tables = [
        Table(label, caption, head,
              tuple(_of_own(place.place, quantity.name, quantity.mean, quantity.difference)
                    for place, quantity in some))
        for label, caption, some in (
            ("Hysteresis", "Angle of start, and that minus the stop of the same run.", starts),
            ("Other definitions of the arrest", "And what they differ by.", definitions),
        )
        if some
    ]  # fmt: skip
    text = (
        "Quantities of the same runs, subtracted run by run; they are no changes of their own. A "
        "rest is raised until its grains have moved on by a diameter: the angle of start is an "
        "upper bound that depends on how fast it is raised."
    )
    return Section("Start, and other definitions of the stop", (text,), (), tuple(tables))


def _of_own(place: str, name: str, mean: Mean, difference: Mean) -> tuple[str, ...]:
    return (place, name, str(difference.count), f"{mean.value:.3f}", f"{difference.value:+.3f}",
            f"{difference.half_width:.3f}", difference.word)  # fmt: skip


def _limit(results: StudyAngles) -> Sequence[Section]:
    rows = [row for row in results.arms.get(LIMIT, ()) if row[STOP] is not None]
    if not rows:
        return ()
    items = tuple(
        f"{row['rate_deg']:g} deg per well: it stops between {row[STOP]:.4f} and "
        f"{row[STOP] + row['rate_deg']:.4f} deg"
        for row in rows
    )
    row, (value, error) = rows[0], SINGLE_CRITICAL_DEG
    text = (
        "One layer on the ordered row with a single grain is the incline. With a plastic contact "
        "it must stop once the angle is below the critical one, at the next well: the rate is how "
        f"well that is resolved. At the stiffness and step of these runs, "
        f"{row['stiffness_over_weight']:g} weights and {row['steps_per_contact']:g} steps per "
        f"contact, the critical angle is {value:.3f} ± {error:.3f} deg (the reference DEM); of "
        f"rigid spheres it is {critical_angle():.4f} deg."
    )
    return (Section("The limit of a single grain", (text,), items),)


def _cost(results: StudyAngles) -> Sequence[Section]:
    cost = cost_seen(arms_of("full"), results.arms)
    if cost is None:
        return ()
    measured = "; ".join(
        f"{size['microseconds_per_grain_and_step']:.2f} us at {size['grains']:,}"
        for size in cost.measured
    )
    count, seconds = core_seconds(results.arms)
    items = (
        f"The {count} different runs of this page took {seconds / 3600.0:.1f} core hours.",
        f"A grain and step, by the grains of a run: {measured}.",
    )
    rows = tuple(
        (
            str(row["cores"]),
            f"{row['wall_time_h']:.1f}",
            f"{row['core_hours']:.0f}",
            f"{row['efficiency']:.2f}",
        )
        for row in cost.rows
    )
    first = cost.rows[0]
    table = Table(
        "What level full would cost",
        f"{first['runs']} runs, the longest of {first['longest_run_h']:.1f} hours of a core, a "
        "core to a run.",
        ("cores", "hours", "core hours", "efficiency"), rows,
    )  # fmt: skip
    text = (
        "Wall times of the runs of this page, on machines that did other work as well: another "
        "machine has other numbers. Level full is reckoned from the least cost of a grain and step "
        "at each size and from how long flows of a thickness take to stop; study layers --cost "
        "--runs with this page's runs.csv gives the same table, --cost alone measures the machine "
        "it runs on."
    )
    return (Section("Cost", (text,), items, (table,)),)


Floats = NDArray[np.float64]

FILMED = Layers(layers=4, length=16, width=5, first_angle=16.0, rate=2.0, flow_time=10.0)
"""Lowered quickly: a film is no measurement."""

FRAME = 0.3
"""[sqrt(d/g)] between two frames."""

PREPARED = 20.0
"""[sqrt(d/g)] before which the grains come to rest on the base."""

MOST_FRAMES = 100

FASTEST, LAYER_COLOURS = 1.6, 8
"""[sqrt(g d)] of the scale, and its colours, each for 0.2: a GIF has few."""


def film_job() -> Job:
    """Return the job whose particles are filmed."""
    return job_of(FILMED, round(FRAME / FILMED.step))


class FlowScene(Scene):
    """Places and speeds of all particles, frame by frame, and how a frame looks.

    ``time`` (M,) in sqrt(d/g) from the end of the preparation; x, y, z, vx (M, N) in d and
    sqrt(g d); ``width`` (N,) in d.
    """

    height = 560

    def __init__(self, output: Output, engine: str) -> None:
        table = output.table(("step", "x_m", "z_m"), name=SERIES)
        time = np.asarray(table["step"]) * FILMED.step - PREPARED
        kept = np.flatnonzero(time >= 0.0)[:MOST_FRAMES]
        self.time: Floats = time[kept]
        names = ("x_m", "y_m", "z_m", "vx_m_per_s")
        self.x, self.y, self.z, self.vx = (np.asarray(table[name])[kept] for name in names)
        self.width: Floats = 2.0 * np.asarray(table["radius_m"])[0]
        self.fixed = np.ptp(np.asarray(table["x_m"]), axis=0) == 0.0
        self.title, self.frames = f"{FILMED.layers} layers until they stop", self.time.size
        self._who = engine
        super().__init__()

    @property
    def speed(self) -> Floats:
        """Return the mean speed of the grains in each frame, (M,)."""
        return np.asarray(self.vx[:, ~self.fixed].mean(axis=1))

    @property
    def poster_frame(self) -> int:
        """Return a frame of the full flow."""
        return int(np.argmax(self.speed))

    def subtitle(self) -> str:
        """Return engine, parameters and view."""
        return (
            f"{self._who}, k = {FILMED.stiffness_over_weight:g} m g/d, {FILMED.contact.name}, at "
            f"{FILMED.first_angle:g} deg, then lowered; seen from the side, base in grey"
        )

    def clock(self, frame: int) -> str:
        """Return the time."""
        return f"t = {self.time[frame]:.1f} sqrt(d/g)"

    def build(self, figure: Figure) -> list[Artist]:
        """Draw the scale and the mean speed; the grains and where the film is move."""
        axes, below = self.axes(figure, 90, 235, 770, 250), self.axes(figure, 90, 50, 770, 80)
        axes.grid(False)
        axes.set(xlim=(0.0, FILMED.length), ylim=(-1.0, FILMED.layers + 1.4), aspect="equal")
        axes.set(xlabel="along the base (d)", ylabel="height (d)")
        self._discs = EllipseCollection(
            self.width, self.width, np.zeros_like(self.width), units="xy",
            offsets=np.zeros((self.width.size, 2)), transOffset=axes.transData,
            edgecolors="#333333", linewidths=0.4, antialiaseds=False,
            cmap=mpl.colormaps["viridis"].resampled(LAYER_COLOURS),
        )  # fmt: skip
        self._discs.set_clim(0.0, FASTEST)
        axes.add_collection(self._discs)
        scale = figure.colorbar(
            self._discs, cax=self.axes(figure, 90, 180, 770, 10), orientation="horizontal"
        )
        scale.set_label("speed of a grain along the base (sqrt(g d))")
        below.plot(self.time, self.speed, color="0.6", lw=1.0)
        (self._cursor,) = below.plot([], [], "o", color=RED)
        below.set(xlabel="time (sqrt(d/g))", ylabel="mean speed\n(sqrt(g d))")
        below.yaxis.label.set_fontsize(9)
        below.set(xlim=(0.0, float(self.time[-1])), ylim=(0.0, None))
        return [self._discs, self._cursor]

    def show(self, frame: int) -> None:
        """Put the grains where they are, those behind first."""
        order = np.argsort(-self.y[frame])
        self._discs.set_offsets(np.column_stack([self.x[frame], self.z[frame]])[order])
        self._discs.set_widths(self.width[order])
        self._discs.set_heights(self.width[order])
        colours: Any = self._discs.cmap(self._discs.norm(self.vx[frame][order]))
        colours[self.fixed[order]] = (0.7, 0.7, 0.7, 1.0)
        self._discs.set_array(None)
        self._discs.set_facecolor(colours)
        self._cursor.set_data([self.time[frame]], [self.speed[frame]])


def film_of(output: Output, engine: str) -> Film:
    """Return the film of a run of :func:`film_job`; its still is a frame of the full flow."""
    angle, rate = FILMED.first_angle, FILMED.rate
    return FlowScene(output, engine).film(
        "layers-flow",
        f"{FILMED.layers} layers in a box of {FILMED.length} d by {FILMED.width} d, seen from the "
        f"side, by {engine}: at {angle:g} deg for {FILMED.flow_time:g} sqrt(d/g), then lowered by "
        f"{rate:g} deg for each diameter that the grains move. Grey: the base.",
    )
