"""An engine that answers inclines with fates that a test chooses."""

import numpy as np

from harness.cases.incline.result import Motion
from harness.engines.output import Output
from harness.engines.reference.engine import Reference
from harness.errors import EngineError
from harness.observables.provenance import Provenance

EVERY_ROW = 400


class FateEngine:
    """Answers each job with a fate, on a straight path, or with an error."""

    traits = Reference.traits

    def __init__(self, fates=(Motion.TRAPPED, Motion.MOVES_ON), seconds=40.0):
        self.fates, self.seconds, self.jobs = fates, seconds, []

    def run(self, jobs):
        self.jobs += jobs
        return [self._output(job, fate) for job, fate in zip(jobs, self.fates, strict=True)]

    def _output(self, job, fate):
        assert job.values["route"] == "steady"
        if isinstance(fate, EngineError):
            return fate
        time = np.linspace(0.0, self.seconds, EVERY_ROW)
        path = {
            "time_s": time,
            "x_m": 0.5 + time,
            "y_m": 0.9 + 0 * time,
            "vx_m_per_s": 1 + np.sin(time) / 2,
            "vy_m_per_s": 0 * time,
        }
        results = {
            "verdict": fate.value,
            "margin_J": "0",
            "touching": "1",
            "time_s": str(self.seconds),
            "steps": str(job.values["series_every"] * (EVERY_ROW - 1)),
        }
        crests = [("crest", f"{i} {i + 1.0} 0.1 1") for i in range(3)]
        return Output((*results.items(), *crests), Provenance("lammps", "test"), {"series": path})
