"""Draw the figures of a report's sections."""

from __future__ import annotations

import multiprocessing
import os
import sys
from collections import Counter
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from harness.parent_process import end_with
from harness.report.figures.style import house_style, plain_powers
from harness.report.plain import one_line, safe_path
from harness.report.plots import svg
from harness.report.sections import CellText, Drawing, Film, Plot, Section
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
class DrawnCell:
    """A cell of the matrix with its plots as SVG; ``failures`` says why there are none."""

    text: CellText
    plots: tuple[tuple[Plot, str], ...]
    failures: tuple[str, ...] = ()


@dataclass(frozen=True)
class Reel:
    """A film as GIF, and its poster as PNG."""

    name: str
    title: str
    caption: str
    gif: bytes
    still: bytes


@dataclass(frozen=True)
class Drawn:
    """A section with its figures drawn; ``failures`` says which could not be, and why."""

    section: Section
    pictures: tuple[Picture, ...]
    failures: tuple[str, ...] = ()
    cells: tuple[DrawnCell, ...] = ()
    reels: tuple[Reel, ...] = ()


def draw_sections(sections: Sequence[Section]) -> list[Drawn]:
    """Return the sections with their figures; names of figures are made unique file names.

    A figure that cannot be drawn is named with the error: the others, and the report, do not
    depend on it.
    """
    seen: Counter[str] = Counter()
    drawings = []
    for drawing in (drawing for section in sections for drawing in section.drawings):
        name = safe_path(drawing.name).replace("/", "-")
        seen[name] += 1
        drawings.append((name if seen[name] == 1 else f"{name}-{seen[name]}", drawing))
    cells = [cell for section in sections for cell in section.cells]
    done = _all_drawn([*drawings, *cells])
    outcomes, plotted = iter(done[: len(drawings)]), iter(done[len(drawings) :])
    drawn = []
    for section in sections:
        own = [next(outcomes) for _ in section.drawings]
        pictures = tuple(one for one in own if isinstance(one, Picture))
        filmed = [_filmed(film) for film in section.films]
        failures = tuple(one for one in (*own, *filmed) if isinstance(one, str))
        cells_drawn = tuple(_cell(cell, next(plotted)) for cell in section.cells)
        reels = tuple(one for one in filmed if isinstance(one, Reel))
        drawn.append(Drawn(section, pictures, failures, cells_drawn, reels))
    return drawn


def write_drawn(drawn: Sequence[Drawn], folder: Path) -> None:
    """Write the figures of sections into ``figures`` below a folder, films into ``movies``."""
    (folder / "figures").mkdir()
    for picture in (picture for part in drawn for picture in part.pictures):
        (folder / "figures" / f"{picture.name}.svg").write_text(picture.svg, encoding="utf-8")
        (folder / "figures" / f"{picture.name}.png").write_bytes(picture.png)
    for reel in (reel for part in drawn for reel in part.reels):
        (folder / "movies").mkdir(exist_ok=True)
        (folder / "movies" / f"{reel.name}.gif").write_bytes(reel.gif)
        (folder / "movies" / f"{reel.name}.png").write_bytes(reel.still)


def titles(drawn: Sequence[Drawn]) -> dict[str, str]:
    """Return the titles of the engines of the matrix, by name."""
    return {cell.text.engine: cell.text.who for part in drawn for cell in part.cells}


def _filmed(film: Film) -> Reel | str:
    from harness.report.gif import gif, png

    try:
        name = safe_path(film.name).replace("/", "-")
        still = png(film.picture(film.poster))
        return Reel(name, film.title, film.caption, gif(film.picture, film.frames), still)
    except Exception as error:
        reason = one_line(f"{type(error).__name__}: {error}")
        return f"Film {film.title!r} could not be drawn: {reason}"


Named = tuple[str, Drawing]
"""A figure and the name of its file."""

Plots = tuple[tuple[Plot, str], ...]
"""Plots, and each as SVG."""


def _cell(text: CellText, plots: Picture | Plots | str) -> DrawnCell:
    if isinstance(plots, tuple):
        return DrawnCell(text, plots)
    return DrawnCell(text, (), (str(plots),))


def _all_drawn(drawings: Sequence[Named | CellText]) -> list[Picture | Plots | str]:
    """Return each figure, or why it could not be drawn, over the cores where a process can fork.

    A forked process has the runs that figures are drawn from; another would have to be sent them.
    """
    if sys.platform != "linux" or len(drawings) < 2:
        return [_drawn(one) for one in drawings]
    import matplotlib.backends.backend_agg
    import matplotlib.backends.backend_svg  # noqa: F401 - once, for all processes

    _of_workers[:] = drawings
    workers, fork = len(os.sched_getaffinity(0)), multiprocessing.get_context("fork")
    try:
        with ProcessPoolExecutor(workers, fork, _begin_worker, (os.getpid(),)) as pool:
            return list(pool.map(_drawn_in_worker, range(len(drawings))))
    except BrokenProcessPool:
        return [_drawn(one) for one in drawings]
    finally:
        _of_workers.clear()


_of_workers: list[Named | CellText] = []
"""The figures as a forked process finds them."""


def _drawn_in_worker(index: int) -> Picture | Plots | str:
    return _drawn(_of_workers[index])


def _begin_worker(parent: int) -> None:
    """Write past progress bars, whose lock a thread may have held when the process forked."""
    end_with(parent)
    sys.stdout, sys.stderr = sys.__stdout__, sys.__stderr__


def _drawn(what: Named | CellText) -> Picture | Plots | str:
    title = ", ".join(what.place) if isinstance(what, CellText) else what[1].title
    try:
        if isinstance(what, CellText):
            return tuple((plot, svg(plot)) for plot in what.plots())
        name, drawing = what
        return picture(name, drawing.title, drawing.caption, drawing.draw)
    except Exception as error:  # code of a plug-in, anything can go wrong in it
        reason = one_line(f"{type(error).__name__}: {error}")
        return f"Figure {title!r} could not be drawn: {reason}"


def picture(name: str, title: str, caption: str, draw: Callable[[], Figure]) -> Picture:
    """Return what ``draw`` draws in the house style, the same bytes for the same figure."""
    import io

    import matplotlib as mpl
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.backends.backend_svg import FigureCanvasSVG

    with house_style():
        figure = draw()
        plain_powers(figure)
        engine = figure.get_layout_engine()
        if engine is not None:  # much of the work: once for both formats
            engine.execute(figure)
            figure.set_layout_engine("none")
        vector, png = io.StringIO(), io.BytesIO()
        # savefig would draw each of them twice, the first time for the layout
        canvas: Any = FigureCanvasSVG(figure)
        canvas.print_svg(vector, metadata={"Date": None})
        figure.dpi = mpl.rcParams["savefig.dpi"]
        canvas = FigureCanvasAgg(figure)
        canvas.print_png(png, metadata={"Software": None})
    return Picture(name, title, caption, compact(vector.getvalue()), png.getvalue())
