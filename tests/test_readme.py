"""What the README shows is what the project has."""

import re
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text(encoding="utf-8")


def test_the_engine_that_the_readme_shows_is_the_one_that_is_tested():
    (shown,) = re.findall(r"```python\n(class \w+\(Engine\).*?)\n```", README, re.DOTALL)
    engine = ROOT / "tests" / "plugins" / "small_dem" / "small_dem" / "engine.py"
    assert shown in engine.read_text(encoding="utf-8")


@pytest.mark.parametrize("link", sorted(set(re.findall(r"\]\(((?!http|#)[^)#]+)", README))))
def test_every_link_leads_to_a_file(link):
    assert (ROOT / link).exists()


def test_every_anchor_is_a_heading():
    headings = {
        re.sub(r"[^a-z0-9 -]", "", line.lstrip("# ").lower()).replace(" ", "-")
        for line in README.splitlines()
        if line.startswith("#")
    }
    assert set(re.findall(r"\]\(#([^)]+)\)", README)) <= headings


@pytest.mark.parametrize("command", sorted(set(re.findall(r"`dem-harness ([a-z-]+)", README))))
def test_every_command_exists(command):
    from harness.cli.app import app

    assert command in app.resolved_commands()


def test_the_package_and_its_citation_name_the_same_paper():
    root = Path(__file__).parents[1]
    (url,) = tomllib.loads((root / "pyproject.toml").read_text())["project"]["urls"].values()
    assert f"url: {url}" in (root / "CITATION.cff").read_text()
    assert f"arXiv {url.rpartition('/')[2]}" in (root / "README.md").read_text()
