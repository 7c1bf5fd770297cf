"""The pictures: the source's figures drawn from our own runs, then those of the findings."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from harness.report.gallery import Picture, picture
from harness.reproduction.figure_data.compute import SourceFigure
from harness.reproduction.figures.findings import angle_against_mfix_step, angle_against_restitution

if TYPE_CHECKING:
    from harness.reproduction.run import Reproduction


def all_pictures(found: Reproduction) -> list[Picture]:
    """Return the source's figures in their order, then two of the findings."""
    findings, engine = found.findings, found.provenance.engine.upper()
    return [
        *source_pictures(found.figures),
        picture(
            "finding-mfix-step",
            "Finding: the step of MFiX's scheme",
            "Critical angle of the source's contact with m/2, by our integrator in MFiX's scheme "
            "and as recorded with MFiX. The curves cross the closed form on their way to limits "
            "that only a stiffer contact brings down. Bars: resolution of the search, and where "
            "in a step a contact begins.",
            lambda: angle_against_mfix_step(findings),
        ),
        picture(
            "finding-restitution",
            "Finding: what a rebound does to the angle",
            "The two readings of the source's shock, and what a DEM does.",
            lambda: angle_against_restitution(findings, engine),
        ),
    ]


def source_pictures(figures: Sequence[SourceFigure]) -> list[Picture]:
    """Return a picture for each figure of the source but those that cannot be drawn again.

    Its title names the figure that it answers, its caption is the sentence of the statement.
    """
    return [
        picture(
            row.source.picture,
            f"{row.source.where.capitalize()} of the source: {row.source.title}",
            row.computed,
            draw,
        )
        for row, draw in figures
        if draw is not None
    ]
