"""An engine that answers inclines with fates that a test chooses."""

import numpy as np

from harness.cases.incline.system import Motion, case_of
from harness.engines.output import Output
from harness.engines.reference import Reference
from harness.errors import EngineError
from harness.observables.provenance import Provenance

ROWS = 400


class FateEngine:
    """Answers each job with a fate, on a straight path, or with an error."""

    traits = Reference.traits

    def __init__(self, fates=(Motion.TRAPPED, Motion.MOVES_ON)):
        self.fates, self.jobs = fates, []

    def run(self, jobs):
        self.jobs += jobs
        return [self._output(job, fate) for job, fate in zip(jobs, self.fates, strict=True)]

    def _output(self, job, fate):
        assert job.values["route"] == "steady"
        if isinstance(fate, EngineError):
            return fate
        every = job.values["series_every"]
        time = case_of(job.values).step * every * np.arange(ROWS)
        path = {
            "time_s": time,
            "x_m": 0.5 + time,
            "y_m": 0.9 + 0 * time,
            "vx_m_per_s": 1 + np.sin(time) / 2,
            "vy_m_per_s": 0 * time,
        }
        results = {
            "verdict": fate.value,
            "margin_J": "0.1" if fate is Motion.MOVES_ON else "0",
            "touching": "1",
            "time_s": repr(float(time[-1])),
            "steps": str(every * (ROWS - 1)),
        }
        passed = job.values["wells"] if fate is Motion.MOVES_ON else 3
        times = np.linspace(0, time[-1], passed + 1)[1:]
        crests = [("crest", f"{n} {at!r} 0.1 1") for n, at in enumerate(times.tolist(), 1)]
        return Output((*results.items(), *crests), Provenance("lammps", "test"), {"series": path})
