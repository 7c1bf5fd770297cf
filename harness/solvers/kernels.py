"""What compiled steps share: compilation, words as numbers, parts of a state, looks at stages.

At a look, each few steps, the first body may end a stage, or the run.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache
from typing import Any, NamedTuple, TypeVar, get_args

import numpy as np
from numpy.typing import NDArray

from harness.compiled import compiled, jit
from harness.model.base import Parameters, Vector
from harness.model.conventions import Rules
from harness.model.scene import LOOK, STAGE_COLUMNS, Floats, Scene

Function = TypeVar("Function", bound=Callable[..., Any])
Records = Any  # a record, or an array of records, of a type in harness.solvers.reference or mdr

POSITION, VELOCITY, SPIN, FORCE, TORQUE = range(5)
PARTS = 5
# arguments of kernels: for each number of Python numba would compile a kernel once more
FIRST: Any = np.int64(0)  # of two bodies
SECOND: Any = np.int64(1)
MOVES: Any = np.bool_(True)  # in a step, not in a setup


def kernel(function: Function) -> Function:
    """Compile without reference counts of arrays, which take five sixths of a step.

    Callers keep the arrays; nothing may be allocated.
    """
    return jit(function, error_model="numpy", nogil=True, _nrt=False)


def inlined(function: Function) -> Function:
    """Compile a kernel into its callers."""
    return jit(function, error_model="numpy", nogil=True, forceinline=True, _nrt=False)


@cache
def words(kind: type[Parameters], name: str) -> dict[str, Any]:
    """Return the words that a field takes, with their numbers in records."""
    allowed = get_args(kind.model_fields[name].annotation)
    return {word: np.int64(n) for n, word in enumerate(allowed) if isinstance(word, str)}


# ---- vectors: tuples of three numbers, which stay in registers


@kernel
def vector(values: Floats) -> Vector:
    """Return an array (3,) as a vector."""
    return (values[0], values[1], values[2])


@kernel
def store(place: Floats, values: Vector) -> None:
    """Put a vector in an array (3,)."""
    place[0], place[1], place[2] = values


@kernel
def add(a: Vector, b: Vector) -> Vector:
    """Return a + b."""
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2])


@kernel
def minus(a: Vector, b: Vector) -> Vector:
    """Return a - b."""
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


@kernel
def scale(factor: float, a: Vector) -> Vector:
    """Return a vector times a factor."""
    return (factor * a[0], factor * a[1], factor * a[2])


@kernel
def dot(a: Vector, b: Vector) -> float:
    """Return the scalar product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@kernel
def cross(a: Vector, b: Vector) -> Vector:
    """Return the vector product."""
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


@kernel
def size(a: Vector) -> float:
    """Return the length of a vector."""
    return math.sqrt(dot(a, a))


@kernel
def project(a: Vector, n: Vector) -> Vector:
    """Return the part of a vector across the unit vector ``n``."""
    return minus(a, scale(dot(a, n), n))


# ---- the first root of a polynomial
#
# In the Bernstein basis a polynomial without a sign change among its coefficients has no root in
# the interval (Descartes); halving the interval until that is so, always looking at the earlier
# half first, cannot miss the first root, be it simple, double or one of a close pair (Lane and
# Riesenfeld 1981).

HALVINGS = 52  # of an interval that may hold a root


@compiled
def first_root(coefficients: Floats, shift: float, until: float) -> float:
    """Return the first root of ``shift + sum c_j s^j`` in [0, until], or 2 if there is none.

    ``until`` is at most 1. A value that is not positive at 0 counts as a root at 0.
    """
    rest = 0.0
    for j in range(1, coefficients.size):
        rest += abs(coefficients[j])
    if coefficients[0] + shift > rest:
        return 2.0
    if coefficients[0] + shift <= 0:
        return 0.0
    low, depth = 0.0, 0
    pieces = np.empty((HALVINGS + 2, coefficients.size))
    widths = np.empty(HALVINGS + 2)
    _set_bernstein(coefficients, shift, until, pieces[0])
    widths[0] = 1.0
    while depth >= 0:
        now, width = pieces[depth], widths[depth]
        least = now[0]
        for j in range(1, now.size):
            least = min(least, now[j])
        if least > 0:
            low += width
            depth -= 1
        elif width < 2.0**-HALVINGS or now[0] <= 0:
            return low * until
        else:
            _halve(now, pieces[depth + 1])
            widths[depth] = widths[depth + 1] = 0.5 * width
            depth += 1
    return 2.0


@compiled
def _set_bernstein(coefficients: Floats, shift: float, until: float, result: Floats) -> None:
    """Set ``result`` to the Bernstein coefficients on [0, until] of a polynomial in powers."""
    degree = coefficients.size - 1
    for j in range(degree + 1):  # an assignment of arrays takes numba 2 s longer to compile
        result[j] = coefficients[j]
    result[0] += shift
    # b_k = sum_j C(k,j)/C(degree,j) c_j, by repeated summation
    power = binomial = 1.0
    for j in range(1, degree + 1):
        power *= until
        binomial *= (degree - j + 1) / j
        result[j] *= power / binomial
    for level in range(1, degree + 1):
        for k in range(degree, level - 1, -1):
            result[k] += result[k - 1]


@compiled
def _halve(now: Floats, half: Floats) -> None:
    """Split at the middle (de Casteljau): ``half`` takes the first half, ``now`` the second."""
    degree = now.size - 1
    for level in range(degree + 1):
        half[level] = now[0]
        for k in range(degree - level):
            now[k] = 0.5 * (now[k] + now[k + 1])


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
