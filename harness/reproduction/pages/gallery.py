"""All pictures of the reproduction: the source's figures, then those of the findings."""

from __future__ import annotations

from harness.report.gallery import Picture, picture
from harness.reproduction.figures.findings import angle_against_mfix_step, angle_against_restitution
from harness.reproduction.pages.pictures import source_pictures
from harness.reproduction.run import Reproduction


def all_pictures(found: Reproduction) -> list[Picture]:
    """Return the source's figures in their order, then two of the findings."""
    findings, engine = found.findings, found.provenance.engine.upper()
    return [
        *source_pictures(found.exhibits),
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
