"""Codes side by side: a quantity of a case over one of its parameters, by every code that can."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from harness.cases.contact_base.motion import Array, motion_of
from harness.cases.contact_base.reference import followed, rules_of
from harness.cases.contact_base.submodels import PLAIN
from harness.engines.contract import Engine
from harness.errors import EngineError
from harness.parameters.contact_rules import Rules

if TYPE_CHECKING:
    from harness.cases.contact_base.contact_case import ContactCase

STEPS = 1600
"""Of a contact: at a few hundred the last stick and slip of an oblique impact still shows."""

FRICTION = (
    (
        "linear_history, elastic",
        "linear_history, clipped",
        "linear_history",
        "linear_history, 2/7, elastic",
    ),
    ("mindlin, elastic", "mindlin/force, elastic", "mindlin", "mindlin_rescale/force, elastic"),
)
"""Linear springs and solids with friction: of each the first that a code states."""

NORMALS = (
    ("hooke, velocity, clipped", "hooke, mass_velocity", "hooke"),
    ("hertz, coeff_restitution, clipped", "hertz, coeff_restitution", "hertz"),
)
"""Normal forces, likewise."""


@dataclass(frozen=True)
class Scan:
    """What is drawn: a quantity over values of a parameter, in the first system of the case.

    Of each of the ``families`` a code shows the first submodel that it states.
    """

    quantity: str
    parameter: str
    values: tuple[float, ...]
    families: tuple[tuple[str, ...], ...] = FRICTION


@dataclass(frozen=True)
class Scanned:
    """One family in a code: what it found, and what its rules ask for, each (M,)."""

    family: int
    submodel: str
    found: Array = field(repr=False)
    expected: Array = field(repr=False)

    @property
    def apart(self) -> float:
        """Return how far both are apart at most, as a part of the largest expected value."""
        scale = float(np.abs(self.expected).max()) or 1.0
        return float(np.nanmax(np.abs(self.found - self.expected), initial=0.0)) / scale


def scanned(case: ContactCase[Any], engine: Engine) -> tuple[Scanned, ...]:
    """Return what a code finds, for each family that it can state; a run that fails is NaN."""
    plan = list(_plan(case, engine))
    outputs = engine.run([case.job(p) for _, _, rows in plan for p in rows]) if plan else []
    found, size = [], len(case.scan.values)
    for number, (family, name, rows) in enumerate(plan):
        values = np.full(size, np.nan)
        runs = outputs[number * size : (number + 1) * size]
        for place, (parameters, output) in enumerate(zip(rows, runs, strict=True)):
            if not isinstance(output, EngineError):
                motion = motion_of(output, case.scene(parameters))
                values[place] = _value(case, parameters, motion)
        rules = rules_of(case.job(rows[0]), engine.traits)
        found.append(Scanned(family, name, values, curve(case, rows, rules)))
    return tuple(found)


def curve(case: ContactCase[Any], rows: Sequence[Any], rules: Rules) -> Array:
    """Return what the law asks for under rules, for parameters (M,)."""
    motions = [followed(case.scene(p), rules).motion for p in rows]
    values = [_value(case, p, motion) for p, motion in zip(rows, motions, strict=True)]
    return np.array(values, dtype=float)


def _value(case: ContactCase[Any], parameters: Any, motion: Any) -> float:
    return case.observed(parameters, motion).get(case.scan.quantity, float("nan"))


def rows_of(case: ContactCase[Any], name: str) -> list[Any]:
    """Return the parameters of a scan with a submodel."""
    submodel = next(one for one in (*case.submodels, *case.beside) if one.name == name)
    system = next(iter(case.systems.values()))
    told = {**PLAIN, **submodel.law, **system, "steps_per_contact": STEPS}
    base = case.default.replace(**told)
    return [base.replace(**{case.scan.parameter: value}) for value in case.scan.values]


def _plan(case: ContactCase[Any], engine: Engine) -> Iterator[tuple[int, str, list[Any]]]:
    """Yield each family with the submodel of it that an engine states, and its parameters."""
    for family, names in enumerate(case.scan.families):
        for name in names:
            rows = rows_of(case, name)
            if not any(engine.refuses(case.job(parameters)) for parameters in rows):
                yield family, name, rows
                break
