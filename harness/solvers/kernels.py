"""What compiled steps share: compilation, words as numbers, parts of a state, looks at stages.

At a look, each few steps, the first body may end a stage, or the run.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any, NamedTuple, TypeVar, get_args

import numpy as np
from numpy.typing import NDArray

from harness.compiled import jit
from harness.model.base import Parameters
from harness.model.conventions import Rules
from harness.model.motion import STAGE_COLUMNS, Floats
from harness.model.scene import LOOK, Scene

Function = TypeVar("Function", bound=Callable[..., Any])
Records = Any  # a record, or an array of records, of a type in harness.solvers.reference or mdr

POSITION, VELOCITY, SPIN, FORCE, TORQUE = range(5)
PARTS = 5


def kernel(function: Function) -> Function:
    """Compile without reference counts of arrays, which take five sixths of a step.

    Callers keep the arrays; nothing may be allocated.
    """
    return jit(function, error_model="numpy", nogil=True, _nrt=False)


def inlined(function: Function) -> Function:
    """Compile a kernel into its callers."""
    return jit(function, error_model="numpy", nogil=True, inline="always", _nrt=False)


@cache
def words(kind: type[Parameters], name: str) -> dict[str, int]:
    """Return the words that a field takes, with their numbers in records."""
    allowed = get_args(kind.model_fields[name].annotation)
    return {word: number for number, word in enumerate(allowed) if isinstance(word, str)}


# ---- stages

GO_ON, SET_UP, OVER = range(3)


class Stages(NamedTuple):
    """The stages of a scene, and how far a run has got.

    ``places`` [m] and ``floors`` [J] are (K,), ``rows`` (K + 2, 7) the start and the ends of stages
    so far; ``progress`` counts the stages that are over and the rows, and is 1 in its last place
    once the run is over. ``last`` is the last step.
    """

    places: Floats
    floors: Floats
    rows: Floats
    progress: NDArray[np.int64]
    mass: float
    gravity: Floats
    step: float
    last: int
    sets_up: bool


def stages_of(scene: Scene, rules: Rules) -> Stages:
    """Return the stages of a scene, before its first step."""
    return Stages(
        places=np.array([stage.place for stage in scene.stages]),
        floors=np.array([stage.floor for stage in scene.stages]),
        rows=np.zeros((len(scene.stages) + 2, len(STAGE_COLUMNS))),
        progress=np.zeros(3, dtype=np.int64),
        mass=scene.bodies[0].mass,
        gravity=np.array(scene.gravity),
        step=scene.step,
        last=scene.steps,
        sets_up=rules.looks_set_up and rules.scheme == "velocity_verlet",
    )


@kernel
def keep(state: Floats, stages: Stages, number: int) -> None:
    """Keep the state of the first body at the start or the end of a stage."""
    row = stages.rows[stages.progress[1]]
    stages.progress[1] += 1
    row[0], row[1] = number, number * stages.step
    for k in range(2):
        row[2 + k], row[4 + k] = state[0, POSITION, k], state[0, VELOCITY, k]
    row[6] = state[0, SPIN, 2]


@kernel
def look(state: Floats, stages: Stages, number: int) -> int:
    """Look at the first body after a step; return how the run goes on."""
    if len(stages.places) == 0 or (number % LOOK != 0 and number != stages.last):
        return GO_ON
    stage, speed = stages.progress[0], state[0, VELOCITY, 0]
    beyond = state[0, POSITION, 0] > stages.places[stage]
    if not beyond and speed >= 0.0 and number < stages.last:
        return GO_ON
    if beyond:
        stages.progress[0] = stage + 1
        over = stage + 1 == len(stages.places)
    else:
        over = speed < 0.0 and energy(state, stages) < stages.floors[stage]
    over = over or number >= stages.last or speed * 0.0 != 0.0
    if beyond or over:
        keep(state, stages, number)
    stages.progress[2] = over
    if over:
        return OVER
    return SET_UP if stages.sets_up else GO_ON


@kernel
def energy(state: Floats, stages: Stages) -> float:
    """Return the energy [J] of motion and height of the first body, without springs."""
    total = 0.0
    for k in range(3):
        v = state[0, VELOCITY, k]
        total += 0.5 * v * v - stages.gravity[k] * state[0, POSITION, k]
    return float(stages.mass * total)


def finished(stages: Stages) -> bool:
    """Return whether the run is over before its last step."""
    return bool(stages.progress[2])


def ends(stages: Stages) -> Any:
    """Return the start and the ends of stages so far, (K, 7), None of a scene without stages."""
    return stages.rows[: stages.progress[1]].copy() if len(stages.places) else None
