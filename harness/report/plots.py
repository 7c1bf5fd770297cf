"""Draw small plots as SVG from a template, in milliseconds each, without matplotlib."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

from harness.report.figures.style import COLOURS
from harness.report.sections import Line, Plot
from harness.report.templating import environment

WIDTH, HEIGHT = 520.0, 330.0
LEFT, RIGHT, TOP, BOTTOM = 74.0, 12.0, 12.0, 48.0
DASHES = ("", "7 3", "2 3", "8 3 2 3")
MOST_DECADES = 6
"""Ticks of a logarithmic axis, about."""


@dataclass(frozen=True)
class Axis:
    """A scale from values to places in the picture, with its ticks: place and word."""

    place: Callable[[float], float]
    ticks: tuple[tuple[float, str], ...]


@dataclass(frozen=True)
class Shape:
    """A line as the template draws it: pieces of a polyline, or points."""

    name: str
    colour: str
    dash: str
    marked: bool
    pieces: tuple[tuple[tuple[float, float], ...], ...]


def svg(plot: Plot) -> str:
    """Return a plot as an SVG element with its legend's colours; empty without a finite point."""
    points = [point for line in plot.lines for point in _finite(line, plot.logarithmic)]
    if not points:
        return ""
    xs, ys = zip(*points, strict=True)
    made = _logarithmic if plot.logarithmic else _linear
    x = made(min(xs), max(xs), LEFT, WIDTH - RIGHT)
    y = made(min(ys), max(ys), HEIGHT - BOTTOM, TOP)
    return (
        environment()
        .get_template("plot.svg.j2")
        .render(
            plot=plot,
            shapes=[_shape(number, line, plot, x, y) for number, line in enumerate(plot.lines)],
            x=x,
            y=y,
            frame=(LEFT, TOP, WIDTH - RIGHT, HEIGHT - BOTTOM),
            size=(WIDTH, HEIGHT),
        )
    )


def _shape(number: int, line: Line, plot: Plot, x: Axis, y: Axis) -> Shape:
    pieces: list[list[tuple[float, float]]] = [[]]
    for one, other in zip(line.x, line.y, strict=True):
        if _shown(one, other, plot.logarithmic):
            pieces[-1].append((round(x.place(one), 1), round(y.place(other), 1)))
        elif pieces[-1]:
            pieces.append([])
    return Shape(
        line.name,
        COLOURS[number % len(COLOURS)],
        DASHES[number % len(DASHES)],
        line.marked,
        tuple(tuple(piece) for piece in pieces if piece),
    )


def _shown(x: float, y: float, logarithmic: bool) -> bool:
    return math.isfinite(x) and math.isfinite(y) and not (logarithmic and min(x, y) <= 0.0)


def _finite(line: Line, logarithmic: bool) -> Iterator[tuple[float, float]]:
    for x, y in zip(line.x, line.y, strict=True):
        if _shown(x, y, logarithmic):
            yield float(x), float(y)


def _linear(low: float, high: float, start: float, end: float) -> Axis:
    from matplotlib.ticker import MaxNLocator

    if high - low <= 1e-9 * max(abs(low), abs(high)):
        margin = 0.1 * abs(high) or 1.0
    else:
        margin = 0.04 * (high - low)
    low, high = low - margin, high + margin
    ticks = [t for t in MaxNLocator(6).tick_values(low, high) if low <= t <= high]
    apart = ticks[1] - ticks[0] if len(ticks) > 1 else 1.0

    def place(value: float) -> float:
        return start + (end - start) * (value - low) / (high - low)

    # a tick at 0 is 0, whatever round-off its steps have left
    words = (f"{0.0 if abs(t) < 1e-6 * apart else t:.6g}" for t in ticks)
    return Axis(place, tuple(zip(map(place, ticks), words, strict=True)))


def _logarithmic(low: float, high: float, start: float, end: float) -> Axis:
    first, last = math.floor(math.log10(low)), math.ceil(math.log10(high))
    last = max(last, first + 1)

    def place(value: float) -> float:
        return start + (end - start) * (math.log10(value) - first) / (last - first)

    every = -(-(last - first) // MOST_DECADES)
    decades: Sequence[int] = range(first, last + 1, every)
    return Axis(
        place, tuple((place(10.0**d), f"1e{d}" if abs(d) > 2 else f"{10.0**d:g}") for d in decades)
    )
