"""Which figures a verification has, with what is to be seen in each."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

from harness.comparison.verification import Verification
from harness.report.figures import incline
from harness.report.figures.style import house_style

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True)
class Picture:
    """A figure as SVG and PNG, with its title and one sentence on what it shows."""

    name: str
    title: str
    caption: str
    svg: str
    png: bytes


def pictures(found: Verification) -> Iterator[Picture]:
    """Yield the figures for which there is evidence."""
    evidence = found.incline
    closed = evidence.closed_form_deg
    if evidence.extrapolated is not None:
        extrapolated = evidence.extrapolated
        yield _picture(
            "critical-angle-extrapolation",
            "Critical angle, extrapolated",
            "Plastic contact, passage route. Left: first order in the step; open symbols are the "
            "limits. Right: those limits against the stiffness. Dashed: the closed form.",
            lambda: incline.extrapolation(extrapolated, closed),
        )
    if evidence.by_contact:
        yield _picture(
            "contacts-side-by-side",
            "Three contacts side by side",
            "Bars are the range over where in a step a contact begins. The source's contact "
            "crosses the closed form on its way to a higher angle: agreement at 50 steps is a "
            "cancellation.",
            lambda: incline.contacts_side_by_side(evidence.by_contact, closed),
        )
    if evidence.motions:
        yield _picture(
            "speed-against-time",
            "Speed below and above the critical angle",
            "The source's velocity figure, from LAMMPS with the source's contact.",
            lambda: incline.speed_against_time(evidence.motions),
        )
        yield _picture(
            "path-over-the-bumps",
            "Path over the bumps",
            "Where the grain below the critical angle turns back.",
            lambda: incline.path_over_the_bumps(evidence.motions),
        )
    if evidence.recursion is not None:
        recursion = evidence.recursion
        yield _picture(
            "energy-after-each-shock",
            "Energy after each shock",
            "Kinetic energy that survives each shock, taken from the energy at the next crest, "
            "against the recursion started from the first.",
            lambda: incline.energy_after_each_shock(recursion),
        )


def _picture(name: str, title: str, caption: str, draw: Callable[[], Figure]) -> Picture:
    import io

    with house_style():
        figure = draw()
        svg, png = io.StringIO(), io.BytesIO()
        figure.savefig(svg, format="svg", metadata={"Date": None})
        figure.savefig(png, format="png", metadata={"Software": None})
    return Picture(name, title, caption, svg.getvalue(), png.getvalue())
