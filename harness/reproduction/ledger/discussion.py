"""Sections Discussion and Conclusion: the angles of the energy argument, and how stiff is stiff."""

from __future__ import annotations

from harness.cases.tower.impulse_angles import angle_from_impulse_ratio
from harness.parameters.tower import LAWS, Tower
from harness.reproduction.as_printed import Printed
from harness.reproduction.claims import (
    Source,
    Statement,
    Width,
    claim,
    compare,
    untestable,
)
from harness.reproduction.ledger.results_impulse import longest_chains
from harness.reproduction.ledger.runs import ratios, run
from harness.reproduction.ledger.widths import last_digit
from harness.theory import energy_scaling

_ENERGY = ("tests/theory/test_energy_scaling.py",)
_IMPULSES = ("tests/verbs/test_impulse_angles.py",)


def statements(printed: Printed) -> list[Statement]:
    """Return the rows in the order of the text."""
    return [
        *_scaling(printed),
        _longest(printed),
        untestable(
            Source(
                "text-packing",
                "Discussion, Fig. 12",
                "contact networks of packings damp velocity fluctuations by series compression",
            ),
            "the contact network of another publication; no packings are made here",
        ),
        _differences(printed),
        _halved(printed),
    ]


def _scaling(printed: Printed) -> list[Statement]:
    end = printed.longest_chain
    angles = [
        angle_from_impulse_ratio(energy_scaling.impulse_ratio(n)) for n in (1, 2, end, 2 * end)
    ]
    alpha = ratios()[1e6, 2.0]
    impulses = [angle_from_impulse_ratio(alpha[n]) for n in (2, end)]
    return [
        claim(
            Source(
                "text-energy-scaling",
                "Discussion, Fig. 13",
                "velocity lost as 1/sqrt(n) makes the angle fall, without an asymptote",
            ),
            holds=angles[0] > angles[1] > angles[2] > angles[3] + 0.5,
            computed="theta_c at n = 1, 2, "
            f"{end}, {2 * end}: " + ", ".join(f"{a:.2f}" for a in angles) + " deg",
            evidence=_ENERGY,
            why="still falling by half a degree from ten to twenty",
        ),
        compare(
            Source(
                "text-energy-agrees",
                "Discussion, Fig. 13",
                "the energy argument gives the behaviour that the impulses give, up to ten",
            ),
            printed=angles[2],
            found=impulses[1],
            width=Width(0.5, "deg", "the fall from n = 2 to 10 is of several degrees"),
            computed=f"theta_c at n = 2 and {end}: {angles[1]:.2f} and {angles[2]:.2f} deg by "
            f"1/sqrt(n), {impulses[0]:.2f} and {impulses[1]:.2f} deg by the impulses (1e6 N/m, "
            "2 m/s): alike in that both fall, in nothing else",
            evidence=(*_ENERGY, *_IMPULSES),
        ),
    ]


def _longest(printed: Printed) -> Statement:
    tallest = printed.heights[1]
    grain, anywhere = longest_chains(tallest)
    return claim(
        Source(
            "text-longest-chain",
            "Discussion, after eq. (18)",
            "no chain over ten particles forms, even for twenty",
        ),
        holds=max(grain, anywhere) <= printed.longest_chain,
        computed=f"{tallest + 1} particles, 3 t0: {grain} contacts in the chain of the grain, at "
        f"most {anywhere} anywhere (1e6 N/m, 2 m/s); under the overlap law "
        f"{int(run(Tower(height=tallest, law='overlap')).contacts.max())}, from the start",
        evidence=("tests/physics/test_chain_laws.py",),
    )


def _differences(printed: Printed) -> Statement:
    softest = 1 / printed.rigidities[1]  # dx/d under a force of P d^2
    found = 100 * softest * (10 - 1)
    struck = run(Tower(height=1, stiffness=1e7))
    peak = 100 * float(struck.grain_force.max()) / 1e7
    return compare(
        Source(
            "text-differences",
            "Conclusion",
            "forces over an order of magnitude change deformations by less than 0.000001 % at "
            "rigidity 1e6",
        ),
        printed=printed.difference_percent,
        found=found,
        width=Width(printed.difference_percent, "%", "the bound itself"),
        computed=f"from the confining force to ten times it a diameter changes by {found:.1e} % at "
        f"k/(P d) = 1e6; in the run at 2 m/s particles deform by {peak:.3f} %",
        correction=f"less than {found:.0e} % of the diameter",
        evidence=("tests/chain/test_propagators.py",),
    )


def _halved(printed: Printed) -> Statement:
    least = {law: min(min(a.values()) for a in ratios(law).values()) for law in LAWS}
    return compare(
        Source("text-halved", "Conclusion", "chains can nearly halve the impulse"),
        printed=printed.halved,
        found=least["deformable"],
        width=last_digit(0.1, "1"),
        computed=f"smallest alpha of the six runs {least['deformable']:.4f} (deformable), "
        f"{least['overlap']:.4f} (overlap law)",
        evidence=_IMPULSES,
    )
