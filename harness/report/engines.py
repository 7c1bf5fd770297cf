"""The words and tables on engines beside one another, for the page and for Markdown."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

from harness.comparison.engine_evidence import OWN, Declared, EngineEvidence, Rules

TITLE = "Engines beside one another"

EXPLAINED = (
    "Two classes of contact law must not be compared as one: a code that clips the attractive "
    "tail rebounds where one that keeps it does not, and half the effective mass damps less. So "
    "each engine stands beside theory, and beside the reference DEM under the engine's own rules "
    "(tail, effective mass, spring, scheme, step). Differences between classes are findings. An "
    "engine is believed after it has qualified by drops on one fixed sphere. Agreement with an "
    "engine that grew out of another is a regression test, not independent evidence."
)


@dataclass(frozen=True)
class Table:
    """A table of a report: caption, head, rows, and which columns are numbers or sentences."""

    label: str
    caption: str
    head: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    numeric: frozenset[int]
    prose: frozenset[int] = frozenset()

    def look(self, column: int) -> str:
        """Return the class of a column's cells: numbers, sentences, or neither."""
        return "n" if column in self.numeric else "prose" if column in self.prose else ""

    def markdown(self) -> list[str]:
        """Return the table as lines of Markdown."""
        marks = ["--:" if i in self.numeric else "---" for i in range(len(self.head))]
        lines = [f"| {' | '.join(self.head)} |", f"|{'|'.join(marks)}|"]
        for row in self.rows:
            lines.append("| " + " | ".join(cell.replace("|", "\\|") for cell in row) + " |")
        return [self.caption, "", *lines, ""]


def tables(evidence: EngineEvidence) -> list[Table]:
    """Return the tables of angles, towers and declarations; those without rows are left out."""
    made = (_angles(evidence), _towers(evidence), _declared(evidence))
    return [table for table in made if table.rows]


def caveats(evidence: EngineEvidence) -> list[tuple[str, tuple[str, ...]]]:
    """Return the traps of each engine that has some."""
    return [(d.engine, d.caveats) for d in evidence.declared if d.caveats]


def _angles(evidence: EngineEvidence) -> Table:
    rows = [
        (
            angle.engine,
            angle.contact,
            f"{angle.stiffness:.3g}",
            f"{angle.steps_per_contact:.3g}",
            f"{angle.value_deg:.5f} ± {angle.uncertainty_deg:.1g}",
            _signed(angle.off_theory_deg),
            "" if angle.engine == OWN else _signed(angle.off_reference_deg),
            _number(angle.microseconds_per_step, ".2g"),
            _short(angle.rules),
            angle.evidence,
        )
        for angle in evidence.angles
    ]
    return Table(
        "Critical angles",
        f"Critical angle by passage, less the closed form ({evidence.closed_form_deg:.5f} deg), "
        "and less that of the reference DEM under the same rules. The class is tail, effective "
        "mass against a fixed sphere, spring. The cost of a step leaves out what starting a "
        "run costs.",
        (
            "engine",
            "contact",
            "k (N/m)",
            "steps",
            "angle (deg)",
            "less theory",
            "less reference",
            "µs per step",
            "class",
            "evidence",
        ),
        tuple(rows),
        frozenset(range(2, 8)),
    )


def _towers(evidence: EngineEvidence) -> Table:
    heights = sorted({tower.height for tower in evidence.towers})
    by_engine = {(t.engine, t.height): t for t in evidence.towers}
    orders = {found.solver: found.l2_order for found in evidence.convergence}
    rows = []
    for engine in _in_order(tower.engine for tower in evidence.towers):
        cells, steps = [], 0.0
        for height in heights:
            tower = by_engine.get((engine, height))
            errors = () if tower is None else (tower.peak_error, tower.impulse_error)
            known = [abs(error) for error in errors if not math.isnan(error)]
            cells.append(f"{max(known):.1e}" if known else "")
            steps = tower.steps_per_contact if tower else steps
        order = orders.get(engine)
        told = "" if order is None or math.isnan(order.value) else f"{order.value:.2f}"
        rows.append((engine, f"{steps:.0f}", *cells, told))
    return Table(
        "Towers",
        "Towers under the overlap law, k = 1e5 N/m, 2 m/s: the larger of the relative errors of "
        "peak force and turnaround impulse (recorded: peak force alone) against the exact "
        "propagator, and the order of the force error in the step.",
        ("engine", "steps", *(f"n = {height}" for height in heights), "order"),
        tuple(rows),
        frozenset(range(1, len(heights) + 3)),
    )


def _declared(evidence: EngineEvidence) -> Table:
    rows = [
        (
            declared.engine,
            ", ".join(filter(None, (declared.version, declared.how))) or "not here",
            ", ".join(declared.tails),
            ", ".join("m" if mass == "full" else "m/2" for mass in declared.effective_masses),
            declared.spring,
            declared.integrator or "its own",
            str(declared.digits),
            declared.lineage or "independent",
            _standing(declared),
        )
        for declared in evidence.declared
    ]
    return Table(
        "What each engine declares",
        "What each engine declares. Tail and effective mass are those that it can be told; the "
        "scheme is the reference DEM's name for it.",
        (
            "engine",
            "version",
            "tails",
            "m_eff",
            "spring",
            "scheme",
            "digits",
            "grew out of",
            "standing",
        ),
        tuple(rows),
        frozenset({6}),
        frozenset({8}),
    )


def _standing(declared: Declared) -> str:
    reason = declared.missing or declared.unqualified
    return f"{declared.standing}: {reason}" if reason else declared.standing


def _in_order(names: Iterable[str]) -> list[str]:
    return list(dict.fromkeys(names))


def _short(rules: Rules) -> str:
    mass = "m" if rules.effective_mass == "full" else "m/2"
    return f"{rules.tail}, {mass}, {rules.spring}"


def _signed(value: float) -> str:
    return "0" if value == 0.0 else _number(value, "+.2g")


def _number(value: float, form: str) -> str:
    return "" if math.isnan(value) else format(value, form)
