from tests.workflows.fakes import registered  # noqa: F401
