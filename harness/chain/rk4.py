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
from harness.chain.slices import Plan, Told, in_slices, rk4_step_seconds
from harness.chain.stability import chosen_step
from harness.errors import RequestError
from harness.observables.tower import TowerRun
from harness.parameters.tower import Law, Tower

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
    told: Told = lambda *_: None,
) -> TowerRun:
    """Run ``tower`` for ``duration`` [s] and return about ``samples`` samples.

    ``step`` [s] or ``steps_per_contact`` (steps in pi sqrt(m/k)); without them
    the step is chosen (:func:`harness.chain.stability.chosen_step`) and made to
    divide the duration. By default 1000 samples per t0, or every step. A
    ``longest_chain`` says how many contacts will touch in a row at most, which
    allows a larger step for long deformable chains; the run stops if it is not
    true. ``told`` is called with the steps done and all of them. Raise RequestError for a step or
    duration that cannot be.
    """
    if longest_chain is not None and longest_chain < 1:
        raise RequestError(f"longest_chain = {longest_chain}: must be at least 1")
    steps = step_count(duration, chosen_step(tower, step, steps_per_contact, longest_chain))
    wanted = wanted_samples(samples, duration / tower.contact_time)
    h = duration / steps
    every = max(1, steps // wanted)
    chain = assemble(tower)
    record = blank_record(steps // every + 2, tower.particles, profiles)
    limit = tower.height if longest_chain is None else longest_chain
    record, rows = integrate(chain, record, Plan(h, steps, every, limit), told)
    if rows < 0:
        raise _stopped(-rows, limit, h)
    return as_run(tower, "rk4", h, record, rows, chain)


def step_count(duration: float, h: float) -> int:
    """Return how many steps of about ``h`` [s] :func:`run` takes; errors as there."""
    if not (math.isfinite(duration) and duration > 0):
        raise RequestError(f"duration = {duration} s: must be finite and greater than 0")
    if not (h > 0 and duration / h <= _STEPS_AT_MOST):
        raise RequestError(f"duration = {duration} s: more than 1e12 steps of {h:.6g} s")
    return max(1, math.ceil(duration / h * (1 - 1e-12)))


def _stopped(found: int, limit: int, step: float) -> RequestError:
    """Return why a run stopped: a chain beyond the limit, or contacts that cannot be found."""
    if found > limit:
        return RequestError(
            f"longest_chain = {limit}: {found} contacts touch in a row, "
            f"for which a step of {step:.6g} s may be unstable"
        )
    return RequestError(f"step = {step:.6g} s: the contacts could not be found, values overflow")


def integrate(
    chain: Chain, record: Record, plan: Plan, told: Told = lambda *_: None
) -> tuple[Record, int]:
    """Advance ``chain`` in place under its law; return the record and its rows.

    Negative rows say why the deformable law stopped
    (:func:`harness.chain.rk4_deformable.begin`).
    """
    law: Law = "deformable" if chain.deformable else "overlap"
    kernel = rk4_overlap.begin
    if chain.deformable:
        long = chain.mass.size >= 2 * BLOCK
        kernel = rk4_long_rows.begin if long else rk4_deformable.begin
    seconds = rk4_step_seconds(law, chain.mass.size)
    return in_slices(kernel(chain, plan), record, plan, seconds, told)
