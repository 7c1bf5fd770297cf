"""The memo of a bench: what makes two jobs one run."""

from dataclasses import replace

from harness.cases.bench import job_key
from harness.engines.base import Job, Template

JOB = Job(Template("drop", {"": {"height": 2.0}}), {"height": 1.0})


def test_jobs_of_templates_of_one_name_in_two_packages_are_two_runs():
    other = replace(JOB, template=replace(JOB.template, package="another"))
    assert job_key(JOB) == job_key(replace(JOB))
    assert job_key(JOB) != job_key(other)
