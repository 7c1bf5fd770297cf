"""Draw the figures of a report's sections."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from harness.report.figures.style import house_style
from harness.report.plain import one_line, safe_path
from harness.report.sections import Drawing, Section
from harness.report.vector import compact

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


@dataclass(frozen=True)
class Drawn:
    """A section with its figures drawn; ``failures`` says which could not be, and why."""

    section: Section
    pictures: tuple[Picture, ...]
    failures: tuple[str, ...] = ()


def draw_sections(sections: Sequence[Section]) -> list[Drawn]:
    """Return the sections with their figures; names of figures are made unique file names.

    A figure that cannot be drawn is named with the error: the others, and the report, do not
    depend on it.
    """
    seen: Counter[str] = Counter()
    drawn = []
    for section in sections:
        pictures, failures = [], []
        for drawing in section.drawings:
            name = safe_path(drawing.name).replace("/", "-")
            seen[name] += 1
            unique = name if seen[name] == 1 else f"{name}-{seen[name]}"
            try:
                pictures.append(_drawn(unique, drawing))
            except Exception as error:  # code of a plug-in, anything can go wrong in it
                reason = one_line(f"{type(error).__name__}: {error}")
                failures.append(f"Figure {drawing.title!r} could not be drawn: {reason}")
        drawn.append(Drawn(section, tuple(pictures), tuple(failures)))
    return drawn


def _drawn(name: str, drawing: Drawing) -> Picture:
    return picture(name, drawing.title, drawing.caption, drawing.draw)


def picture(name: str, title: str, caption: str, draw: Callable[[], Figure]) -> Picture:
    """Return what ``draw`` draws in the house style, the same bytes for the same figure."""
    import io

    with house_style():
        figure = draw()
        # the layout is most of the work: once for both formats
        figure.draw_without_rendering()
        figure.set_layout_engine("none")
        svg, png = io.StringIO(), io.BytesIO()
        figure.savefig(svg, format="svg", metadata={"Date": None})
        figure.savefig(png, format="png", metadata={"Software": None})
    return Picture(name, title, caption, compact(svg.getvalue()), png.getvalue())
