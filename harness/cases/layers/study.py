"""Does the angle at which layers stop fall with their thickness, and is it softness? The runs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from harness.cases.contract import LevelName
from harness.cases.layers.changes import TEST
from harness.cases.layers.conclusion import read_arms, rows_of, verdict_of
from harness.cases.layers.extents import arms_of, cost_seen, study_cost
from harness.cases.study import Arm, CaseStudy, Conclusion, EngineOf, Row, StudyCost
from harness.observables.reference import ReferencePoints


class LayersStudy(CaseStudy):
    """Angle of stop against thickness and stiffness, and what else could move it."""

    title = "Layers: the angle at which they stop, against thickness and stiffness"
    question = (
        "The paper explains the lower angle of thick layers by deformation: the angle falls from "
        "10.21 to about 5 deg. Does a DEM of frictionless layers show the fall, and does it take "
        "soft grains?"
    )
    columns = ("arm", "layers", "stiffness_over_weight", "restitution", "stop_angle_deg",
               "uncertainty_deg", "grains", "seeds")  # fmt: skip

    def arms(self, level: LevelName) -> Sequence[Arm]:
        """Return thickness and stiffness over seeds, one change at a time, the single grain."""
        return arms_of(level)

    def cost(self, level: LevelName, engine_of: EngineOf, runs: Sequence[Row] = ()) -> StudyCost:
        """Return what a level costs: by runs that were made, else as measured here."""
        arms = self.arms(level)
        return cost_seen(arms, {"runs": runs}) or study_cost(arms, engine_of)

    def conclude(
        self, arms: Mapping[str, Sequence[Row]], points: ReferencePoints | None
    ) -> Conclusion:
        """Return angles with intervals, the verdict on softness, figures and tables."""
        from harness.cases.layers.report import sections_of

        results = read_arms(arms)
        return Conclusion(rows_of(results), verdict_of(results), TEST, sections_of(results, points))
