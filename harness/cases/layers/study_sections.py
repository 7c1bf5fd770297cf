"""The report of the study: the figure over the thickness, tables of softness and of changes."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from harness.cases.layers.averages import (
    Mean,
    difference_of,
    extrapolated,
    mean_of,
    unpaired,
)
from harness.cases.layers.conclusion import (
    START,
    STOP,
    TEST,
    Found,
    grouped,
    interval,
    judged,
    seeds_of,
)
from harness.cases.layers.study import LIMIT, REFERENCE, THICKNESS
from harness.observables.reference import PEYNEAU_ROUX, ReferencePoints
from harness.report.sections import Drawing, Section, Table
from harness.theory.critical_angle import critical_angle

if TYPE_CHECKING:
    from matplotlib.figure import Figure

DEFINITIONS = {
    "kinetic over elastic energy below 1e-3": "stop_angle_at_100_times_the_ratio_deg",
    "mean speed alone below 0.01 sqrt(g d)": "stop_angle_by_speed_deg",
}
"""Other definitions of the arrest than energies at a ratio of 1e-5, from the same runs."""


def sections_of(found: Found, points: ReferencePoints | None) -> tuple[Section, ...]:
    """Return the sections; those without runs are left out."""
    sections = []
    if found.angles:
        sections += [_thickness(found, points), _softness(found)]
    if REFERENCE in found.arms:
        sections.append(_changes(found))
    return (*sections, *_limit(found))


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
        f"{fit.exponent_interval[1]:.2f}), A = {fit.amplitude:.2f} deg."
        for stiffness, fit in sorted(found.fits.items())
    ]
    bulk = (
        f"Bulk, {PEYNEAU_ROUX.what}: {PEYNEAU_ROUX.value_deg} ± {PEYNEAU_ROUX.uncertainty_deg} deg "
        f"({PEYNEAU_ROUX.citation})."
    )
    drawing = Drawing(
        "angle-over-thickness",
        "Angle of stop against thickness",
        "Layers of frictionless spheres on a disordered base, two stiffnesses, with the fit over "
        "the thickness; the paper's two readings of a column of n deformable particles, the "
        "critical angle of the single grain, and the bulk.",
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
    return Section(
        "Softness", (TEST,), tables=(Table("Softness", caption, head, tuple(rows), _NUMBERS),)
    )


_NUMBERS = frozenset({0, 1, 2, 3})


def _changes(found: Found) -> Section:
    rows = [
        (name, f"{mean:.3f}", f"{one.value:+.3f}", f"{one.half_width:.3f}", _same(one))
        for name, mean, one in _differences(found)
    ]
    head = ("change", "angle (deg)", "difference (deg)", "95 % interval (± deg)", "zero within")
    reference = found.arms[REFERENCE]
    one = reference[0]
    table = Table(
        "One change at a time",
        f"{one['layers']} layers at {one['stiffness_over_weight']:g} weights in a box of "
        f"{one['length_d']} x {one['width_d']} d, {one['rate_deg']:g} deg per diameter, "
        f"{one['steps_per_contact']:g} steps per contact: "
        f"{interval(mean_of([*seeds_of(reference).values()]))} deg. Other boxes and ranks are "
        "other runs of the same flow; other definitions of the arrest are of the same runs.",
        head,
        tuple(rows),
        frozenset({1, 2, 3}),
    )
    return Section("What else could move the angle", (), tuple(_limits(found)), (table,))


SAME = ("layers", "stiffness_over_weight", "contact.restitution", "base", "rate_deg", "length_d",
        "width_d", "steps_per_contact", "rise_deg")  # fmt: skip
"""Columns that tell arms apart."""


def _limits(found: Found) -> Iterator[str]:
    """Yield the limits of a slow descent and of a large box, where there are three values."""
    reference = found.arms[REFERENCE]
    for limit, columns in (("rate to zero", {"rate_deg"}), ("box", {"length_d", "width_d"})):
        values = {}
        for rows in found.arms.values():
            changed = {name for name in SAME if rows and rows[0][name] != reference[0][name]}
            if rows is reference or (changed and changed <= columns):
                one = rows[0]
                x = one["rate_deg"] if limit != "box" else 1.0 / one["length_d"]
                values[x] = mean_of([*seeds_of(rows).values()])
        known = {x: mean for x, mean in values.items() if mean.count > 1}
        if len(known) > 2:
            told = "length of the box to infinity, linear in 1/length" if limit == "box" else limit
            value = extrapolated([*known], [*known.values()])
            yield f"Extrapolated, {told}: {interval(value)} deg."


def _differences(found: Found) -> Iterator[tuple[str, float, Mean]]:
    """Yield each change with its mean angle and its difference from the reference [deg]."""
    arms = {n: rows for n, rows in found.arms.items() if n not in (THICKNESS, LIMIT, REFERENCE)}
    reference = found.arms[REFERENCE]
    stop = seeds_of(reference)
    for name, rows in arms.items():
        other = seeds_of(rows)
        if len(other) < 2 or len(stop) < 2:
            continue
        means = mean_of([*other.values()]), mean_of([*stop.values()])
        yield name, means[0].value, unpaired(*means)
        start = seeds_of(rows, START)
        if start:
            yield "angle of start", mean_of([*start.values()]).value, difference_of(start, other)
    for name, quantity in DEFINITIONS.items():
        other = seeds_of(reference, quantity)
        if len(other) > 1:
            yield name, mean_of([*other.values()]).value, difference_of(other, stop)


def _same(one: Mean) -> str:
    return "yes" if one.low <= 0.0 <= one.high else "no"


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
