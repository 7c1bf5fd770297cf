"""What a report says of a flow of layers: its profile."""

from __future__ import annotations

from typing import TYPE_CHECKING

from harness.report.sections import Drawing, Film, Section

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from harness.cases.layers.reading import Profile

TITLE = "Frictionless layers"

EXPLAINED = (
    "Frictionless spheres in layers on a rough base, periodic along and across, lowered until they "
    "rest. A single grain on the ordered row is the incline: it must stop at the incline's "
    "critical angle."
)


def flow_section(who: str, profile: Profile, film: Film | None = None) -> Section:
    """Return the section with the profile of a flow in an engine, and the film of one."""
    drawing = Drawing(
        "layers-profile",
        "Profile of a small flow of layers",
        "Mean speed of the grains and solid fraction, in slices of a quarter of a diameter, four "
        "layers at 16 deg. Each grain counts whole in the slice of its centre, so that the "
        "fraction rises and falls with the layers and may exceed that of a packing.",
        lambda: profile_drawn(who, profile),
    )
    films = () if film is None else (film,)
    return Section(TITLE, (EXPLAINED,), drawings=(drawing,), films=films)


def profile_drawn(who: str, profile: Profile) -> Figure:
    """Draw speed and solid fraction of the slices over their height."""
    from matplotlib.figure import Figure

    from harness.report.figures.style import COLOURS

    figure = Figure(figsize=(7.0, 3.6), layout="constrained")
    left, right = figure.subplots(1, 2, sharey=True)
    left.plot(profile.speed, profile.height, "o-", color=COLOURS[0])
    left.set(xlabel="mean speed (sqrt(g d))", ylabel="height above the base (d)")
    right.plot(profile.solid_fraction, profile.height, "s-", color=COLOURS[1])
    right.set(xlabel="solid fraction, grains by their centres")
    figure.suptitle(f"Four layers at 16 deg, {who}")
    return figure
