"""Print the tests that a run skipped, by its JUnit file, each as an argument of pytest."""

import sys
from collections.abc import Iterator
from pathlib import Path
from xml.etree import ElementTree


def skipped(report: str) -> Iterator[str]:
    """Yield the id of each test that was skipped; of a module that was, its path."""
    for case in ElementTree.parse(report).iter("testcase"):
        if case.find("skipped") is not None:
            module, name = case.get("classname", ""), case.get("name", "")
            parts = (module or name).split(".")
            file = Path(*parts).with_suffix(".py")
            if not file.is_file():
                raise SystemExit(f"{'.'.join(parts)!r}: is no module of tests")
            yield f"{file}::{name}" if module else str(file)


if __name__ == "__main__":
    sys.stdout.writelines(f"{name}\n" for name in skipped(sys.argv[1]))
