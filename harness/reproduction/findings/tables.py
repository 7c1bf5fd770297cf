"""What the reproduction found beside right and wrong, as the tables behind the findings."""

from __future__ import annotations

from dataclasses import dataclass

import pandas as pd


@dataclass(frozen=True)
class Findings:
    """Tables behind the page of findings; angles in deg.

    ``restitution`` (a row for each e): the angle of both readings of the shock,
    and what the reference DEM and the engine measure; ``heights`` (height, law,
    window): impulse ratio and angle of both readings; ``mfix`` (stiffness, step
    factor, scheme): critical angle of our integrator in MFiX's scheme, with the
    recorded one where there is one; ``limits`` (stiffness): the angle of the same
    contact without a step.
    """

    restitution: pd.DataFrame
    heights: pd.DataFrame
    mfix: pd.DataFrame
    limits: pd.DataFrame
    closed_form_deg: float

    def at_height(self, height: int, law: str, window: str = "turnaround") -> pd.Series:
        """Return the row of a tower; raise KeyError if it was not run."""
        frame = self.heights
        chosen = frame[
            (frame["height"] == height) & (frame["law"] == law) & (frame["window"] == window)
        ]
        if len(chosen) != 1:
            raise KeyError(f"height {height}, {law} law, {window} window")
        return chosen.iloc[0]

    def explained_by_overlap(self, height: int) -> float:
        """Return which part of the fall of the angle the overlap law gives without deformation."""
        name = "critical_angle_lost_deg"
        fall = {
            law: self.closed_form_deg - float(self.at_height(height, law)[name])
            for law in ("overlap", "deformable")
        }
        return fall["overlap"] / fall["deformable"]
