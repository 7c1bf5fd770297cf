"""Read the VTP files that MFiX writes of a region: an XML head, then raw big-endian blocks.

As ``WRITE_VTP_FILE`` of MFiX 21.3.2 writes them (``vtp_mod.f``): all values in single
precision, each block after the number of its bytes, offsets counted from the underscore.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from harness.errors import EngineOutputError

Floats = NDArray[np.float64]

TIME = re.compile(rb"<!-- Time =\s*([-+.\dEeDd]+)\s+sec")
POINTS = re.compile(rb'NumberOfPoints="\s*(\d+)')
ARRAY = re.compile(rb'<DataArray type="Float32" Name="([^"]+)"([^>]*)offset="\s*(\d+)\s*"')
RAW = re.compile(rb'<AppendedData encoding="raw">\s*_')
END = b"</VTKFile>"


@dataclass(frozen=True)
class Frame:
    """What one file holds: the time [s] and its arrays by name, (points, components) each."""

    time: float
    arrays: dict[str, Floats]


def read_frames(folder: Path, name: str) -> list[Frame]:
    """Return the frames ``NAME_0000.vtp`` ... of a folder by their times, then their numbers.

    Raise EngineOutputError for a file that is cut or not of this kind.
    """
    paths = sorted(folder.glob(f"{name}_*.vtp"), key=lambda path: (len(path.name), path.name))
    frames = [read_frame(path.read_bytes(), path.name) for path in paths]
    return sorted(frames, key=lambda frame: frame.time)


def read_frame(content: bytes, name: str) -> Frame:
    """Return the frame of one file's content; ``name`` is for the message. Errors as above."""
    if not content.rstrip().endswith(END):
        raise EngineOutputError(f"MFiX wrote {name} only in part: {len(content)} bytes")
    raw, time, points = RAW.search(content), TIME.search(content), POINTS.search(content)
    if raw is None or time is None or points is None:
        raise EngineOutputError(f"MFiX wrote {name} without the head of a VTP file")
    count = int(points[1])
    head, blocks = content[: raw.start()], content[raw.end() :]
    arrays: dict[str, Floats] = {}
    for array in ARRAY.finditer(head):
        components = 3 if b'NumberOfComponents="3"' in array[2] else 1
        values = _block(blocks, int(array[3]), count * components)
        if values is None:
            raise EngineOutputError(f"MFiX wrote {name} with {array[1].decode()} cut short")
        arrays[array[1].decode()] = values.reshape(count, components)
    return Frame(float(time[1].upper().replace(b"D", b"E")), arrays)


def _block(blocks: bytes, offset: int, count: int) -> Floats | None:
    """Return the values at an offset, or None unless there are as many as expected."""
    size = blocks[offset : offset + 4]
    data = blocks[offset + 4 : offset + 4 + 4 * count]
    if len(size) < 4 or int.from_bytes(size, "big") != 4 * count or len(data) < 4 * count:
        return None
    return np.frombuffer(data, dtype=">f4").astype(np.float64)
