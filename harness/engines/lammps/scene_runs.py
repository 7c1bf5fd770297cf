"""Scenes run by an executable of LAMMPS: many in one process, their samples read as motions.

A scene has a folder with its script ``in.lmp``, its log and its samples, as if it were run by hand.
"""

from __future__ import annotations

import os
import shlex
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from harness.engines.jobs import Batches
from harness.engines.lammps.scene_script import (
    PLAIN,
    SAMPLES,
    Variation,
    needs_new_process,
    script,
)
from harness.engines.lammps_language import error_of
from harness.engines.output import read_dump
from harness.engines.process import Limits, Processes, text_of
from harness.engines.programs import launcher_of
from harness.engines.scene_tables import motion_of_table
from harness.errors import EngineError
from harness.model.motion import Motion
from harness.model.scene import Scene

Row = tuple[Scene, str]  # a scene and its script
SCRIPT, LOG, DONE = "in.lmp", "log.lammps", "done"
# ranks of MPICH that wait sleep after so many looks: where there are more ranks than cores, four
# ranks of a contact on two cores take a fifth of the time; other libraries ignore it
SLEEPING = {
    "MPIR_CVAR_CH4_PROGRESS_THROTTLE": "1",
    "MPIR_CVAR_CH4_PROGRESS_THROTTLE_NO_PROGRESS_COUNT": "100",
}


def motions(
    executable: str | Sequence[str],
    scenes: Sequence[Scene],
    variation: Variation | Sequence[Variation] = PLAIN,
    *,
    launcher: Sequence[str] = (),
    release: str | None = None,
    workers: int | None = None,
    limits: Limits | None = None,
    processes: Processes | None = None,
) -> list[Motion | EngineError]:
    """Return the motion of each scene, or the error of its run.

    ``variation`` is that of all scenes or of each; ``executable`` may have words after it, and
    ``launcher`` starts it on MPI ranks of its own. ``release`` is the date of the executable, as
    in 29 Aug 2024. ``workers`` processes run side by side, as many as there are cores unless
    given; a scene has ``limits.seconds``. Torques on frozen bodies are NaN. Raise Unsupported for
    a scene that LAMMPS cannot run.
    """
    program = [executable] if isinstance(executable, str) else [*executable]
    each = [variation] * len(scenes) if isinstance(variation, Variation) else variation
    rows = [(scene, script(scene, row)) for scene, row in zip(scenes, each, strict=True)]
    outcomes: dict[int, Motion | EngineError] = {}
    for ranks in sorted({row.ranks for row in each}):
        places = [k for k, row in enumerate(each) if row.ranks == ranks]
        start = launcher if ranks == 1 else shlex.split(launcher_of(ranks, program[0]))
        batches = _batches([*start, *program], sleeping=bool(start))
        alone = [k for k in places if needs_new_process(scenes[k], each[k], release)]
        for some in ([k for k in places if k not in alone], *([k] for k in alone)):
            hands = 1 if start else workers
            ends = batches.run([rows[k] for k in some], hands, limits, processes)
            outcomes.update(zip(some, ends, strict=True))
    return [outcomes[k] for k in range(len(scenes))]


def _batches(command: Sequence[str], *, sleeping: bool) -> Batches[Row, Motion]:
    """Return LAMMPS, which runs each scene in a folder of its own."""
    environment = {**SLEEPING, **os.environ} if sleeping else None

    def write(folder: Path, rows: Sequence[Row]) -> Sequence[str]:
        lines: list[str] = []
        for k, (_, text) in enumerate(rows):
            (folder / str(k)).mkdir()
            (folder / str(k) / SCRIPT).write_text(text, encoding="utf-8")
            lines += [f"shell cd {k}", f"log {LOG}", "clear", f"include {SCRIPT}",
                      f"print done file {DONE}", "shell cd .."]  # fmt: skip
        (folder / "batch.in").write_text("\n".join([*lines, ""]), encoding="utf-8")
        return [*command, "-in", "batch.in", "-log", "none", "-screen", "none"]

    def read(folder: Path, place: int, row: Row, _: float) -> Motion | None:
        done = (folder / str(place) / DONE).exists()
        return read_samples(folder / str(place) / SAMPLES, row[0]) if done else None

    return Batches(
        title="LAMMPS",
        write=write,
        read=read,
        error=error_of,
        log=lambda folder, place: text_of(folder / str(place) / LOG),
        environment=lambda folder: environment,  # noqa: ARG005
    )


def read_samples(path: Path, scene: Scene) -> Motion:
    """Return the motion of a dump.

    Raise EngineOutputError for samples that are missing or of another shape, EngineNaNError for
    one that is not finite.
    """
    motion = motion_of_table("LAMMPS", scene, read_dump(text_of(path), "LAMMPS"))
    for place, body in enumerate(scene.bodies):
        if body.motion == "frozen" and not scene.segments:
            motion.torque[:, place] = np.nan  # LAMMPS sets it to zero
    return motion
