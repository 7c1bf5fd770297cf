"""Engines that run towers by this package: LAMMPS's script with planted faults, or Euler's."""

from dataclasses import replace

import numpy as np

from harness.cases.tower.parameters import Tower
from harness.cases.tower.runs import make_setup, solve
from harness.engines.base import Engine, Traits
from harness.engines.output import SERIES, Output, Provenance
from harness.engines.reference import Reference
from harness.model.conventions import Rules


class Standin(Engine):
    """Has a script for both laws, and writes what LAMMPS's does: forces with the weight.

    ``change_case``, ``change_steps`` and ``change_table`` plant faults.
    """

    name = "standin"
    traits = Traits(install_hint="comes with the tests", versions=("1",))

    def __init__(self, change_case=None, change_table=None, step=1.0):
        self.change_case, self.change_table, self.step = change_case, change_table, step
        self.jobs = []

    def identify(self):
        return Provenance("standin", "1")

    @classmethod
    def has_template(cls, template):
        return template.name == "tower"

    def rules(self, scene):  # noqa: ARG002
        return Rules()

    def run(self, jobs):
        self.jobs += jobs
        return [self._output(self._table(job)) for job in jobs]

    def _output(self, table):
        table = self.change_table(table) if self.change_table else table
        return Output((), self.identify(), {SERIES: table})

    def _table(self, job):
        values = job.values
        case = Tower(**{name: values[name] for name in Tower.model_fields})
        wrong = self.change_case(case) if self.change_case else case
        steps = values["steps_per_contact"]
        setup = make_setup(case, values["duration"], steps)
        count = setup.steps // values["series_every"]
        # the same number of steps, each longer by the factor
        run = solve(
            wrong, "verlet", samples=count,
            duration=values["duration"] * case.contact_time * self.step / wrong.contact_time,
            steps_per_contact=steps / self.step * wrong.contact_period / case.contact_period,
        )  # fmt: skip
        pushes = np.pad(run.forces, ((0, 0), (1, 1)))
        diameter = wrong.each("diameter")[0] * np.arange(case.particles)
        return {
            "step": values["series_every"] * np.arange(float(run.time.size)),
            "x_m": run.displacements + diameter,
            "vx_m_per_s": run.velocities,
            "fx_N": pushes[:, :-1] - pushes[:, 1:] + wrong.each("mass")[0] * wrong.gravity,
        }


class Euler(Reference):
    """A code of first order with seven digits, which runs scenes."""

    def __init__(self):
        super().__init__("mfix-euler")
        self.traits = replace(self.traits, digits=7)

    def run(self, jobs):
        return [replace(output, tables=_rounded(output.tables)) for output in super().run(jobs)]


def _rounded(tables):
    digits = np.vectorize(lambda value: float(f"{value:.6e}"))
    return {SERIES: {name: column if name == "step" else digits(column)
                     for name, column in tables[SERIES].items()}}  # fmt: skip
