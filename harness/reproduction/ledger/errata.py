"""The errata of our restatement of the source, one row each, judged by the rows of this run.

Where a row is about the restatement, its ``where`` says so: the standing is that of
the erratum, not of the source.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from harness.reproduction.as_printed import Printed
from harness.reproduction.claims import Ledger, Source, Standing, Statement, Width, claim, compare
from harness.reproduction.ledger.discussion_energy import row_energy
from harness.theory.tower import series_stiffness

_PLACE = "Errata, of the source"


@dataclass(frozen=True)
class Erratum:
    """What the restatement calls wrong, and the rows that are to show it.

    ``wrong`` are keys of the source's statements that must not hold as printed,
    ``right`` of those that must.
    """

    key: str
    says: str
    wrong: tuple[str, ...]
    right: tuple[str, ...] = ()
    where: str = _PLACE

    def judged(self, rows: Ledger) -> Statement:
        """Return the row of this erratum from the rows of the source."""
        wrong = [rows[key] for key in self.wrong]
        right = [rows[key] for key in self.right]
        return claim(
            Source(self.key, self.where, self.says),
            holds=all(row.standing is not Standing.REPRODUCED for row in wrong)
            and all(row.standing is Standing.REPRODUCED for row in right),
            computed="; ".join(_told(row) for row in (*wrong, *right)),
            evidence=tuple(dict.fromkeys(link for row in wrong for link in row.evidence)),
            why="the rows named must stand as the erratum says",
        )


def _told(row: Statement) -> str:
    """Return key, standing and the numbers of a row, in words if it has none."""
    if np.isnan(row.printed):
        return f"{row.source.key}, {row.standing}: {row.computed}"
    numbers = f"printed {row.printed:.6g}, found {row.found:.6g}"
    if not np.isnan(row.corrected):
        numbers += f", corrected {row.corrected:.6g}"
    unit = "" if row.unit == "1" else f" {row.unit}"
    return f"{row.source.key}, {row.standing}: {numbers}{unit}"


_ERRATA = {
    erratum.key: erratum
    for erratum in (
        Erratum(
            "erratum-2",
            "the r_0 term of b_0 must vanish for even n and be -r_0 for odd n; the example of "
            "four agrees",
            ("eq-16", "eq-a7"),
            ("eq-four",),
        ),
        Erratum("erratum-3", "the general sum for b_n does not follow", ("eq-a2",), ("eq-a1",)),
        Erratum("erratum-4", "maximal compression is 2r_0 - (x_j - x_i)", ("eq-a8",)),
        Erratum(
            "erratum-5",
            "the shock with e_n is the energy of the velocity lost; right is 1/4 + 3/4 e^2",
            ("eq-7", "eq-9"),
            ("eq-8", "text-shock"),
        ),
        Erratum("erratum-6", "v_i alpha against 1 - alpha/2: they contradict", ("eq-13",)),
        Erratum("erratum-8", "the damping term of the collision time needs 1/4", ("eq-12",)),
        Erratum("erratum-9", "two particles have a solution, half a wave", ("text-no-solution",)),
        Erratum("erratum-10", "signs of a_1 and a_2 are exchanged", ("eq-15",)),
        Erratum("erratum-11", "E_n goes to infinity at shock 1 already", ("text-divergence",)),
    )
}


def statements(printed: Printed, rows: Ledger) -> list[Statement]:
    """Return the thirteen errata in order; ``rows`` are those of the source."""
    own = {
        "erratum-1": _steady_state(rows),
        "erratum-7": _crest_time(printed, rows),
        "erratum-12": _energies(rows),
        "erratum-13": _series(),
    }
    judged = {key: erratum.judged(rows) for key, erratum in _ERRATA.items()} | own
    return [judged[f"erratum-{i}"] for i in range(1, len(judged) + 1)]


def _steady_state(rows: Ledger) -> Statement:
    row = rows["eq-6"]
    return claim(
        Source(
            "erratum-1", _PLACE, "theta/4 in the steady-state condition gives 13.87 deg, theta/2 "
            "10.21 deg",
        ),
        holds=abs(row.printed - 13.87) < 0.005
        and abs(row.corrected - 10.21) < 0.005
        and row.standing is Standing.CORRECTED,
        computed=_told(row),
        evidence=row.evidence,
        why="half of the last digit given",
    )  # fmt: skip


def _crest_time(printed: Printed, rows: Ledger) -> Statement:
    formula = rows["eq-11"].found
    ratio = formula / printed.contact_time
    separated = rows["text-separation"].standing is Standing.REPRODUCED
    told = abs(formula - 0.029) < 0.0005 and round(ratio) == 4
    return claim(
        Source(
            "erratum-7",
            _PLACE,
            "t_c evaluates to 0.029 s, so that the separation of scales is about 4, not 58",
        ),
        holds=told and not separated,
        corrected_holds=told,
        computed=f"{_told(rows['text-t-c'])}; over t_n {ratio:.2f}; "
        + rows["text-separation"].computed,
        correction="the formula gives 4, but it is no rise time: the rise itself lasts many "
        "times longer",
        evidence=rows["text-separation"].evidence,
    )


def _energies(rows: Ledger) -> Statement:
    square, two = rows["eq-18"], rows["eq-u-2"]
    wrong = all(row.standing is Standing.CORRECTED for row in (square, two))
    stiffness, first, n = 100.0, 0.2, 10
    with_square = n * 0.5 * stiffness * (n * first) ** 2
    right = n * 0.5 * stiffness * first**2
    return claim(
        Source(
            "erratum-12",
            _PLACE,
            "the energy of n springs lacks the square of c_n; U_2 has a factor that does not give "
            "2 U_1",
        ),
        holds=wrong and abs(with_square - right) < 1e-9,
        corrected_holds=wrong,
        computed=f"{_told(square)}; {_told(two)}; n (1/2 k c_n^2) would be {with_square:g} J where "
        f"the springs store {right:g} J (n = {n})",
        correction="the square of c_1, not of c_n; what U_2 lacks is k",
        evidence=square.evidence,
    )


def _series() -> Statement:
    n = 10
    found = 1 / (2 * row_energy(n, 1.0, 1.0))
    return compare(
        Source("erratum-13", _PLACE, "k/n is not the stiffness of the source's law; k/(2n - 1) is"),
        printed=series_stiffness(n, 1.0, deformable=True),
        found=found,
        width=Width(1e-12, "k", "round-off"),
        computed=f"force over approach of the outer centres of {n} contacts under the deformable "
        f"law: {found:.6f} k; k/n would be {1 / n:g} k",
        evidence=("tests/theory/test_chain.py",),
    )
