"""Scenes run by an executable of LAMMPS: many in one process, their samples read as motions.

A scene has a folder with its script ``in.lmp``, its log and its samples, as if it were run by hand.
An error, a crash, a hang or a lost atom ends a process: that scene has failed, those after it are
run again.
"""

from __future__ import annotations

import os
import shlex
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from harness.engines.jobs import Batches
from harness.engines.lammps.language import error_of
from harness.engines.lammps.scene_script import (
    PLAIN,
    SAMPLES,
    Variation,
    needs_new_process,
    script,
)
from harness.engines.lammps.workers import SLEEPING
from harness.engines.process import Limits, Processes, text_of
from harness.engines.programs import launcher_of
from harness.engines.scene_files import Outcome
from harness.errors import EngineNaNError, EngineOutputError
from harness.model.motion import Floats, Motion
from harness.model.scene import Scene

Row = tuple[Scene, str]  # a scene and its script
SCRIPT, LOG, DONE = "in.lmp", "log.lammps", "done"
VECTORS = 5  # position, velocity, angular velocity, force and torque


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
) -> list[Outcome]:
    """Return the motion of each scene, or the error of its run.

    ``variation`` is that of all scenes or of each; ``executable`` may have words after it, and
    ``launcher`` starts it on MPI ranks of its own. ``release`` is the date of the executable, as
    in 29 Aug 2024. ``workers`` processes run side by side, as many as there are cores unless
    given; a scene has ``limits.seconds``. Torques on frozen bodies are NaN. Raise Unsupported for
    a scene that LAMMPS cannot state.
    """
    program = [executable] if isinstance(executable, str) else [*executable]
    each = [variation] * len(scenes) if isinstance(variation, Variation) else variation
    rows = [(scene, script(scene, row)) for scene, row in zip(scenes, each, strict=True)]
    outcomes: dict[int, Outcome] = {}
    for ranks in sorted({row.ranks for row in each}):
        places = [k for k, row in enumerate(each) if row.ranks == ranks]
        start = launcher if ranks == 1 else shlex.split(launcher_of(ranks, program[0]))
        batches = _batches([*start, *program], crowded=bool(start))
        alone = [k for k in places if needs_new_process(scenes[k], each[k], release)]
        for some in ([k for k in places if k not in alone], *([k] for k in alone)):
            hands = 1 if start else workers
            found = batches.run([rows[k] for k in some], hands, limits, processes)
            outcomes.update(zip(some, found, strict=True))
    return [outcomes[k] for k in range(len(scenes))]


def _batches(command: Sequence[str], *, crowded: bool) -> Batches[Row, Motion]:
    """Return LAMMPS, which runs each scene in a folder of its own.

    Where more ranks than cores may wait (``crowded``), waiting ranks sleep.
    """

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
        own = folder / str(place)
        return read_samples(own / SAMPLES, row[0]) if (own / DONE).exists() else None

    environment = {**SLEEPING, **os.environ} if crowded else None
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
    text = path.read_text(encoding="utf-8", errors="replace") if path.exists() else ""
    bodies, found = len(scene.bodies), {}
    for block in text.split("ITEM: TIMESTEP\n")[1:]:
        step, *lines = block.splitlines() or [""]
        rows = [line.split() for line in lines[7:]]
        if step.isdigit() and [row[:1] for row in rows] == [[str(n + 1)] for n in range(bodies)]:
            found[int(step)] = rows
    steps = range(0, scene.steps + 1, scene.every)
    missing = [step for step in steps if step not in found]
    if missing:
        names = ", ".join(map(str, missing[:3])) + (", ..." if len(missing) > 3 else "")
        raise EngineOutputError(
            f"LAMMPS wrote {len(found)} of {len(steps)} samples, none of all bodies at step {names}"
        )
    return _motion(_table([found[step] for step in steps]), scene)


def _table(rows: list[list[list[str]]]) -> Floats:
    try:
        return np.array([[line[1:] for line in sample] for sample in rows], dtype=float)
    except ValueError as error:
        raise EngineOutputError(f"LAMMPS wrote a sample that cannot be read: {error}") from None


def _motion(table: Floats, scene: Scene) -> Motion:
    warms = any(law.heat != "none" for law in scene.all_laws)
    columns = 3 * VECTORS + warms
    if table.shape[2] != columns:
        raise EngineOutputError(f"LAMMPS wrote {table.shape[2]} columns, not {columns}")
    if not np.isfinite(table).all():
        step = scene.every * int(np.argwhere(~np.isfinite(table))[0, 0])
        raise EngineNaNError(f"LAMMPS wrote a value that is not finite (NaN) at step {step}")
    parts = [np.ascontiguousarray(table[:, :, 3 * k : 3 * k + 3]) for k in range(VECTORS)]
    position, velocity, spin, force, torque = parts
    for place, body in enumerate(scene.bodies):
        if body.motion == "frozen" and not scene.segments:
            torque[:, place] = np.nan  # LAMMPS sets it to zero
    time = scene.step * scene.every * np.arange(len(table), dtype=np.float64)
    temperature = table[:, :, -1] if warms else None
    return Motion(time, position, velocity, spin, force, torque, temperature)
