"""The reference DEM under other names, rules and faults, in place of other engines."""

from dataclasses import replace

from harness.engines.contract import scenes_and_others
from harness.engines.reference import Reference
from harness.engines.traits import FRICTIONLESS, ContactModel
from harness.errors import EngineCrashError, EngineError
from harness.parameters.law import contact_of


def frictionless(needs=None, **states):
    """Return a contact without friction that takes these words alone."""
    known = {name: (word,) for name, word in states.items()}
    return ContactModel("contact", FRICTIONLESS | known, needs=needs)


def least_restitution(least):
    """Return a contact without friction that takes restitutions from one on."""

    def needs(values):
        return (
            ""
            if values.get("restitution", 1.0) >= least
            else f"takes restitutions from {least:g} on"
        )

    return frictionless(needs)


def most_damping(most, **states):
    """Return a contact without friction that takes damping ratios up to one."""

    def needs(values):
        weak = "damping" not in values or contact_of(values).zeta <= most
        return "" if weak else f"takes damping ratios up to {most:g}"

    return frictionless(needs, **states)


TRAITS = replace(Reference.traits, install_hint="apt install it", title="", conventions=None)


class Twin(Reference):
    """The reference DEM in the scheme that it declares.

    ``change_values`` and ``change_output`` are faults: of what it is told, of what it tells.
    """

    name = "twin"
    traits = replace(TRAITS, lineage="LAMMPS", title="Twin")

    def __init__(self, change_values=dict, change_output=lambda _, output: output):
        super().__init__(self.traits.integrator or "velocity-verlet")
        self.change_values, self.change_output = change_values, change_output
        self.jobs = []

    def run(self, jobs):
        self.check(jobs)
        self.jobs += jobs
        return scenes_and_others(jobs, self.run_scene_jobs, self.run_grains)

    def run_grains(self, jobs):
        scenes = [job.template.scene(self.change_values(job.values)) for job in jobs]
        return [
            output if isinstance(output, EngineError) else self.change_output(job, output)
            for job, output in zip(jobs, self.run_scenes(scenes), strict=True)
        ]


class Clamped(Twin):
    name = "clamped"
    traits = replace(TRAITS, frictionless=frictionless(tail="clipped"))


class Half(Twin):
    """As MFiX: half the mass, the tail kept, semi-implicit Euler."""

    name = "half"
    traits = replace(
        TRAITS,
        frictionless=frictionless(tail="attractive", effective_mass="half"),
        integrator="mfix-euler",
    )


class Crashing(Twin):
    name = "crashing"

    def run(self, jobs):
        deaths = []
        for _ in jobs:
            error = EngineCrashError("signal SIGSEGV")
            error.log = "input\nlast words\n"
            deaths.append(error)
        return deaths
