"""The options of a film, and how a command writes one."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from harness.cli.command import File, options
from harness.cli.files import write_all
from harness.errors import RequestError

if TYPE_CHECKING:
    from harness.report.film import Film


@options("Film")
class FilmOptions:
    """A film of the motion, and its length."""

    film: File = None
    """Write a film of the motion to this file: .gif, or .mp4 where ffmpeg is on the path."""
    frames: int | None = None
    """Pictures of the film, 20 a second. [default: 120]"""

    def check(self) -> None:
        """Raise RequestError, before anything is run, for a film that cannot be written."""
        if self.film is None:
            if self.frames is not None:
                raise RequestError(f"--frames {self.frames}: goes with --film only")
            return
        from harness.report.film import check_film

        check_film(self.film, self.pictures, "--film")

    @property
    def pictures(self) -> int:
        """Return the number of pictures."""
        return 120 if self.frames is None else self.frames

    def write(self, make: Callable[[int], Film]) -> None:
        """Write the film that ``make`` returns for a number of pictures, if one is requested."""
        if self.film is not None:
            write_all({("--film", self.film): make(self.pictures).write})
