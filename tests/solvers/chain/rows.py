"""Chains as solvers take them, made of parameters of towers."""

from harness.cases.tower.parameters import Tower
from harness.cases.tower.runs import chain_of
from harness.solvers import chain_exact, chain_stepped
from harness.solvers.chain import STABILITY, highest_frequency

LAWS = ("overlap", "deformable")


def by_modes(case, duration, samples=None, **options):
    """Run a tower for ``duration`` [t0] by the exact propagator."""
    count = samples or max(1, round(1000 * duration))
    return chain_exact.run(chain_of(case), duration * case.contact_time, samples=count, **options)


def by_steps(case, duration, steps_per_contact=4000.0, samples=None, **options):
    """Run a tower for ``duration`` [t0] by Runge-Kutta, or another scheme."""
    chain = chain_of(case)
    step = case.contact_period / steps_per_contact
    step = min(step, 0.5 * STABILITY[options.get("scheme", "rk4")] / highest_frequency(chain))
    count = samples or max(1, round(1000 * duration))
    return chain_stepped.run(chain, duration * case.contact_time, step, samples=count, **options)


def drift(run):
    """Return the largest change of the energy over its largest value."""
    return abs(run.energy - run.energy[0]).max() / (run.kinetic_energy + run.elastic_energy).max()


__all__ = ["LAWS", "Tower", "by_modes", "by_steps", "chain_of", "drift"]
