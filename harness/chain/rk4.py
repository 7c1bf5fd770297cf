"""The classic Runge-Kutta method of fourth order with a fixed step (Kutta 1901).

Forces depend on positions alone, so the four stages reduce to four force
evaluations at displacements ``u + c v + b a``, with a the acceleration of the
stage before. Order 4 while the contacts stay; at a change of contacts the force
has a kink, and the error of the step that meets it is of lower order.
"""

from __future__ import annotations

import math

from harness.chain import rk4_deformable, rk4_long_rows, rk4_overlap
from harness.chain.arrays import Chain, assemble
from harness.chain.block_partition import BLOCK
from harness.chain.record import Record, as_run, blank_record, wanted_samples
from harness.chain.stability import chosen_step
from harness.errors import RequestError
from harness.observables.tower import TowerRun
from harness.parameters.tower import Tower

_STEPS_AT_MOST = 10**12


def run(
    tower: Tower,
    duration: float,
    *,
    step: float | None = None,
    steps_per_contact: float | None = None,
    samples: int | None = None,
    profiles: bool = False,
    longest_chain: int | None = None,
) -> TowerRun:
    """Run ``tower`` for ``duration`` [s] and return about ``samples`` samples.

    ``step`` [s] or ``steps_per_contact`` (steps in pi sqrt(m/k)); without them
    the step is chosen (:func:`harness.chain.stability.chosen_step`) and made to
    divide the duration. By default 1000 samples per t0, or every step. A
    ``longest_chain`` says how many contacts will touch in a row at most, which
    allows a larger step for long deformable chains; the run stops if it is not
    true. Raise RequestError for a step or duration that cannot be.
    """
    if not (math.isfinite(duration) and duration > 0):
        raise RequestError(f"duration = {duration} s: must be finite and greater than 0")
    if longest_chain is not None and longest_chain < 1:
        raise RequestError(f"longest_chain = {longest_chain}: must be at least 1")
    wanted = wanted_samples(samples, duration / tower.contact_time)
    h = chosen_step(tower, step, steps_per_contact, longest_chain)
    if duration / h > _STEPS_AT_MOST:
        raise RequestError(f"duration = {duration} s: more than 1e12 steps of {h:.6g} s")
    steps = max(1, math.ceil(duration / h * (1 - 1e-12)))
    h = duration / steps
    every = max(1, steps // wanted)
    chain = assemble(tower)
    record = blank_record(steps // every + 2, tower.particles, profiles)
    limit = tower.height if longest_chain is None else longest_chain
    record, rows = integrate(chain, record, h, steps, every, limit)
    if rows < 0:
        raise _stopped(-rows, limit, h)
    return as_run(tower, "rk4", h, record, rows, chain)


def _stopped(found: int, limit: int, step: float) -> RequestError:
    """Return why a run stopped: a chain beyond the limit, or contacts that cannot be found."""
    if found > limit:
        return RequestError(
            f"longest_chain = {limit}: {found} contacts touch in a row, "
            f"for which a step of {step:.6g} s may be unstable"
        )
    return RequestError(f"step = {step:.6g} s: the contacts could not be found, values overflow")


def integrate(
    chain: Chain, record: Record, step: float, steps: int, every: int, longest: int
) -> tuple[Record, int]:
    """Advance ``chain`` in place under its law; return the record and its rows.

    Negative rows say why the deformable law stopped
    (:func:`harness.chain.rk4_deformable.integrate`).
    """
    if chain.deformable and chain.mass.size >= 2 * BLOCK:
        return rk4_long_rows.integrate(chain, record, step, steps, every, longest)
    if chain.deformable:
        return rk4_deformable.integrate(chain, record, step, steps, every, longest)
    return rk4_overlap.integrate(chain, record, step, steps, every)
