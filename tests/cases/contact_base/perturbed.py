"""The integration of a law with one coefficient moved, in the place of an engine."""

from dataclasses import replace

import numpy as np

from harness.cases.contact.contact_case import ContactCase
from harness.cases.contact.motion import COLUMNS, TEMPLATE, followed, rules_of
from harness.cases.contact.verification import verify_trials
from harness.cases.registry import built_in, get_case
from harness.cases.verification import Study
from harness.comparison.verdicts import Verdict
from harness.engines.contract import Engine
from harness.engines.lammps.engine import Lammps
from harness.engines.output import SERIES, Output
from harness.observables.provenance import Provenance
from harness.parameters.law import ContactLaw
from harness.parameters.submodels import COEFFICIENTS


def contact_cases():
    """Return the contact cases whose scene is all of their script: it can be integrated."""
    cases = (get_case(name) for name in built_in())
    return [case for case in cases if isinstance(case, ContactCase) and case.template == TEMPLATE]


def series_of(motion, scene):
    """Return a motion as the series that an engine writes of a scene."""
    parts = {
        name: getattr(motion, part)[:, :, i]
        for part, names in COLUMNS.items()
        for i, name in enumerate(names)
    }
    return {SERIES: {"step": np.round(motion.time / scene.step), **parts}}


class Perturbed(Engine):
    """An engine under LAMMPS's rules whose law has a coefficient ``factor`` times as large.

    Jobs are those of its ``case``, whose scenes it integrates.
    """

    name = "perturbed"
    traits = Lammps.traits

    def __init__(self, case, coefficient, factor):
        self.scenes, self.coefficient, self.factor = {}, coefficient, factor
        self.case = self._remembering(type(case))

    def _remembering(self, kind):
        scenes = self.scenes

        class Remembering(kind):
            def job(self, parameters):
                job = super().job(parameters)
                scenes[frozenset(job.values.items())] = self.scene(parameters)
                return job

        return Remembering()

    @classmethod
    def states(cls, template):  # noqa: ARG003
        return True

    def identify(self):
        return Provenance(self.name, "1", (), "", "")

    def run(self, jobs):
        return [self.output(job) for job in jobs]

    def output(self, job):
        scene = self.scenes[frozenset(job.values.items())]
        law = moved(scene.law, self.coefficient, self.factor)
        motion = followed(replace(scene, law=law), rules_of(job, self.traits)).motion
        return Output((), self.identify(), series_of(motion, scene))


class Planted(Engine):
    """An engine that is given another coefficient than it is asked for."""

    title = "Planted"

    def __init__(self, inner, coefficient, factor):
        self.inner, self.traits, self.name = inner, inner.traits, inner.name
        self.change = coefficient, factor

    def identify(self):
        return self.inner.identify()

    def refuses(self, job):
        return self.inner.refuses(job)

    def run(self, jobs):
        name, factor = self.change
        changed = [{**job.values, name: job.values[name] * factor} for job in jobs]
        told = zip(jobs, changed, strict=True)
        return self.inner.run([replace(job, values=values) for job, values in told])


def moved(law, coefficient, factor):
    """Return a law with a coefficient times a factor."""
    values = law.model_dump(exclude_none=True)
    return ContactLaw(**{**values, coefficient: factor * values[coefficient]})


def coefficients_of(law):
    """Return the numerical coefficients that a law has, those that are not 0."""
    return sorted(name for name in COEFFICIENTS if getattr(law, name))


def acts(law, coefficient):
    """Return whether a coefficient has an effect in some motion.

    The tangential dashpot is x_t times the normal one, which is none without damping. Where the
    bulk responds from the first touch on it takes all that is displaced, and nothing yields.
    """
    if coefficient == "tangential_damping":
        return law.damping != "none"
    return not (coefficient == "yield_stress" and law.bulk_response)


def along_normal(scene):
    """Return whether all of a motion is along the normal, so that no friction acts in it."""
    moving = [velocity[:2] for body in scene.bodies for velocity in (body.velocity, body.omega)]
    moving += [v[:2] for piece in scene.segments for v in (*piece.velocities, *piece.omegas)]
    spins = [body.omega[2] for body in scene.bodies]
    spins += [omega[2] for piece in scene.segments for omega in piece.omegas]
    return not any(map(any, moving)) and not any(spins) and not any(scene.gravity[:2])


def trials_of(submodel, level):
    """Return the cases and trials of a submodel, by its name, in the plan of a level."""
    return [
        (case, trial)
        for case in contact_cases()
        for trial in case.trials(level, (*case.submodels, *case.other_submodels))
        if trial.submodel == submodel
    ]


def submodels_of(level):
    """Return the names of the submodels in the plan of a level, in order."""
    plan = (
        trial.submodel
        for case in contact_cases()
        for trial in case.trials(level, (*case.submodels, *case.other_submodels))
    )
    return list(dict.fromkeys(plan))


def rows_of(case, trial, coefficient, level, factor=1.01):
    """Return the rows of a trial with a coefficient moved, those that are judged."""
    engine = Perturbed(case, coefficient, factor)
    found = verify_trials(engine.case, engine, Study(level), [trial])
    return [check for check in found.checks if check.judged]


def unseen(submodel, level, factor=1.01):
    """Return the coefficients of a submodel that no row of a level's plan sees moved.

    Without those that have no effect: in any motion, or in those that it goes through.
    """
    trials = trials_of(submodel, level)
    left = {
        name
        for case, trial in trials
        for name in coefficients_of(trial.parameters.law)
        if acts(trial.parameters.law, name)
        and not (name == "friction" and along_normal(case.scene(trial.parameters)))
    }
    for case, trial in trials:
        for name in left & {*coefficients_of(trial.parameters.law)}:
            rows = rows_of(case, trial, name, level, factor)
            assert rows
            if Verdict.FAIL in {row.verdict for row in rows}:
                left = left - {name}
        if not left:
            break
    return left
