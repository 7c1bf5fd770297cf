"""Scenes in the plane, for engines that take particles and not scripts.

A scene (:class:`harness.parameters.scene.ContactScene`) says the same as a case's scripts do with
the same values; the table ``series`` that an engine returns of it has the columns ``step``,
``time_s`` of shape (M,) and ``x_m``, ``y_m``, ``vx_m_per_s``, ``vy_m_per_s`` of shape (M, N), the
particles in the scene's order, or (M,) for the first alone. Where ``forces`` is set it has ``fx_N``
(M, N), the total force along x with gravity, or ``contact_force_N`` (M, N - 1) of particles in a
line, or ``contacts_fx_N`` (M, N) of the contacts alone. An engine that looks at the particle while
it runs may leave a table ``stages`` with the same columns: the start and the end of each stage.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:  # what knows a code's fingerprint loads no numerics
    import numpy as np
    from numpy.typing import NDArray

    from harness.parameters.scene import ContactScene

    Floats = NDArray[np.float64]
    SceneBuilder = Callable[[Mapping[str, str | int | float]], ContactScene]
    """Makes the scene of a job from its values."""


@dataclass(frozen=True)
class Stage:
    """Where a stretch of the motion of the first particle ends.

    At the first look, one each :data:`LOOK` steps, at which x is beyond ``place`` [m], and the
    next stage begins; or at which it moves back along x with less mechanical energy than ``floor``
    [J], and the run is over. The energy is zero for a particle at rest at (0, 0), free of contact;
    over columns it is that of the motion and the height, without springs.
    """

    place: float
    floor: float


STAGES = "stages"
"""Name of the table of the start and the ends of stages."""

LOOK = 50
"""Steps between two looks at the first particle."""


@dataclass(frozen=True)
class Columns:
    """The fixed particles are the last ones of columns along y, each of ``height`` particles.

    In the scene they follow the first particle, column after column from the top down. Between
    them it has contacts within a column and of the first particle with tops. Those of a column
    move along y alone. ``law`` is ``overlap`` or ``deformable`` (the source's, of each column with
    the first particle at its end); without ``damped`` contacts within columns have no dashpot.
    """

    height: int
    law: str
    damped: bool
