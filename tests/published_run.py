"""A run as `verify` publishes it, of no checks, for tests that read such runs."""

RUN = {
    "schema": 2,
    "level": "quick",
    "started": "2030-01-01T00:00:00+00:00",
    "seconds": 1.0,
    "platform": "a test",
    "harness_version": "1",
    "status": 0,
    "engine": None,
    "closed_form_deg": 10.2,
    "checks": [],
}
