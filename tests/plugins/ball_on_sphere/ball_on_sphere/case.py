"""A ball that bounces on a fixed sphere: rebound and contact time against the closed form."""

import math

import numpy as np
from harness.cases.contract import Case, Plan, Reference
from harness.comparison.verdicts import Tolerance
from harness.parameters.base import Parameters
from harness.parameters.law import Contact
from harness.parameters.scene import in_plane, spheres
from pydantic import Field

from harness.engines.contract import Job, Template
from harness.engines.provenance import Observable

STEP = Tolerance("", 0.0, 2e-3, "a step of pi/2000 of the contact's phase, at its begin and end")


class Ball(Parameters):
    """A ball above a fixed sphere of its size; no gravity."""

    stiffness: float = Field(1e6, gt=0.0, description="[N/m] normal stiffness")
    mass: float = Field(1.0, gt=0.0, description="[kg] of the ball")
    diameter: float = Field(1.0, gt=0.0, description="[m] of ball and sphere")
    speed: float = Field(1.0, gt=0.0, description="[m/s] of the impact")
    restitution: float = Field(0.7, gt=0.0, le=1.0, description="[-] nominal restitution")
    steps_per_contact: float = Field(2000.0, gt=20.0, le=1e5, description="[-] per pi sqrt(m/k)")

    @property
    def zeta(self):
        """Return the damping ratio of the restitution."""
        return -math.log(self.restitution) / math.hypot(math.pi, math.log(self.restitution))

    @property
    def contact_time(self):
        """Return pi / (omega sqrt(1 - zeta^2)) [s], until the overlap is zero again."""
        return math.pi * math.sqrt(self.mass / self.stiffness / (1.0 - self.zeta**2))

    @property
    def gap(self):
        """Return the flight before and after [m]: a tenth of a contact."""
        return 0.1 * self.speed * self.contact_time

    @property
    def step(self):
        """Return the step [s]."""
        return math.pi * math.sqrt(self.mass / self.stiffness) / self.steps_per_contact

    @property
    def steps(self):
        """Return the number of steps: both flights, and the contact."""
        return math.ceil((1.1 + 0.1 / self.restitution) * self.contact_time / self.step)


def values_of(p):
    """Return what scripts are told."""
    return {"stiffness": p.stiffness, "mass": p.mass, "diameter": p.diameter, "speed": p.speed,
            "zeta": p.zeta, "gap": p.gap, "step": p.step, "steps": p.steps}  # fmt: skip


def scene_of(values):
    """Return ball and sphere as arrays."""
    d = values["diameter"]
    bodies = spheres(
        position=[[0.0, d + values["gap"]], [0.0, 0.0]],
        velocity=[[0.0, -values["speed"]], [0.0, 0.0]],
        mass=[values["mass"]] * 2,
        diameter=[d, d],
        fixed=[False, True],
    )
    return in_plane(
        bodies,
        Contact(damping_ratio=values["zeta"]),
        values["stiffness"],
        gravity=(0.0, 0.0),
        step=values["step"],
        steps=values["steps"],
        every=values["steps"],
    )


class BallOnSphere(Case):
    """One head-on bounce."""

    name, group = "ball-on-sphere", "examples"
    summary = "A ball bounces on a fixed sphere: rebound and contact time in closed form."
    parameters = Ball
    quantities = (
        Observable("rebound", "1", "", "speed after over speed before the contact"),
        Observable("contact_time_s", "s", "", "from touch to zero overlap"),
    )
    template = Template("ball-on-sphere", {"": values_of(Ball())}, package="ball_on_sphere",
                        scene=scene_of)  # fmt: skip

    def job(self, parameters):
        """Return the job of a bounce."""
        return Job(self.template, values_of(parameters), sampled=False)

    def read(self, parameters, output, traits):
        """Return rebound and contact time from the state at the end."""
        if output.has("vy_m_per_s"):
            t, y, v = (output.number(name) for name in ("time_s", "y_m", "vy_m_per_s"))
        else:
            table = output.table(("time_s", "y_m", "vy_m_per_s"))
            t, y, v = (float(np.reshape(table[name][-1], -1)[0]) for name in
                       ("time_s", "y_m", "vy_m_per_s"))  # fmt: skip
        leaves = t - (y - parameters.diameter) / v
        return {
            "rebound": v / parameters.speed,
            "contact_time_s": leaves - parameters.gap / parameters.speed,
        }

    def references(self, parameters, traits):
        """Return the damped oscillator's closed forms."""
        return {
            "rebound": Reference(parameters.restitution, "closed form"),
            "contact_time_s": Reference(parameters.contact_time, "closed form"),
        }

    def plans(self, level, traits):
        """Return bounces at three restitutions."""
        return [
            Plan(f"e = {e:g}", Ball(restitution=e), {"rebound": STEP, "contact_time_s": STEP})
            for e in (0.3, 0.7, 1.0)
        ]


CASE = BallOnSphere()
