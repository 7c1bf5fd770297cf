"""Say what a report shows of a contact case: its laws in formulas, parameters, and how to rerun."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from harness.cases.contact.verification import TrialRun
from harness.cases.display import Display
from harness.comparison.verification import Findings
from harness.model.conventions import Rules
from harness.parameters.law import ContactLaw
from harness.parameters.submodels import (
    ADHESION,
    BULK,
    EQUAL_E,
    EQUAL_G,
    NORMAL,
    RIGID,
    ROLLING,
    TANGENTIAL,
    TWISTING,
    TWO_E,
    TWO_G,
    YIELD,
)
from harness.report.sections import Drawing, Section, Table
from harness.shown import in_words

if TYPE_CHECKING:
    from harness.cases.contact.contact_case import ContactCase


class ContactDisplay(Display):
    """Shows what a case is; of one submodel alone the law, its parameters and how to run it."""

    case: ContactCase[Any]

    def drawings(self, solvers: Findings, engines: Mapping[str, Findings]) -> Sequence[Drawing]:
        """Return the figures of a case, by the findings of all engines."""
        return ()

    def sections(
        self, main: Findings | None, solvers: Findings, engines: Mapping[str, Findings]
    ) -> Sequence[Section]:
        """Return one section; values and errors stand in the matrix and in the rows."""
        if main is None or not main.evidence:
            return ()
        tried = main.evidence.tried
        alone = tried if len({trial.trial.submodel for trial in tried}) == 1 else ()
        return (
            Section(
                f"Contact: {self.case.name}",
                (self.case.summary, self.case.formula),
                (),
                tuple(_tables(self.case, alone, main.engine)) if alone else (),
                tuple(self.drawings(solvers, {main.engine: main, **engines})),
            ),
        )


def _tables(case: ContactCase[Any], tried: Sequence[TrialRun], engine: str) -> Iterator[Table]:
    """Yield the law of a submodel with the engine's rules, parameters, and commands."""
    yield Table(
        "The law",
        "The law; n points to the first sphere, m* and R* are the reduced mass and radius.",
        ("part", "formula"),
        (*formulas(tried[0].trial.parameters.law), *_rules(tried)),
    )
    yield _parameters(tried)
    commands = tuple((trial.trial.system, _command(case, trial, engine)) for trial in tried)
    yield Table("Run it again", "One run, at the same step.", ("system", "command"), commands)


def formulas(law: ContactLaw) -> Iterator[tuple[str, str]]:
    """Yield each part of a law that is there, and its formula."""
    for part, formula in _parts(law):
        two = formula.replace(EQUAL_E, TWO_E).replace(EQUAL_G, TWO_G)
        yield part, two if law.two_materials else formula


def _parts(law: ContactLaw) -> Iterator[tuple[str, str]]:
    """Yield parts and formulas for two bodies of one material."""
    yield "normal force", NORMAL[law.normal].formula
    if law.yield_stress is not None:
        yield "yield", YIELD
    if law.normal == "mdr" and law.surface_energy:
        yield "adhesion", ADHESION
    if law.bulk_response:
        yield "bulk response", BULK
    dashpot = law.dashpot.formula
    if law.damping != "none":
        ends = ", and no attraction" if law.clipped else ""
        dashpot = f"F_n = F + eta_n d(delta)/dt{ends}; {dashpot}"
    yield "normal damping", dashpot
    if law.tangential != "none":
        limit = "F_t is at most mu |F_n|"
        mine = RIGID if law.normal == "mdr" and "mindlin" in law.tangential else ""
        formula = f"{TANGENTIAL[law.tangential].formula}{mine}; eta_t = x_t eta_n; {limit}"
        yield "tangential force", formula
    if law.rolling != "none":
        yield "rolling resistance", ROLLING[law.rolling].formula
    if law.twisting != "none":
        yield "twisting resistance", TWISTING[law.twisting].formula


def _rules(tried: Sequence[TrialRun]) -> Iterator[tuple[str, str]]:
    """Yield the rules of the engine that are not the default ones and matter, in any system."""
    changed: dict[str, Any] = {}
    for trial in tried:
        changed |= trial.rules.changed
    for name, value in changed.items():
        meaning = (Rules.model_fields[name].description or "").partition("] ")[2]
        yield f"rule: {in_words(name)}", f"{in_words(str(value))} ({meaning})"


def _parameters(tried: Sequence[TrialRun]) -> Table:
    """Return the parameters of the first system, with units, and where the others differ."""
    rows = []
    for name, field in type(tried[0].trial.parameters).model_fields.items():
        values = [getattr(trial.trial.parameters, name) for trial in tried]
        if any(value is not None for value in values):
            unit, _, meaning = (field.description or "[-] ").removeprefix("[").partition("] ")
            texts = [_as_text(value) for value in values]
            text_of_all = (
                texts[0]
                if len({*texts}) == 1
                else "; ".join(
                    f"{trial.trial.system}: {text}"
                    for trial, text in zip(tried, texts, strict=True)
                )
            )
            rows.append((in_words(name), text_of_all, "" if unit == "-" else unit, meaning))
    head = ("parameter", "value", "unit", "meaning")
    caption = "With --set NAME=VALUE, its words joined by _."
    return Table("Parameters", caption, head, tuple(rows))


def _as_text(value: Any) -> str:
    if value is None:
        return "none"
    return f"{value:.9g}" if isinstance(value, float) else str(value).lower()


def _command(case: ContactCase[Any], trial: TrialRun, engine: str) -> str:
    settings = " ".join(f"--set {name}={value}" for name, value in _changes(case, trial))
    return f"dem-harness run {case.name} --engine {engine} {settings}"


def _changes(case: ContactCase[Any], trial: TrialRun) -> Iterator[tuple[str, Any]]:
    """Yield what a trial changes of the default parameters."""
    base = dict(case.default)
    for name, value in trial.trial.parameters:
        if value is not None and base[name] != value:
            yield name, str(value).lower() if isinstance(value, bool) else value
