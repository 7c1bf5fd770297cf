"""Kratos itself: the drops, the reference DEM's paths and angles, the known traps."""

import math
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

from harness.cases.drop import case as drops
from harness.cases.incline.runs import run_inclines
from harness.cases.incline.system import Incline, Motion, scene_of, values_of
from harness.cases.qualification import qualify
from harness.engines.kratos.engine import REFERENCE, Kratos
from harness.engines.reference import Reference
from harness.parameters.law import CLIPPED, PLASTIC

pytestmark = pytest.mark.live

BOTH = pytest.mark.parametrize("scheme", REFERENCE)
EPS = np.finfo(float).eps


@pytest.fixture(scope="module")
def engines(kratos_here):  # noqa: ARG001
    """Return an engine for each of Kratos's integrators."""
    found = {scheme: Kratos(scheme=scheme) for scheme in REFERENCE}
    yield found
    for engine in found.values():
        engine.close()


@BOTH
def test_kratos_qualifies(engines, scheme):
    found = qualify(engines[scheme])
    assert found.holds, found.failures
    assert len(found.checks) == 9


@BOTH
@pytest.mark.parametrize("route", ["passage", "steady"])
@pytest.mark.parametrize("contact", [PLASTIC, CLIPPED], ids=lambda contact: contact.name)
def test_the_path_is_the_reference_s_step_by_step(engines, scheme, route, contact):
    case = Incline(contact=contact, angle=12.0, stiffness=1e5, steps_per_contact=50.0, wells=3)
    (run,) = run_inclines(engines[scheme], [case], route, every=1)
    path = run.trajectory
    scene = scene_of(values_of(case, route, every=1))
    # the reference's own judging would begin anew at each crest
    expected = Reference(REFERENCE[scheme]).follow(replace(scene, steps=run.steps))
    assert run.motion is Motion.MOVES_ON
    assert path.x_m.size == run.steps + 1
    # eps of a position is k eps of force, and over the time of the run of velocity
    rounding = EPS * case.stiffness / case.mass * run.time_s
    for name, values in vars(path).items():
        expected_values = getattr(expected, name)[: values.size]
        np.testing.assert_allclose(values, expected_values, rtol=0, atol=rounding, err_msg=name)


class Changed(Kratos):
    """Kratos with other parameters than the harness gives it: how users fall into its traps."""

    def __init__(self, change):
        super().__init__()
        self._change = change

    def settings(self, job):
        return {**super().settings(job), **self._change(job.values)}


def failures(engine):
    with engine:
        return qualify(engine).failures


@pytest.mark.slow
@pytest.mark.usefixtures("kratos_here")
def test_contacts_found_late_are_caught():
    """The tolerance for spheres alone, and a search every so many steps.

    Not 50, Kratos's default: the script would search at step 101, and the drop meets its
    sphere after 100.5.
    """
    naive = Changed(lambda _: {"search_tolerance_against_walls": 0.0, "search_every": 40})
    assert "contact found within two steps" in failures(naive)


def gamma_of_kratos(*restitutions):
    """Return the damping that Kratos's own Python finds for each restitution."""
    code = (
        "from KratosMultiphysics.DEMApplication.sphere_strategy import ExplicitStrategy as E\n"
        "e = E.__new__(E)\n"
        f"for r in {restitutions}:\n"
        "    print('GAMMA', repr(e.RootByBisection(e.coeff_of_rest_diff, 0.0, 16.0, 1e-4, 300, r)))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    words = [line.split() for line in done.stdout.splitlines()]
    return [float(word[1]) for word in words if word and word[0] == "GAMMA"]


@pytest.mark.slow
@pytest.mark.usefixtures("kratos_here")
def test_restitution_and_mass_left_to_kratos_are_caught():
    """Its own inversion has a floor and takes the fixed sphere's mass, so m/2, as it stands."""
    half, tiny, none, least = gamma_of_kratos(0.5, 1e-20, 0.0, 0.001)
    assert tiny == none == least
    table = {0.5: half, 1e-20: tiny}

    def left_to_kratos(values):
        case, ratio = drops.case_of(values), values["damping"] == "ratio"
        gamma = values["damping_ratio"] if ratio else table[values["restitution"]]
        return {"damping": 2.0 * gamma * math.sqrt(case.stiffness * case.mass / 2.0)}

    failed = failures(Changed(left_to_kratos))
    assert "restitution head-on, e = 0.5, clipped, m_eff full" in failed
    assert "restitution head-on, source, clipped" in failed
