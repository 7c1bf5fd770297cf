"""Cases and engines that need no other code: a line y = a x, and engines that fail."""

from dataclasses import replace
from types import MappingProxyType, SimpleNamespace

import pytest
from pydantic import Field

from harness.cases import registry as cases
from harness.cases.contract import Case, Measured, Plan, Reference
from harness.cases.display import Display
from harness.cases.verification import Verification
from harness.comparison.regression import BaselineRecord, made_by
from harness.comparison.verdicts import Kind, Planned, Tolerance, judge
from harness.comparison.verification import Findings
from harness.engines import registry as engines
from harness.engines.contract import Engine, Job, Template
from harness.engines.output import Output
from harness.engines.traits import Traits
from harness.errors import EngineCrashError, EngineMissingError
from harness.observables.provenance import Observable, Provenance
from harness.observables.row import Row
from harness.parameters.base import Parameters

NARROW = Tolerance("m", 1e-9, 0.0, "a product of two numbers")


class End(Parameters):
    """Nested parameters."""

    x: float = Field(2.0, gt=0.0, description="[m] abscissa")
    limit: float | None = Field(None, description="[m] largest ordinate")


class LineParameters(Parameters):
    """A line."""

    slope: float = Field(3.0, gt=0.0, description="[-] slope")
    count: int = Field(1, description="[-] how often")
    end: End = Field(End(), description="where it ends")


class Line(Case):
    """y = a x, by plans."""

    name, group, summary = "line", "lines", "A line."
    parameters = LineParameters
    quantities = (
        Observable("y", "m", "", "ordinate"),
        Observable("twice", "m", "", "two ordinates"),
    )
    template = Template("line", {"": {}}, scene=lambda values, spring: None)  # noqa: ARG005
    solvers = ("pencil",)

    @property
    def verification(self):
        return LineVerification(self)

    @property
    def presets(self):
        return {"usual": LineParameters(), "steep": LineParameters(slope=100.0)}

    def job(self, parameters):
        return Job(self.template, {"slope": parameters.slope, "x": parameters.end.x})

    def seconds(self, parameters, rules, solver=""):  # noqa: ARG002
        return 2.0

    def read(self, parameters, output, traits):  # noqa: ARG002
        return {"y": output.number("y"), "twice": 2.0 * output.number("y")}

    def references(self, parameters, traits):  # noqa: ARG002
        return {"y": Reference(parameters.slope * parameters.end.x, "closed form")}

    def solve(self, parameters, solver):
        assert solver == "pencil"
        return Measured({"y": parameters.slope * parameters.end.x})

    def plans(self, level, traits):  # noqa: ARG002
        return [Plan("usual", LineParameters(), {"y": NARROW})]


class LineVerification(Verification):
    regression = MappingProxyType({"y": NARROW})


class Kept(Line):
    """Leaves a record for the baseline, in the main engine and from its solver."""

    name = "kept"

    @property
    def verification(self):
        return KeptVerification(self)


class KeptVerification(LineVerification):
    def run(self, engine, study):
        found = super().run(engine, study)
        if study.role == "other":
            found.published = {"kept": [{"engine": engine.name}]}
            return found
        (output,) = engine.run([self.case.job(LineParameters())])
        found.records.append(record(output.number("y"), output.provenance))
        found.published = {"kept_y_m": output.number("y")}
        return found

    def compare(self, engines):
        if len(engines) < 2:
            return []
        return [judge(" and ".join(engines), Kind.CROSS_CODE, 1.0, 1.0, NARROW)]

    def run_solvers(self, study):  # noqa: ARG002
        check = judge("kept: by pencil", Kind.ANALYTIC, 6.0, 6.0, NARROW)
        return Findings("kept", checks=[check], records=[record(6.0, None)])

    def planned(self, level, engine):  # noqa: ARG002
        return [Planned("kept")]


class Gate(Line):
    """Qualifies."""

    name, qualifies = "gate", True


class Raising(Line):
    """Ends with an exception that nobody foresaw, wherever it is asked."""

    name = "raising"

    @property
    def verification(self):
        return RaisingVerification(self)

    @property
    def display(self):
        return RaisingDisplay(self)


class RaisingVerification(Verification):
    def run(self, engine, study):  # noqa: ARG002
        raise IndexError("list index out of range")

    def run_solvers(self, study):  # noqa: ARG002
        raise ZeroDivisionError("by nothing")

    def compare(self, engines):  # noqa: ARG002
        raise KeyError("nobody")


class RaisingDisplay(Display):
    def sections(self, main, solvers, engines):  # noqa: ARG002
        raise RuntimeError("no ink")


def record(y, who, name="line", **more):
    """Return a record of the baseline."""
    made = made_by(who, "pencil", "1")
    return BaselineRecord(
        name=f"{made['engine']}/{name}",
        parameters={"slope": 3.0, "end": {"x": 2.0, "limit": None}},
        quantities={"y": Row("y", y, 0.0, "m")},
        case="kept",
        label="the line",
        family=("straight",),
        **made,
        **more,
    )


class Toy(Engine):
    """Multiplies."""

    name = "toy"
    traits = Traits(install_hint="buy one", versions=("1",), integrator="none")
    factor = 1.0

    def identify(self):
        return Provenance(self.name, "1", how="by hand")

    def run(self, jobs):
        self.check(jobs)
        return [self._one(job.values) for job in jobs]

    def _one(self, values):
        y = self.factor * values["slope"] * values["x"]
        return Output((("y", repr(y)),), self.identify())

    @classmethod
    def inputs(cls, templates):
        return {f"{template.name}.in": "y = a x" for template in templates}

    def logs(self):
        return {f"{self.name}/line.in": "multiplied"}


class Other(Toy):
    name = "other"
    traits = replace(Toy.traits, versions=("0",))


class Wrong(Toy):
    name, factor = "wrong", 1.1


class Missing(Toy):
    name = "missing"

    def identify(self):
        raise EngineMissingError("no such program")


class Dead(Toy):
    name = "dead"

    def identify(self):
        raise EngineCrashError("signal SIGSEGV")


class Dying(Toy):
    """Qualifies, and dies in every run after that."""

    name = "dying"

    def __init__(self):
        self.left = 1

    def _one(self, values):
        self.left -= 1
        return super()._one(values) if self.left >= 0 else EngineCrashError("signal SIGSEGV")


class Confused(Toy):
    name = "confused"

    def run(self, jobs):  # noqa: ARG002
        raise AttributeError("no attribute")


class Blind(Toy):
    """Has no template of anything."""

    name = "blind"

    @classmethod
    def states(cls, template):  # noqa: ARG003
        return False


ENGINES = (Toy, Other, Wrong, Missing, Dead, Dying, Confused, Blind)


def point(case):
    """Return what stands for the entry point of a case."""
    return SimpleNamespace(name=case.name, value="fakes:case", dist=None, load=lambda: case)


@pytest.fixture
def registered(monkeypatch):
    """Register the stand-ins, and nothing else."""
    known = {case.name: point(case) for case in (Line(), Kept(), Gate(), Raising())}
    monkeypatch.setattr(cases, "plugins", lambda: known)
    monkeypatch.setattr(cases, "_points", lambda: list(known.values()))
    monkeypatch.setattr(cases, "built_in", lambda: ())
    monkeypatch.setattr(cases, "MAIN", ("line", "kept", "raising"))
    monkeypatch.setattr(
        engines, "ENGINES", {kind.name: f"{kind.__module__}:{kind.__name__}" for kind in ENGINES}
    )
    return known
