"""The single conventions under which a run that fails would hold."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import get_args

from harness.errors import EngineNaNError
from harness.model.conventions import Rules
from harness.model.motion import Motion
from harness.model.scene import Scene
from harness.solvers import reference


def passing_rules(scene: Scene, rules: Rules, holds: Callable[[Motion], bool]) -> tuple[str, ...]:
    """Return each as ``wall_lever = height``; ``holds`` is that of all rows of the run."""
    return tuple(words for words, other in _neighbours(rules) if _passes(scene, other, holds))


def _neighbours(rules: Rules) -> Iterator[tuple[str, Rules]]:
    for name, field in Rules.model_fields.items():
        words = (True, False) if field.annotation is bool else get_args(field.annotation)
        for word in words:
            if word != getattr(rules, name):
                yield f"{name} = {word}", rules.replace(**{name: word})


def _passes(scene: Scene, rules: Rules, holds: Callable[[Motion], bool]) -> bool:
    try:
        return holds(reference.run(scene, rules))
    except EngineNaNError:
        return False
