"""A ball that bounces on a fixed sphere: rebound and contact time."""

import math

from pydantic import Field

from harness.cases.base import Case, Check, Quantity
from harness.cases.checks import equal_steps_checks
from harness.engines.base import scene_job
from harness.engines.scenes import motion_in
from harness.model.base import Parameters
from harness.model.law import Law, damping_ratio
from harness.model.scene import Body, Scene
from harness.results.rows import Kind, Tolerance


class Ball(Parameters):
    """A ball above a fixed sphere of its size, without gravity."""

    stiffness: float = Field(1e6, gt=0.0, le=1e12, description="[N/m] normal stiffness")
    mass: float = Field(1.0, gt=0.0, le=1e6, description="[kg] of the ball")
    diameter: float = Field(1.0, gt=0.0, le=100.0, description="[m] of ball and sphere")
    speed: float = Field(1.0, gt=0.0, le=100.0, description="[m/s] of the impact")
    restitution: float = Field(0.7, ge=1e-3, le=1.0, description="[-] speed after over before")
    steps_per_contact: float = Field(50.0, ge=20.0, le=1e5, description="[-] per pi sqrt(m/k)")

    @property
    def contact_time(self):
        """Return pi / (omega sqrt(1 - zeta^2)) [s], from touch to zero overlap."""
        zeta = damping_ratio(self.restitution)
        return math.pi * math.sqrt(self.mass / self.stiffness / (1.0 - zeta**2))

    @property
    def gap(self):
        """Return the flight before the contact [m]: a tenth of a contact."""
        return 0.1 * self.speed * self.contact_time


class BallOnSphere(Case[Ball]):
    """One head-on bounce."""

    name, group = "ball-on-sphere", "examples"
    summary = "a ball bounces on a fixed sphere: rebound and contact time in closed form"
    parameters = Ball
    quantities = (
        Quantity("rebound", "1", "speed after over speed before the contact"),
        Quantity("contact_time_s", "s", "from touch to zero overlap", lambda p: p.contact_time),
    )
    presets = {f"e = {e:g}": Ball(restitution=e) for e in (0.7, 0.3, 1.0)}  # noqa: RUF012

    def job(self, parameters):
        """Return the job of a bounce, sampled at its start and end."""
        p, step = parameters, math.pi / parameters.steps_per_contact
        step *= math.sqrt(p.mass / p.stiffness)
        steps = math.ceil((1.1 + 0.1 / p.restitution) * p.contact_time / step)
        ball = Body(radius=0.5 * p.diameter, mass=p.mass, velocity=(0.0, 0.0, -p.speed),
                    position=(0.0, 0.0, p.diameter + p.gap))  # fmt: skip
        sphere = Body(radius=0.5 * p.diameter, mass=p.mass, motion="frozen")
        law = Law.linear(p.stiffness, damping_ratio(p.restitution), clipped=False)
        return scene_job(Scene(bodies=(ball, sphere), law=law, step=step, steps=steps, every=steps))

    def measure(self, parameters, output):
        """Return rebound and contact time from the state at the end, which flies freely."""
        motion = motion_in(output, self.scene(parameters))
        height = motion.position[-1, 0, 2] - parameters.diameter
        speed = motion.velocity[-1, 0, 2]
        flight = parameters.gap / parameters.speed + height / speed
        return {"rebound": float(speed) / parameters.speed,
                "contact_time_s": float(motion.time[-1] - flight)}  # fmt: skip

    def exact(self, parameters):
        """Return the damped oscillator's closed forms."""
        return {"rebound": parameters.restitution, "contact_time_s": parameters.contact_time}

    def checks(self, engine):
        """Yield both quantities at equal steps, and the rebound of short steps in closed form."""
        yield from equal_steps_checks(self, engine, self.presets)
        p = Ball(steps_per_contact=2000.0)
        width = math.pi / p.steps_per_contact * (1.0 + 2.0 * damping_ratio(p.restitution))
        yield Check(
            setup="e = 0.7, 2000 steps", quantity="rebound", unit="1", kind=Kind.ANALYTIC,
            measure=lambda bench: self.measure(p, bench.output(self.job(p)))["rebound"],
            expected=p.restitution, jobs=(self.job(p),),
            tolerance=Tolerance(width, reason="omega h (1 + 2 zeta): a step of spring and dashpot"),
        )  # fmt: skip


CASE = BallOnSphere()
