"""A second route to closed forms of friction: Newton's equations by scipy, limits as events.

A slider is a spring k and a dashpot eta under a constant limit: it sticks while |k q + eta s| is
below the limit, s its velocity; beyond it the spring is cut back so that both hold the limit, until
the spring would grow more slowly than the limit lets it.
"""

import numpy as np
from scipy.integrate import solve_ivp

from harness.model.scene import sphere

RADIUS, DENSITY, G = 0.01, 2500.0, 9.81
MASS = sphere(RADIUS, DENSITY).mass
STILL = (0.0, 0.0)


class Sphere:
    """A sphere on a floor under a constant load: speed, rim speed and the springs of two sliders.

    ``springs`` are (k, eta, limit) of friction and of rolling; ``pull`` [m/s2] is along the floor.
    """

    def __init__(self, *springs, pull=0.0):
        self.springs, self.pull = [*springs, (0.0, 0.0, 0.0)][:2], pull
        self.signs = [0, 0]  # of sliders that slide, 0 of those that stick
        self.changes = []  # time, slider, sign

    def velocities(self, y):
        _, v, rim, *_ = y
        return v - rim, rim

    def force(self, k, y):
        stiffness, eta, limit = self.springs[k]
        if self.signs[k]:
            return self.signs[k] * limit
        return stiffness * y[3 + k] + eta * self.velocities(y)[k]

    def rates(self, _, y):
        friction, rolling = self.force(0, y), self.force(1, y)
        dv, drim = self.pull - friction / MASS, (friction - rolling) / (0.4 * MASS)
        return [y[1], dv, drim, *(self._growth(k, y, (dv - drim, drim)[k]) for k in (0, 1))]

    def _growth(self, k, y, rate):
        stiffness, eta, _ = self.springs[k]
        return -eta * rate / stiffness if self.signs[k] else self.velocities(y)[k]

    def change(self, k):
        def event(t, y):
            if self.springs[k][2] == 0.0:
                return -1.0
            if self.signs[k]:
                return self.signs[k] * (self.rates(t, y)[3 + k] - self.velocities(y)[k])
            return abs(self.force(k, y)) - self.springs[k][2]

        event.terminal, event.direction = True, 1.0
        return event

    def run(self, times, start=STILL):
        """Return x, v, rim speed and springs at times, (M, 5), from a speed and a rim speed."""
        y, t, states = np.array([0.0, *start, 0.0, 0.0]), 0.0, []
        for k in (0, 1):
            if self.springs[k][2] and abs(self.force(k, y)) > self.springs[k][2]:
                self.signs[k] = int(np.sign(self.force(k, y)))
        for end in times:
            while t < end:
                found = solve_ivp(
                    self.rates, (t, end), y, "DOP853", rtol=1e-12, atol=1e-18,
                    events=[self.change(0), self.change(1)],
                )  # fmt: skip
                t, y = found.t[-1], found.y[:, -1]
                for k, at in enumerate(found.t_events):
                    if at.size:
                        self.signs[k] = 0 if self.signs[k] else int(np.sign(self.force(k, y)))
                        self.changes.append((t, k, self.signs[k]))
            states.append(y)
        return np.array(states)
