"""The generated inputs of the engines: write them, or check that those written are up to date."""

from __future__ import annotations

import difflib
from pathlib import Path

from harness.atomic_write import held_folder
from harness.cases.registry import built_in, get_case
from harness.engines.registry import input_files
from harness.errors import RequestError, cannot_write


def generated_inputs() -> dict[str, str]:
    """Return the inputs of the cases and engines of this package, by their names."""
    return input_files([get_case(name).template for name in built_in()])


def inputs(folder: Path) -> list[Path]:
    """Write every input into a folder, made if need be; return the files.

    Each is written aside and renamed. Raise RequestError when the folder
    cannot be written, FullDiskError where there is no space.
    """
    written = []
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with held_folder(folder) as aside:
            for name, text in generated_inputs().items():
                (aside / "input").write_text(text, encoding="utf-8")
                (folder / name).parent.mkdir(parents=True, exist_ok=True)
                written.append((aside / "input").replace(folder / name))
    except OSError as error:
        raise cannot_write(f"folder {folder} cannot be written", error) from None
    return written


def outdated_inputs(folder: Path) -> dict[str, str]:
    """Return, for each input that is missing or differs in a folder, what differs.

    Raise RequestError when there is no such folder.
    """
    if not folder.is_dir():
        raise RequestError(f"folder {folder}: no such folder; give the one that holds the inputs")
    differences: dict[str, str] = {}
    for name, generated in generated_inputs().items():
        path = folder / name
        if not path.is_file():
            differences[name] = "is missing"
            continue
        text = path.read_text(encoding="utf-8", errors="replace")
        if text != generated:
            lines = difflib.unified_diff(
                text.splitlines(),
                generated.splitlines(),
                "committed",
                "generated",
                lineterm="",
                n=0,
            )
            differences[name] = "\n".join(lines) or "differs in its line ends"
    return differences
