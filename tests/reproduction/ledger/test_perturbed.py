"""No row is typed in: change a number that is printed, or the physics, and a verdict changes."""

from dataclasses import fields, replace
from functools import cache
from importlib import import_module

import numpy as np
import pytest

from harness.parameters.tower import Tower
from harness.reproduction.claims import PRINTED, ClaimStatus, Ledger, Printed
from harness.reproduction.ledger import samples
from harness.theory.chain import compliance

PACKAGE = "harness.reproduction.ledger"
REPRODUCED, CORRECTED = ClaimStatus.REPRODUCED, ClaimStatus.CORRECTED
NOT = ClaimStatus.NOT_REPRODUCED


MODULES = {
    name: import_module(f"{PACKAGE}.{name}")
    for name in ("background", "methods", "results", "appendix")
}


def module_of(name):
    """Return the module that has the rows of a section of the source."""
    return next(one for one in MODULES.values() if hasattr(one, f"{name}_statements"))


def rows_of(name, printed=PRINTED):
    """Yield the rows of one section, with what is printed."""
    engine = (None,) if name == "background_incline" else ()
    yield from getattr(module_of(name), f"{name}_statements")(printed, *engine)


def section(name):
    return Ledger(tuple(rows_of(name)))


def row_of(name, key, printed=PRINTED):
    """Return one row; those that come after it are not computed."""
    return next(row for row in rows_of(name, printed) if row.source.key == key)


as_it_is = cache(section)


PRINTED_OTHERWISE = [
    ("background_energy", "critical_angle_deg", 10.22, "text-critical-angle", NOT),
    ("background_energy", "well_divisor", 2.0, "eq-6", REPRODUCED),
    ("background_energy", "critical_angle_deg", 20.0, "text-constant-contact", NOT),
    ("background_energy", "diverges_above", 1.01, "text-divergence", NOT),
    ("background_energy", "shock", 0.26, "text-shock", NOT),
    ("background_incline", "restitution", 0.5, "text-restitution", NOT),
    ("background_incline", "simulated_within_deg", 0.001, "text-mfix-angle", NOT),
    ("background_incline", "rest_angle_deg", 29.0, "text-rest-angle", NOT),
    ("methods_scales", "gravity", 1.62, "text-glass-bead", NOT),
    ("methods_scales", "glass_rigidity", 60_000.0, "text-glass-bead", NOT),
    ("methods_scales", "glass_depth", 5.0, "text-glass-bead", NOT),
    ("methods_scales", "rigidities", (1e4, 1e7), "text-orders-of-magnitude", REPRODUCED),
    ("methods_scales", "orders_of_magnitude", 2.0, "text-orders-of-magnitude", REPRODUCED),
    ("methods_scales", "stiffnesses", (1e6, 1e7), "text-stiffness-lowest", NOT),
    ("methods_scales", "median_rigidity", 1e6, "text-median-rigidity", NOT),
    ("methods_scales", "crest_time", 0.029, "text-t-c", REPRODUCED),
    ("methods_scales", "crest_time", 0.029, "text-crest-time", NOT),
    ("methods_scales", "contact_time", 0.01, "text-t-n", NOT),
    ("methods_scales", "damping_factor", 0.25, "eq-12", REPRODUCED),
    ("methods_pair", "error_percent", 0.01, "text-error-size", NOT),
    ("methods_pair", "error_stiffness", 1e5, "text-error-size", NOT),
    ("results", "joins", 0.7, "text-joins", NOT),
    ("results", "returns", 1.2, "text-returns", NOT),
    ("results", "leaves", 2.0, "text-leaves", NOT),
    ("results", "longest_chain", 4, "text-plateau", REPRODUCED),
    ("results", "longest_chain", 4, "text-little-effect", NOT),
    ("results", "speeds", (2.0, 40.0), "text-six-runs", NOT),
    ("results", "heights", (1, 30), "text-six-runs", NOT),
    ("discussion", "speed_exponent", 1.0, "text-sqrt-n", NOT),
    ("discussion", "difference_percent", 1e-3, "text-differences", REPRODUCED),
    ("discussion", "halved", 0.3, "text-halved", NOT),
    ("discussion", "longest_chain", 9, "text-longest-chain", NOT),
    ("appendix_window", "search", 4.0, "text-within-bound", REPRODUCED),
    ("appendix_window", "first_packet", 1.0, "text-first-packet", NOT),
    ("appendix_window", "structure_particles", (2, 5), "text-structure-window", REPRODUCED),
    ("appendix_window", "window_figure", (3, 3), "text-window-figure", REPRODUCED),
]


@pytest.mark.parametrize(
    ("module", "name", "value", "key", "status"),
    PRINTED_OTHERWISE,
    ids=[f"{case[1]}-{case[3]}" for case in PRINTED_OTHERWISE],
)
def test_another_printed_number_changes_the_verdict(module, name, value, key, status):
    before = as_it_is(module)[key]
    after = row_of(module, key, replace(PRINTED, **{name: value}))
    assert after.status is status
    assert after.status is not before.status or after.printed != before.printed


def test_every_printed_number_is_perturbed():
    assert {field.name for field in fields(Printed)} == {case[1] for case in PRINTED_OTHERWISE}


def patched_collide(velocity, _):
    return np.array([0.1, velocity[1]])  # some of the normal velocity stays


PHYSICS_OTHERWISE = [
    ("background_energy", "after_next_shock", lambda e, _, s: 0.9 * s * (e + 0.18), "eq-6", NOT),
    ("background_energy", "collide", patched_collide, "text-shock", NOT),
    ("introduction", "stiffness_of_springs", lambda n: 1 / (2 * n - 1), "eq-1", NOT),
    ("methods_pair", "pushes", lambda x: np.zeros(x.size), "eq-15", NOT),
    ("methods_chain", "motion.first_boundary", lambda x, r: x[0] - r, "eq-16", NOT),
    ("appendix_chains", "forces.compressions", lambda x, _: 0.01 * x[1:], "eq-a4", NOT),
    ("appendix_chains", "forces.compressions", lambda x, _: 0.01 * x[1:], "text-sweeps", NOT),
    (
        "discussion", "compliance", lambda n, deformable: compliance(n, not deformable),
        "text-u-n-particles", REPRODUCED,
    ),
    (
        "results", "run", lambda case, *span: samples.run(case.replace(law="overlap"), *span),
        "text-parts", NOT,
    ),
    (
        "results", "run", lambda case, *span: samples.run(case.replace(gravity=0.0), *span),
        "text-unit-of-time", NOT,
    ),
    (
        "results", "ratios",
        lambda *_: dict.fromkeys(samples.ratios(), dict.fromkeys(range(1, 20), 1.0)),
        "text-angle-falls", NOT,
    ),
    (
        "appendix_window", "run",
        lambda case, span=3.0: samples.run(Tower(height=case.height, gravity=400.0), span),
        "text-two-particles", NOT,
    ),
]  # fmt: skip


@pytest.mark.parametrize(
    ("module", "name", "other", "key", "status"),
    PHYSICS_OTHERWISE,
    ids=[f"{case[1]}-{case[3]}" for case in PHYSICS_OTHERWISE],
)
def test_other_physics_changes_the_verdict(monkeypatch, module, name, other, key, status):
    before = as_it_is(module)[key]
    monkeypatch.setattr(f"{module_of(module).__name__}.{name}", other)
    after = row_of(module, key)
    assert after.status is status
    assert after.status is not before.status
