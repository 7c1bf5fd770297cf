"""The report of the study: the figure over the thickness, tables of softness and of changes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from harness.cases.layers.averages import mean_of
from harness.cases.layers.changes import (
    Compared,
    compared,
    limits,
    over_box,
)
from harness.cases.layers.conclusion import (
    MARGIN_DEG,
    STOP,
    TEST,
    Found,
    grouped,
    interval,
    judged,
    seeds_of,
)
from harness.cases.layers.cost_section import cost_section
from harness.cases.layers.robustness import softness_elsewhere
from harness.cases.layers.study import LIMIT, THICKNESS
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
    changes = compared(found)
    if changes:
        sections.append(_changes(changes))
    return (*sections, *_limit(found), *cost_section(found))


def _thickness(found: Found, points: ReferencePoints | None) -> Section:
    def draw() -> Figure:
        from harness.cases.layers.study_figure import angle_over_thickness

        return angle_over_thickness(found, points)

    rows = []
    for some in grouped(found.arms[THICKNESS]).values():
        one, stop = some[0], mean_of([*seeds_of(some).values()])
        rows.append(
            (
                str(one["layers"]),
                f"{one['stiffness_over_weight']:g}",
                f"{one['length_d']} x {one['width_d']}",
                f"{stop.value:.2f}",
                f"{stop.half_width:.2f}",
                f"{stop.scatter:.2f}",
                str(stop.count),
                str(len(some) - stop.count),
                f"{mean_of([*seeds_of(some, 'rest_coordination').values()]).value:.2f}",
            )
        )
    head = ("layers", "k d/(m g)", "box (d)", "angle of stop (deg)", "95 % interval (± deg)",
            "scatter of a seed (deg)", "seeds", "undecided", "contacts at rest")  # fmt: skip
    table = Table(
        "Angle of stop", "Means over seeds, disordered base.", head,
        tuple(sorted(rows, key=_first)), frozenset(range(9)),
    )  # fmt: skip
    fits = [
        f"k d/(m g) = {stiffness:g}: theta(h) = theta_inf + A h^(-1/nu) gives theta_inf = "
        f"{fit.limit:.2f} deg (95 %: {fit.limit_interval[0]:.2f} to {fit.limit_interval[1]:.2f}), "
        f"1/nu = {fit.exponent:.2f} ({fit.exponent_interval[0]:.2f} to "
        f"{fit.exponent_interval[1]:.2f}), A = {fit.amplitude:.2f} deg, of "
        f"{found.layers(stiffness)[0]} to {found.layers(stiffness)[-1]} layers."
        for stiffness, fit in sorted(found.fits.items())
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
        "where there are four; the paper's two readings of a column of n deformable particles, "
        "the critical angle of the single grain, and the bulk.",
        draw,
    )
    return Section("Thickness", (), (*fits, bulk), (table,), (drawing,))


def _first(row: tuple[str, ...]) -> tuple[float, float]:
    return float(row[0]), float(row[1])


def _softness(found: Found) -> Section:
    rows = [
        (str(h), f"{one.value:+.3f}", f"{one.half_width:.3f}", str(one.count), judged(one))
        for h, one in found.softness().items()
    ]
    soft, stiff = found.stiffnesses[0], found.stiffnesses[-1]
    head = ("layers", "difference (deg)", "95 % interval (± deg)", "pairs", "by the test")
    caption = f"Angle of stop at {soft:g} minus that at {stiff:g} weights, paired by seed."
    tables = [Table("Softness", caption, head, tuple(rows), _NUMBERS)]
    elsewhere = softness_elsewhere(found)
    if elsewhere:
        more = [
            (str(h), f"{length} x {width}", f"{rate:g}", f"{one.value:+.3f}",
             f"{one.half_width:.3f}", str(one.count), judged(one))
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


def _changes(changes: Sequence[Compared]) -> Section:
    return Section(
        "What else could move the angle",
        (HELD_AGAINST,),
        tuple(told for one in changes for told in limits(one)),
        tuple(_of_changes(one) for one in changes),
        _of_boxes([one for one in changes if len(over_box(one)) > 1]),
    )


def _of_boxes(places: Sequence[Compared]) -> tuple[Drawing, ...]:
    def draw() -> Figure:
        from harness.cases.layers.study_figure import angle_over_box

        return angle_over_box(places)

    caption = (
        "Mean angle over seeds with its 95 % interval, in boxes about twice as long as wide; where "
        "there are three or more, the line through them, weighted by their intervals, and its "
        "limit."
    )
    drawing = Drawing("angle-over-box", "Angle of stop against the box", caption, draw)
    return (drawing,) if places else ()


HELD_AGAINST = (
    "One thing is changed at a time, in runs of their own. The angle is the same where zero lies "
    "within the interval of the difference, or where that interval lies within the one of the "
    "angle itself, a second half of the rule that was added when paired differences of 0.01 to "
    f"0.03 deg had excluded zero. Else it is within {MARGIN_DEG:g} deg where that interval is, "
    "which the test of softness calls the same: a third word that was added when angles in the "
    "largest boxes were known to 0.1 deg. Whether the intervals of both angles overlap is a weaker "
    "question, told beside it. A box is held against the next one towards that of the "
    "study, and of several boxes at a thickness and stiffness the two largest say whether the "
    "angle depends on the box; what smaller ones differ by is told apart. Each change was stated "
    "in the code before one of its runs was made, half the rate at four soft layers and twice the "
    "rate at four stiff ones after the first results at twice the rate; seeds at more layers than "
    "one are as many as there was time for. At level default four and eight layers were first "
    "studied in 16 x 8 and 12 x 6 d. Soft ones stopped lower in boxes about 1.5 times as long and "
    "wide, which by a rule stated before took their place at both stiffnesses. Where a still "
    "larger one moves the angle, the verdict says so: the angle over the thickness is that of its "
    "box. "
    "Trajectories are chaotic: what is split over ranks, or takes another step, is another run of "
    "the same flow, and its angle is the same within intervals, not to the bit. Other definitions "
    "of the arrest are of the same runs, paired. Of twenty independent changes that do nothing, "
    "one misses zero by chance."
)


def _of_changes(some: Compared) -> Table:
    rows = [
        (
            change.name,
            str(change.mean.count),
            f"{change.mean.value:.3f}",
            f"{change.difference.value:+.3f}",
            f"{change.difference.half_width:.3f}",
            change.word,
            "yes" if change.overlaps else "no",
        )
        for change in some.changes
    ]
    head = ("change", "seeds", "angle (deg)", "difference (deg)", "95 % interval (± deg)",
            "the same", "intervals overlap")  # fmt: skip
    one = some.reference[0]
    stop = mean_of([*seeds_of(some.reference).values()])
    return Table(
        f"One change at a time, {some.place}",
        f"{some.place[:1].upper()}{some.place[1:]}, in a box of {one['length_d']} x "
        f"{one['width_d']} d, {one['rate_deg']:g} deg per diameter, "
        f"{one['steps_per_contact']:g} steps per contact, disordered base: {interval(stop)} deg, "
        f"{stop.count} seeds.",
        head,
        tuple(rows),
        frozenset({1, 2, 3, 4}),
    )


def _limit(found: Found) -> Sequence[Section]:
    rows = [row for row in found.arms.get(LIMIT, ()) if row[STOP] is not None]
    if not rows:
        return ()
    expected = critical_angle()
    items = tuple(
        f"{row['rate_deg']:g} deg per well: it stops between {row[STOP]:.4f} and "
        f"{row[STOP] + row['rate_deg']:.4f} deg"
        for row in rows
    )
    text = (
        "One layer on the ordered row with a single grain is the incline. With a plastic contact "
        f"it must stop once the angle is below the critical {expected:.4f} deg, at the next well: "
        "the rate is how well that is resolved."
    )
    return (Section("The limit of a single grain", (text,), items),)
