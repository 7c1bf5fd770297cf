"""Qualify an engine by drops on one fixed sphere, before its critical angles are believed."""

from __future__ import annotations

from harness.cases.drop.case import CASE
from harness.cases.qualification import Qualification
from harness.cases.qualification import qualify as qualify_by
from harness.engines.contract import Engine

__all__ = ["Qualification", "qualify"]


def qualify(engine: Engine) -> Qualification:
    """Run the drops that an engine can state and judge each against its closed form.

    What the engine declares (``traits``) decides on the expectation: tail, effective
    mass, digits of its output. A run that dies is a failed check of its own.
    """
    return qualify_by(engine, [CASE])
