"""Whether the round-off of a run is known: that of mdr's force is, of one impact."""

from __future__ import annotations

from harness.parameters.contact_scene import ContactScene

WIDEST = 1e-6
"""Of the sizes: a limit's width; what moves a run by more hides what an invariance is to show."""


def has_width(scene: ContactScene) -> bool:
    """Return whether round-off of mdr's force is known: of one contact that does not stick."""
    one = len(scene.bodies) + len(scene.planes) == 2
    return one and not scene.segments and not scene.law.surface_energy


def why_not(scene: ContactScene, width: float) -> str:
    """Return why an invariance that rounds is not judged, or nothing.

    ``width`` is what its force's round-off may move, of the sizes.
    """
    if scene.law.normal != "mdr":
        return ""
    if not has_width(scene):
        return (
            "its force loses digits as an overlap shrinks: what that leaves is known of a single "
            "contact, without adhesion"
        )
    if not width <= WIDEST:
        return (
            f"its force loses digits as an overlap shrinks: that may move it by {width:.2g}, more "
            f"than {WIDEST:g}"
        )
    return ""
