"""The energy map in place of an engine."""

import numpy as np

from harness.cases.incline.runs import Fate, Run
from harness.engines.base import Output
from harness.engines.output import Provenance
from harness.theory.incline import passage_margin

MAP = Output((), Provenance("map", "1"))


class EnergyMap:
    """Measures cases by the energy map of the theory, with jitter, or by a fate of the angle."""

    def __init__(self, shock=0.25, shift=None, fate=None, margin=None, touching=True):
        self.shock, self.shift, self.fate = shock, shift or (lambda _: 0.0), fate
        self.margin, self.touching, self.cases = margin, touching, []

    def __call__(self, cases):
        self.cases += cases
        return [self._run(case) for case in cases]

    def _run(self, case):
        angle = case.angle + self.shift(case)
        left = self.margin(angle) if self.margin else passage_margin(angle, self.shock)
        fate = Fate.MOVES_ON if left >= 0.0 else Fate.TRAPPED
        fate = self.fate(case.angle) if self.fate else fate
        return Run(case, fate, left, self.touching, 1.0, 10, np.empty(0), MAP)
