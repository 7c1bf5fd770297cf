"""Elastic impacts with Mindlin's springs, which stick or slip as a whole, and with partial slip.

Maw, Barber and Fawcett, Wear 38, 101 (1976): the contact of a real sphere sticks inside and slips
outside. The normalised incidence is psi = 2 (1 - nu) / (mu (2 - nu)) times the tangential over the
normal velocity at the contact.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from harness.cases.base import Check, Level, Value
from harness.cases.bench import OWN, Bench
from harness.cases.contacts import tables
from harness.cases.contacts.contact_case import ContactCase
from harness.cases.equal_steps import REASON, ROUND_OFF
from harness.engines.base import Engine, Job, scene_job
from harness.errors import EngineError
from harness.model.motion import Floats
from harness.report.content import Drawing
from harness.results.rows import Kind, Tolerance
from harness.theory.contact import partial_slip_rebound, stiffness_ratio

if TYPE_CHECKING:
    from harness.report.style import Figure

LAWS = ("mindlin", "mindlin/force", "mindlin_rescale", "mindlin_rescale/force")
INCIDENCES = np.array([0.25, 0.5, 1.0, 1.5, 2.0, 2.5, 3.0, 3.5, 4.0, 4.5, 5.0, 6.0])
FRICTION, POISSON = 0.3, 0.3
STEPS = 400  # of a contact


class PartialSlipCase(ContactCase[Any]):
    """Impacts at an angle, some of which are drawn with the curve of partial slip."""

    def checks_up_to(self, engine: Engine, level: Level) -> Iterator[Check]:
        """Yield the checks of trials, and the impacts of the first of the laws that is stated."""
        yield from super().checks_up_to(engine, level)
        for law in LAWS if level != "quick" else ():
            jobs = self._jobs(law)
            if not any(engine.refuses(job) for job in jobs):
                yield Check(
                    setup=f"{law}, wall, partial slip",
                    quantity="rebound_difference",
                    unit="1",
                    measure=partial(self._difference, law),
                    expected=0.0,
                    tolerance=Tolerance(absolute=ROUND_OFF * float(INCIDENCES[-1]), reason=REASON),
                    level="default",
                    jobs=jobs,
                    note="largest difference from the reference of 12 impacts, drawn in the report",
                )
                return

    def own_checks(self) -> Iterator[Check]:
        """Yield a finding for each law: its rebound where it is farthest from partial slip."""
        for law in LAWS:
            yield Check(
                setup=f"{law}, wall, partial slip",
                quantity="normalised_rebound",
                unit="1",
                measure=partial(self._farthest, law),
                expected=partial(self._expected_rebound, law),
                kind=Kind.FINDING,
                level="default",
            )

    def rebounds(self, law: str, bench: Bench, *, measured: bool) -> Floats:
        """Return the rebounds (M,) of a law at :data:`INCIDENCES`, by engine or reference."""
        rebounds = []
        for psi, p in zip(INCIDENCES, self._impacts(law), strict=True):
            scene = self.scene(p)
            ratios = p.observe(
                bench.motion(scene_job(scene)) if measured else bench.reference(scene)
            )
            slip = ratios["tangential_ratio"] - ratios["rim_speed_ratio"]
            rebounds.append(psi * slip / ratios["normal_restitution"])
        return np.array(rebounds)

    def drawings(self, benches: Mapping[str, Bench]) -> Sequence[Drawing]:
        """Return Maw's curve with the laws by the reference and all codes that have run them."""
        marks: dict[str, Floats] = {}
        for name, bench in benches.items():
            for law in LAWS if name != OWN else ():
                if bench.has_run(self._jobs(law)):
                    try:
                        values = self.rebounds(law, bench, measured=True)
                    except EngineError:
                        continue
                    marks[f"{bench.engine.title}, {law}"] = values
        if not marks:
            return ()
        solver = benches.get(OWN) or Bench(None)
        lines = {law: solver.once(self.rebounds, law, solver, measured=False) for law in LAWS}
        text = (
            "Velocity at the contact after over that before, both over mu times the normal one and "
            "times 2 (1 - nu) / (2 - nu), elastic sphere on a wall of its material, nu = 0.3. "
            "Lines: the laws by the reference under LAMMPS's conventions; marks: codes under their "
            f"own, each within {ROUND_OFF:g} of the reference under these. {STEPS} steps a contact."
        )
        title = "Laws that stick as a whole, and partial slip"
        return (Drawing("oblique-partial-slip", title, text, lambda: figure(lines, marks)),)

    def _impacts(self, law: str) -> list[Any]:
        """Return the impacts of an elastic sphere on a wall, at 1 m/s along the normal."""
        base = self.default.replace(
            **tables.part("hertz"), damping="none", tangential=law, tangential_damping=0.0,
            friction=FRICTION, steps_per_contact=STEPS,
        )  # fmt: skip
        angles = np.arctan(INCIDENCES * FRICTION / stiffness_ratio(POISSON))
        return [base.replace(angle=math.degrees(a), speed=1.0 / math.cos(a)) for a in angles]

    def _jobs(self, law: str) -> list[Job]:
        return [self.job(p) for p in self._impacts(law)]

    def _difference(self, law: str, bench: Bench) -> float:
        measured, expected = (self.rebounds(law, bench, measured=each) for each in (True, False))
        return float(np.abs(measured - expected).max())

    def _farthest_rebound(self, law: str, bench: Bench) -> tuple[float, float, float]:
        """Return incidence, rebound, and that of partial slip where they differ most."""
        rebounds = bench.once(self.rebounds, law, bench, measured=False)
        curve = partial_slip_rebound(INCIDENCES, POISSON)
        at = int(np.abs(rebounds - curve).argmax())
        return float(INCIDENCES[at]), float(rebounds[at]), float(curve[at])

    def _farthest(self, law: str, bench: Bench) -> Value:
        psi, rebound, _ = self._farthest_rebound(law, bench)
        return Value(rebound, note=f"farthest from partial slip at psi = {psi:g} of 0.25 to 6")

    def _expected_rebound(self, law: str, bench: Bench) -> float:
        return self._farthest_rebound(law, bench)[2]


def figure(laws: Mapping[str, Floats], codes: Mapping[str, Floats]) -> Figure:
    """Draw Maw's curve, the rebounds of laws as lines and of codes as marks, each (M,)."""
    from harness.report.style import BLACK, COLOURS, MARKERS, STYLES, legend_below, panels

    drawn = panels(1, 1, width=8.0, height=4.4)
    axes = drawn.axes[0]
    psi = np.linspace(0.0, INCIDENCES[-1], 121)
    name = "partial slip: Maw, Barber and Fawcett 1976"
    axes.plot(psi, partial_slip_rebound(psi, POISSON), color=BLACK, lw=2.0, label=name)
    for number, (law, rebounds) in enumerate(laws.items(), 1):
        axes.plot(INCIDENCES, rebounds, color=COLOURS[number], ls=STYLES[number], label=law)
    for number, (code, rebounds) in enumerate(codes.items()):
        marker, size = MARKERS[number % len(MARKERS)], 4.0 + 1.5 * number
        axes.plot(INCIDENCES, rebounds, marker, color="0.25", mfc="none", ms=size, label=code)
    axes.set(xlabel="normalised incidence", ylabel="normalised rebound")
    legend_below(drawn)
    return drawn
