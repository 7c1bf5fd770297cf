"""The limit of small steps of a case's quantities, by the reference."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from harness.cases.base import Case
from harness.cases.bench import Bench
from harness.engines.output import Output
from harness.engines.provenance import Provenance
from harness.engines.scene_tables import motion_tables
from harness.errors import EngineError, RequestError
from harness.model.base import Parameters

if TYPE_CHECKING:
    from harness.model.scene import Scene

SOUGHT = 1e-9  # of a quantity's scale: error at which no finer run is made
RESOLVED = 1e-6  # of a quantity's scale, or
RESOLVED_SHARE = 0.1  # of the step's error: largest error of a limit that is returned
MOST_BODY_STEPS = 2_000_000  # steps times bodies of the finest run: a second in all


def limits_of(
    case: Case[Any], parameters: Parameters, bench: Bench, names: Sequence[str]
) -> dict[str, float]:
    """Return the limits of small steps by name, of those quantities where it is resolved.

    None for a case whose reference is not one scene.
    """
    from harness.solvers import reference

    scene = case.scene(parameters)
    if not names or scene is None or type(case).reference is not Case.reference:
        return {}
    rules, first = bench.rules(scene), scene.steps

    def quantities(steps: int) -> Mapping[str, float]:
        finer = refined(scene, steps // first)
        tables = motion_tables(reference.run(finer, rules), scene)  # at the times of its samples
        output = Output((), Provenance("reference", ""), tables, title="the reference")
        values = case.measure(parameters, output)
        return {name: values[name] for name in names if name in values}

    scales = {name: case.quantity(name).size(parameters) for name in names}
    most = max(MOST_BODY_STEPS // len(scene.bodies), first)
    try:
        sought = {name: SOUGHT * scale for name, scale in scales.items()}
        found = reference.limit(quantities, sought, first=first, most=most)
    except (EngineError, RequestError):  # a finer run overflows, or is another system
        return {}
    coarse = quantities(first)
    return {
        name: limit.value
        for name, limit in found.items()
        if limit.error
        <= max(RESOLVED * scales[name], RESOLVED_SHARE * abs(limit.value - coarse[name]))
    }


def refined(scene: Scene, factor: int) -> Scene:
    """Return a scene with steps that are a whole factor smaller, sampled at the same times."""
    segments = [part.replace(steps=part.steps * factor) for part in scene.segments]
    return scene.replace(
        step=scene.step / factor,
        steps=scene.steps * factor,
        every=scene.every * factor,
        segments=tuple(segments),
        setups=tuple(at * factor for at in scene.setups),
    )
