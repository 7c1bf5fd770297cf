"""The report of the study: the figure over the thickness, tables of softness and of changes."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

from harness.cases.layers.averages import REJECTED, Limit, Mean, mean_of
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
from harness.cases.layers.conclusion import Found, grouped
from harness.cases.layers.cost import core_seconds, cost_seen
from harness.cases.layers.study import LIMIT, SINGLE_CRITICAL_DEG, THICKNESS, LayersStudy
from harness.observables.reference import PEYNEAU_ROUX, ReferencePoints
from harness.report.sections import Drawing, Section, Table
from harness.theory.critical_angle import critical_angle

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def sections_of(found: Found, points: ReferencePoints | None) -> tuple[Section, ...]:
    """Return the sections; those without runs are left out."""
    sections = []
    if found.angles:
        sections += [_thickness(found, points), _softness(found)]
    if found.places:
        sections += [_changes(found.places), _boxes(found.places), _own_runs(found.places)]
    return (*sections, *_limit(found), *_cost(found))


STOPPING = (
    "Seeds of these means were added until Student's interval was below 0.3 deg, a rule that looks "
    "at the interval and not at the angle. Such stopping leaves the mean without bias, but the "
    "interval is a little too narrow: simulated for a scatter of 0.2 to 0.6 deg and 3 to 14 seeds, "
    "it covers the mean in 90 to 95 % of cases. Runs on the same base differ when they are split "
    "over two ranks, as the flow is chaotic; they are averaged seed by seed, {between}."
)


def _thickness(found: Found, points: ReferencePoints | None) -> Section:
    def draw() -> Figure:
        from harness.cases.layers.study_figure import angle_over_thickness

        return angle_over_thickness(found, points)

    rows = []
    for some in grouped(found.arms[THICKNESS]).values():
        one, system = some[0], same_system(some, found.arms)
        stop = mean_of([*seeds_of(system).values()])
        runs = {(row["seed"], row["ranks"]) for row in system if row[STOP] is not None}
        rows.append(
            (
                str(one["layers"]),
                f"{one['stiffness_over_weight']:g}",
                f"{one['length_d']} x {one['width_d']}",
                f"{stop.value:.2f}",
                f"{stop.half_width:.2f}",
                f"{stop.scatter:.2f}",
                str(stop.count),
                str(len(runs)),
                str(sum(row[STOP] is None for row in some)),
                f"{mean_of([*seeds_of(some, 'rest_coordination').values()]).value:.2f}",
            )
        )
    head = ("layers", "k d/(m g)", "box (d)", "angle of stop (deg)", "95 % interval (± deg)",
            "scatter of a seed (deg)", "seeds", "runs", "undecided",
            "contacts at rest")  # fmt: skip
    table = Table(
        "Angle of stop", "Means over seeds, disordered base, 0.1 deg per diameter.", head,
        tuple(sorted(rows, key=_first)), frozenset(range(10)),
    )  # fmt: skip
    fits = [
        f"k d/(m g) = {stiffness:g}: theta(h) = theta_inf + A h^(-1/nu) gives theta_inf = "
        f"{interval(fit.limit)} deg, 1/nu = {interval(fit.exponent)}, A = {fit.amplitude:.2f} deg, "
        f"of {found.layers(stiffness)[0]} to {found.layers(stiffness)[-1]} layers in equal boxes."
        for stiffness, fit in sorted(found.fits.items())
    ]
    if not fits:
        fits = [
            "No law is fitted over the thickness: that takes five thicknesses in equal boxes, as "
            "level full has them. Boxes differ here, and the angle depends on the box."
        ]
    bulk = (
        f"Bulk, {PEYNEAU_ROUX.what}: {PEYNEAU_ROUX.value_deg} ± {PEYNEAU_ROUX.uncertainty_deg} deg "
        f"({PEYNEAU_ROUX.citation})."
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
    text = STOPPING.format(between=_between_ranks(found))
    return Section("Thickness", (text,), (*fits, bulk), (table,), (drawing,))


def _between_ranks(found: Found) -> str:
    """Return the standard deviation of runs on one base, of pairs on different ranks."""
    squares = []
    for some in grouped(found.arms[THICKNESS]).values():
        system = same_system(some, found.arms)
        counts = sorted({row["ranks"] for row in system})
        by_rank = [seeds_of([r for r in system if r["ranks"] == n]) for n in counts]
        if len(by_rank) == 2:
            shared = set(by_rank[0]) & set(by_rank[1])
            squares += [0.5 * (by_rank[0][seed] - by_rank[1][seed]) ** 2 for seed in shared]
    if not squares:
        return "of which there are none here"
    root = math.sqrt(sum(squares) / len(squares))
    return f"a standard deviation of {root:.2f} deg between runs on {len(squares)} bases"


def _first(row: tuple[str, ...]) -> tuple[float, float]:
    return float(row[0]), float(row[1])


def _softness(found: Found) -> Section:
    rows = [
        (str(h), f"{one.value:+.3f}", f"{one.half_width:.3f}", str(one.count), one.word)
        for h, one in found.softness().items()
    ]
    soft, stiff = found.stiffnesses[0], found.stiffnesses[-1]
    head = ("layers", "difference (deg)", "95 % interval (± deg)", "pairs", "by the test")
    caption = f"Angle of stop at {soft:g} minus that at {stiff:g} weights, paired by seed."
    tables = [Table("Softness", caption, head, tuple(rows), _NUMBERS)]
    elsewhere = softness_elsewhere(found.places)
    if elsewhere:
        more = [
            (str(h), f"{length} x {width}", f"{rate:g}", f"{one.value:+.3f}",
             f"{one.half_width:.3f}", str(one.count), one.word)
            for (h, length, width, rate), one in elsewhere.items()
        ]  # fmt: skip
        elsewhere_head = ("layers", "box (d)", "rate (deg per d)", *head[1:])
        tables.append(
            Table(
                "Softness elsewhere", "The same in other boxes and at another rate of lowering.",
                elsewhere_head, tuple(more), frozenset(range(6)),
            )
        )  # fmt: skip
    return Section("Softness", (TEST,), tables=tuple(tables))


_NUMBERS = frozenset({0, 1, 2, 3})

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
    one = place.reference[0]
    stop = mean_of([*seeds_of(place.reference).values()])
    return Table(
        f"One change at a time, {place.place}",
        f"{place.place[:1].upper()}{place.place[1:]}, in a box of {box_of(one)} d, "
        f"{one['rate_deg']:g} deg per diameter, {one['steps_per_contact']:g} steps per contact, "
        f"disordered base: {interval(stop)} deg, {stop.count} seeds.",
        head,
        tuple(rows),
        frozenset({1, 2, 3, 4}),
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
            Table("Limits", "Each model, and the limit by those that count.", head, tuple(body),
                  frozenset({3, 4, 5}))
        )  # fmt: skip
    drawn = [place for place in places if len(place.boxes) > 1]

    def draw() -> Figure:
        from harness.cases.layers.study_figure import angle_over_box

        return angle_over_box(drawn)

    caption = (
        "Mean angle over seeds with its 95 % interval, in boxes about twice as long as wide; where "
        "there are three or more, the models that count, and at zero the interval of their limit."
    )
    drawing = Drawing("angle-over-box", "Angle of stop against the box", caption, draw)
    return Section(
        "Limits of box and rate", (MODELS,), (), tuple(tables), (drawing,) if drawn else ()
    )


def _of_limit(words: str, values: str, limit: Limit) -> list[tuple[str, ...]]:
    what = "1/length" if "endless" in words else "rate"
    lines = [
        (words, values, f"{what}^{one.power:g}", f"{one.limit.value:.2f}",
         f"{one.limit.half_width:.2f}", f"{one.chance:.3f}", "yes" if one in limit.kept else "no")
        for one in limit.models
    ]  # fmt: skip
    mean = limit.mean
    return [*lines, (words, values, "all that count", f"{mean.value:.2f}",
                     f"{mean.half_width:.2f}", "", "")]  # fmt: skip


def _own_runs(places: Sequence[Compared]) -> Section:
    head = ("place", "quantity", "seeds", "angle (deg)", "difference (deg)",
            "95 % interval (± deg)", "by the test")  # fmt: skip
    numbers = frozenset({2, 3, 4, 5})
    starts = [(place, one) for place in places for one in place.starts]
    definitions = [(place, one) for place in places for one in place.definitions]
    tables = [
        Table(label, caption, head,
              tuple(_of_own(place.place, one.name, one.mean, one.difference)
                    for place, one in some), numbers)
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


def _limit(found: Found) -> Sequence[Section]:
    rows = [row for row in found.arms.get(LIMIT, ()) if row[STOP] is not None]
    if not rows:
        return ()
    items = tuple(
        f"{row['rate_deg']:g} deg per well: it stops between {row[STOP]:.4f} and "
        f"{row[STOP] + row['rate_deg']:.4f} deg"
        for row in rows
    )
    one, (value, error) = rows[0], SINGLE_CRITICAL_DEG
    text = (
        "One layer on the ordered row with a single grain is the incline. With a plastic contact "
        "it must stop once the angle is below the critical one, at the next well: the rate is how "
        f"well that is resolved. At the stiffness and step of these runs, "
        f"{one['stiffness_over_weight']:g} weights and {one['steps_per_contact']:g} steps per "
        f"contact, the critical angle is {value:.3f} ± {error:.3f} deg (the reference DEM); of "
        f"rigid spheres it is {critical_angle():.4f} deg."
    )
    return (Section("The limit of a single grain", (text,), items),)


def _cost(found: Found) -> Sequence[Section]:
    cost = cost_seen(LayersStudy().arms("full"), found.arms)
    if cost is None:
        return ()
    measured = "; ".join(
        f"{one['microseconds_per_grain_and_step']:.2f} us at {one['grains']:,}"
        for one in cost.measured
    )
    count, seconds = core_seconds(found.arms)
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
        ("cores", "hours", "core hours", "efficiency"), rows, frozenset(range(4)),
    )  # fmt: skip
    text = (
        "Wall times of the runs of this page, on machines that did other work as well: another "
        "machine has other numbers. Level full is reckoned from the least cost of a grain and step "
        "at each size and from how long flows of a thickness take to stop; study layers --cost "
        "--runs with this page's runs.csv gives the same table, --cost alone measures the machine "
        "it runs on."
    )
    return (Section("Cost", (text,), items, (table,)),)
