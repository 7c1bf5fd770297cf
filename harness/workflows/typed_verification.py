"""A verification of options as they are typed, for those who read options of their own."""

from __future__ import annotations

from collections.abc import Iterable

from harness.comparison.verification import Verification
from harness.engines.contract import Engine
from harness.engines.registry import DEFAULT, open_engine
from harness.engines.typed import check_launcher, check_names, engine_settings, named_values
from harness.workflows.engine_selection import asked_engines
from harness.workflows.verification_run import verify


def verify_as_typed(
    *,
    engine: str | None = None,
    engines: str | None = None,
    program: Iterable[str] | None = None,
    engine_option: Iterable[str] | None = None,
    mpirun: str | None = None,
    level: str | None = None,
    cases: str | None = None,
    **own: str | None,
) -> Verification:
    """Verify an engine by its name; the words are those of ``dem-harness verify``, at level quick.

    ``own`` are further options of the main engine. Nothing is kept. Raise RequestError for what is
    not known or does not go together, EngineMissingError for an engine that is not here.
    """
    programs = named_values(program or (), "--program")
    settings = engine_settings(engine_option or ())
    main = engine or DEFAULT
    check_names(programs, settings, (main, *asked_engines(engines or ()).engines), "--engines")
    check_launcher(mpirun)

    def opened(name: str, **more: str | None) -> Engine:
        return open_engine(name, programs=programs, options=settings.get(name), **more)

    with opened(main, launcher=mpirun, **own) as it:
        return verify(
            level or "quick", cases=cases, engine=it, engines=engines or (), open_one=opened
        )
