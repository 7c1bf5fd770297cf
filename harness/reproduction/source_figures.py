"""The figures of the source: their numbers, and what each of them says."""

from __future__ import annotations

from dataclasses import dataclass

from harness.reproduction.claims import Source


@dataclass(frozen=True)
class SourceFigure:
    """A figure of the source: its number, a short name, a title, and what it says."""

    number: int
    name: str
    title: str
    says: str

    @property
    def picture(self) -> str:
        """Return the name of the picture that answers it: ``fig-04-velocity-series``."""
        return f"fig-{self.number:02d}-{self.name}"

    @property
    def source(self) -> Source:
        """Return its place in the source, for the ledger."""
        return Source(f"fig-{self.number}", f"figure {self.number}", self.says)

    @property
    def evidence(self) -> tuple[str, ...]:
        """Return the link to the picture, relative to the report's folder."""
        return (f"figures/{self.picture}.svg",)


_LISTED = (
    ("thin-layers", "Thin-layer stability", "the critical angle falls with height (Perrin et al.)"),
    ("quartier", "The Quartier system", "a grain slides from crest A into well B and to crest C"),
    (
        "force-diagrams",
        "Forces before and after the shock",
        "the shock turns the velocity from one contact to the next, and the contact force is "
        "never larger than the normal component of gravity",
    ),
    (
        "velocity-series",
        "Velocity near the critical angle",
        "the smallest angle of steady motion in MFiX is the closed form's to 0.01 deg",
    ),
    (
        "modified-quartier",
        "The modified Quartier system",
        "the substrate may be n layers of grains high, and the shock runs down them",
    ),
    (
        "two-and-three-particles",
        "Velocity and deformation of two and three particles",
        "two particles exchange their momentum; with three, the grain rebounds and the total "
        "deformation, and so the energy stored, is larger",
    ),
    (
        "error-against-stiffness",
        "Error of the peak deformation against stiffness",
        "the error decreases with the stiffness and is below 0.5 % by k = 1e4 N/m",
    ),
    (
        "force-and-contacts",
        "Force and contacts of 2, 3, 10 and 20 particles",
        "three particles: the third joins at 0.5 t0, the grain is alone, comes back at 1 and "
        "leaves at 1.5; 10 and 20 particles are alike",
    ),
    ("collapse", "Collapse across rigidity", "t/t0 collapses runs an order of rigidity apart"),
    (
        "impulse-ratio",
        "Impulse ratio against height",
        "alpha(n) of six runs falls and levels off at about ten contacts, nearly halved",
    ),
    (
        "critical-angle-against-height",
        "Critical angle against height",
        "theta_c(n) falls with height and levels off, as measured by Perrin et al.",
    ),
    (
        "contact-network",
        "Contact network of disks",
        "the contact network of a two-dimensional packing (Papadopoulos et al. 2018)",
    ),
    (
        "energy-scaling",
        "Energy scaling",
        "alpha = 1/sqrt(n) makes theta_c fall up to about ten particles, without an asymptote",
    ),
    (
        "contact-separation",
        "Separation of the contacts with neighbour and chain",
        "a separation develops with the length of the chain: none for 2 particles, overlap for 3 "
        "and 4, and for 20 the contacts up to 1.5 t0 are the neighbour's",
    ),
    (
        "structure-window",
        "Critical angle of the structure window",
        "the first swing of the chain from its total length to one after t0 gives the critical "
        "angles of two to seven particles",
    ),
    (
        "window-selection",
        "Selection of the window",
        "the chain is compressed most at one time within 3 t0, half the window",
    ),
)

FIGURES = {
    f"fig-{number}": SourceFigure(number, *listed) for number, listed in enumerate(_LISTED, 1)
}
"""By key, in the order of the source."""
