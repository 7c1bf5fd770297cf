"""Sections Discussion and Conclusion: the angles of the energy argument, and how stiff is stiff."""

from __future__ import annotations

from harness.cases.tower.impulse_angles import angle_from_impulse_ratio
from harness.parameters.tower import LAWS, Tower
from harness.reproduction.as_printed import Printed
from harness.reproduction.claims import Statement, claim, compare
from harness.reproduction.ledger.results_impulse import longest_chains
from harness.reproduction.ledger.runs import ratios, run
from harness.reproduction.source import SOURCES
from harness.theory import energy_scaling


def statements(printed: Printed) -> list[Statement]:
    """Return the rows of this part."""
    return [*_scaling(printed), _longest(printed), _differences(printed), _halved(printed)]


def _scaling(printed: Printed) -> list[Statement]:
    end = printed.longest_chain
    angles = [
        angle_from_impulse_ratio(energy_scaling.impulse_ratio(n)) for n in (1, 2, end, 2 * end)
    ]
    alpha = ratios()[1e6, 2.0]
    impulses = [angle_from_impulse_ratio(alpha[n]) for n in (2, end)]
    return [
        claim(
            SOURCES["text-energy-scaling"],
            holds=angles[0] > angles[1] > angles[2] > angles[3] + 0.5,
            computed="theta_c at n = 1, 2, "
            f"{end}, {2 * end}: " + ", ".join(f"{a:.2f}" for a in angles) + " deg",
        ),
        compare(
            SOURCES["text-energy-agrees"],
            printed=angles[2],
            found=impulses[1],
            computed=f"theta_c at n = 2 and {end}: {angles[1]:.2f} and {angles[2]:.2f} deg by "
            f"1/sqrt(n), {impulses[0]:.2f} and {impulses[1]:.2f} deg by the impulses (1e6 N/m, "
            "2 m/s): alike in that both fall, in nothing else",
        ),
    ]


def _longest(printed: Printed) -> Statement:
    tallest = printed.heights[1]
    grain, anywhere = longest_chains(tallest)
    return claim(
        SOURCES["text-longest-chain"],
        holds=max(grain, anywhere) <= printed.longest_chain,
        computed=f"{tallest + 1} particles, 3 t0: {grain} contacts in the chain of the grain, at "
        f"most {anywhere} anywhere (1e6 N/m, 2 m/s); under the overlap law "
        f"{int(run(Tower(height=tallest, law='overlap')).contacts.max())}, from the start",
    )


def _differences(printed: Printed) -> Statement:
    softest = 1 / printed.rigidities[1]  # dx/d under a force of P d^2
    found = 100 * softest * (10 - 1)
    struck = run(Tower(height=1, stiffness=1e7))
    peak = 100 * float(struck.grain_force.max()) / 1e7
    return compare(
        SOURCES["text-differences"],
        printed=printed.difference_percent,
        found=found,
        tolerance=printed.difference_percent,
        computed=f"from the confining force to ten times it a diameter changes by {found:.1e} % at "
        f"k/(P d) = 1e6; in the run at 2 m/s particles deform by {peak:.3f} %",
        correction=f"less than {found:.0e} % of the diameter",
    )


def _halved(printed: Printed) -> Statement:
    least = {law: min(min(a.values()) for a in ratios(law).values()) for law in LAWS}
    return compare(
        SOURCES["text-halved"],
        printed=printed.halved,
        found=least["deformable"],
        computed=f"smallest alpha of the six runs {least['deformable']:.4f} (deformable), "
        f"{least['overlap']:.4f} (overlap law)",
    )
