"""The report as Markdown, and the words that it shares with the HTML page."""

from __future__ import annotations

from collections.abc import Sequence

from harness.comparison.verdicts import Check
from harness.comparison.verification import Verification
from harness.report import engines
from harness.report.gallery import Picture
from harness.report.templating import number
from harness.report.verdict_summary import KINDS, headline, standings


def markdown(found: Verification, shown: Sequence[Picture]) -> str:
    """Return the report as Markdown, with links to the figures beside it."""
    lines = ["# DEM verification report", "", *summary(found), ""]
    for kind, title in KINDS.items():
        rows = [check for check in found.checks if check.kind is kind]
        if rows:
            lines += [f"## {title}", "", *_table(rows), ""]
    lines += ["## The contacts", "", *(f"- {text}" for text in contacts_explained()), ""]
    steps, angles = angle_rows(found)
    if angles:
        head = ["contact", "k (N/m)", *(f"{n:g} steps" for n in steps)]
        lines += [f"| {' | '.join(head)} |", f"|---|{'--:|' * (len(head) - 1)}"]
        lines += [f"| {c} | {k:.3g} | {' | '.join(cells)} |" for c, k, cells in angles] + [""]
    laws = laws_apart(found)
    if laws:
        lines += [f"## {LAWS_TITLE}", "", LAWS_APART, ""]
        lines += [f"| {' | '.join(LAWS_HEAD)} |", f"|--:|---|{'--:|' * 5}"]
        lines += [f"| {' | '.join(row)} |" for row in laws] + [""]
    if found.engines is not None:
        lines += [f"## {engines.TITLE}", "", engines.EXPLAINED, ""]
        for table in engines.tables(found.engines):
            lines += table.markdown()
        for engine, traps in engines.caveats(found.engines):
            lines += [f"- {engine}: {' '.join(traps)}"]
        lines += [""]
    lines += ["## Figures", ""]
    for picture in shown:
        lines += [f"### {picture.title}", "", f"![{picture.title}](figures/{picture.name}.svg)", ""]
        lines += [picture.caption, ""]
    lines += ["## Provenance", "", *(f"- {a}: {b}" for a, b in provenance(found)), ""]
    return "\n".join(lines)


def summary(found: Verification) -> list[str]:
    """Return the sentences that open the report: the outcome kind by kind, and the angle."""
    counts = "; ".join(f"{s.kind} {s.text}" for s in standings(found.checks))
    lines = [f"**{headline(found)}.**", f"{counts}."]
    angle = found.incline.extrapolated
    if angle is not None:
        lines.append(
            f"Critical angle of the frictionless incline: theory "
            f"{found.incline.closed_form_deg:.5f} deg; LAMMPS {angle.value_deg:.5f} +- "
            f"{angle.uncertainty_deg:.5f} deg (plastic contact, step to zero, then stiffness "
            "to infinity)."
        )
    return lines


def contacts_explained() -> list[str]:
    """Return one sentence on the bias of each contact."""
    return [
        "source (e = 1e-20, tail kept): the attractive tail holds back the contact that is left, "
        "so the angle rises above the closed form by about k^(-1/2) as the step goes to zero; at "
        "50 steps the tail is mostly skipped and the two errors nearly cancel.",
        "clipped (critical damping, no tail): smooth in the step, but its restitution is exp(-2) "
        "= 0.135, not 0: the grain hops after each shock and the angle tends to about 10.224 deg.",
        "plastic (damping ratio 5, no tail): no tail and hardly a rebound (0.009); first order in "
        "the step, nearly first order in 1/k. This is the e = 0 of the theory.",
    ]


def angle_rows(
    found: Verification,
) -> tuple[list[float], list[tuple[str, float, list[str]]]]:
    """Return the steps per contact, and for each contact and stiffness the angles at them."""
    every = [a for angles in found.incline.by_contact.values() for a in angles]
    steps = sorted({a.case.steps_per_contact for a in every})
    cells = {
        (a.case.contact.name, a.case.stiffness, a.case.steps_per_contact): (
            f"{a.value_deg:.4f} ± {a.uncertainty_deg:.1g}"
        )
        for a in every
    }
    keys = sorted({key[:2] for key in cells})
    return steps, [(c, k, [cells.get((c, k, n), "") for n in steps]) for c, k in keys]


LAWS_TITLE = "Where the laws differ, and what it does to the angle"

LAWS_APART = (
    "Under the overlap law, which DEM codes use, every contact presses with its own overlap. Under "
    "the deformable law of the source a particle pressed on both sides gives way on both, so that "
    "a contact behind a compressed one opens or closes at another time. One contact is the same "
    "under both; from two on they differ. Through the impulse ratio alpha the difference reaches "
    "the critical angle, and there the reading of the source's formula weighs more than the law: "
    "velocity lost makes the angle fall with height, velocity kept makes it rise."
)

LAWS_HEAD = (
    "height",
    "law",
    "alpha",
    "angle, velocity lost (deg)",
    "angle, velocity kept (deg)",
    "force apart, peak",
    "force apart, L2",
)


def laws_apart(found: Verification) -> list[list[str]]:
    """Return, for some heights at k = 1e6 N/m and 2 m/s, alpha and angles under both laws.

    The last two columns are the differences of the force series, over the peak.
    """
    frame = found.tower.impulses
    if frame is None:
        return []
    forces = {c.run.tower.height: c.force for c in found.tower.different_law}
    one_run = frame[(frame["stiffness_N_per_m"] == 1e6) & (frame["speed_m_per_s"] == 2.0)]
    rows = []
    for row in (
        one_run[one_run["height"].isin((1, 2, 3, 4, 9, 19))]
        .sort_values(["height", "law"])
        .to_dict(orient="records")
    ):
        force = forces.get(row["height"]) if row["law"] == "deformable" else None
        rows.append(
            [
                str(row["height"]),
                str(row["law"]),
                f"{row['impulse_ratio']:.4f}",
                f"{row['critical_angle_lost_deg']:.3f}",
                f"{row['critical_angle_kept_deg']:.3f}",
                f"{force.peak:.3f}" if force else "",
                f"{force.l2:.3f}" if force else "",
            ]
        )
    return rows


def provenance(found: Verification) -> list[tuple[str, str]]:
    """Return what made this report, as pairs of name and text."""
    engine = found.provenance
    pairs = [
        ("started", found.started),
        ("took", f"{found.seconds:.1f} s"),
        ("level", found.level),
        ("dem-harness", found.harness_version),
        ("platform", found.platform),
    ]
    if engine is not None:
        pairs += [
            ("engine", f"{engine.engine} {engine.engine_version}, {engine.how}"),
            ("executable", engine.executable),
            ("packages", " ".join(engine.packages)),
        ]
    return pairs


def _table(rows: Sequence[Check]) -> list[str]:
    head = [
        "check",
        "value",
        "expected",
        "difference",
        "uncertainty",
        "tolerance",
        "unit",
        "verdict",
    ]
    lines = [f"| {' | '.join(head)} |", f"|{'|'.join(['---', *['--:'] * 5, '---', '---'])}|"]
    for check in rows:
        numbers = [number(check.value), number(check.expected), number(check.difference, 2)]
        numbers += [number(check.uncertainty, 2), number(check.tolerance, 2)]
        remarks = ": ".join(text for text in (check.triage, check.note) if text)
        remark = f" ({remarks})" if remarks else ""
        cells = [check.name + remark, *numbers, check.unit, str(check.verdict)]
        lines.append("| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |")
    return lines
