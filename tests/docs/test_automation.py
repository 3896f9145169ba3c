"""The files by which hooks and the public CI run the checks say what scripts/test.sh says."""

from __future__ import annotations

import re
import tomllib
from importlib.metadata import version
from pathlib import Path
from typing import Any

import yaml

import gen

ROOT = Path(__file__).parents[2]
TEST_SCRIPT = (ROOT / "scripts" / "test.sh").read_text(encoding="utf-8")
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]


def read(path: str) -> dict[Any, Any]:
    loaded = yaml.safe_load((ROOT / path).read_text(encoding="utf-8"))
    assert isinstance(loaded, dict)
    return loaded


def test_the_hooks_run_the_commands_of_the_test_script_in_its_order() -> None:
    (local,) = read(".pre-commit-config.yaml")["repos"]
    assert local["repo"] == "local"
    of_script = [line.removesuffix(' "$@"') for line in TEST_SCRIPT.splitlines() if line.startswith(".venv/bin/")]
    assert [hook["entry"] for hook in local["hooks"]] == of_script
    assert all(hook["language"] == "system" and not hook["pass_filenames"] for hook in local["hooks"])


def test_style_lint_and_types_are_checked_at_each_commit_and_tests_at_each_push() -> None:
    config = read(".pre-commit-config.yaml")
    stages = {hook["id"]: hook.get("stages") for hook in config["repos"][0]["hooks"]}
    assert stages == {"format": None, "lint": None, "types": None, "tests": ["pre-push"]}
    assert config["default_install_hook_types"] == ["pre-commit", "pre-push"]


def test_the_workflow_runs_the_one_script_with_the_oldest_python_that_is_promised() -> None:
    job = read(".github/workflows/test.yml")["jobs"]["test"]
    commands = [step["run"] for step in job["steps"] if "run" in step]
    assert commands == ["bash .ci/run"]
    assert (ROOT / ".ci" / "run").is_file()
    oldest = PROJECT["requires-python"].removeprefix(">=")
    assert job["strategy"]["matrix"]["python"][0] == oldest


def test_the_site_is_described_by_a_file_whose_hooks_and_style_are_there() -> None:
    site = read("mkdocs.yml")
    assert all((ROOT / hook).is_file() for hook in site["hooks"])
    assert all((ROOT / site["docs_dir"] / sheet).is_file() for sheet in site["extra_css"])
    assert site["theme"]["font"] is False


def test_the_version_stands_in_one_place() -> None:
    assert gen.__version__ == version(PROJECT["name"]) == PROJECT["version"]
    sources = [
        path
        for folder in ("gen", "templates")
        for path in (ROOT / folder).rglob("*.*")
        if path.parent.name != "__pycache__"
    ]
    literal = re.compile(rf"\b{re.escape(PROJECT['version'])}\b")
    assert not [path for path in sources if path.is_file() and literal.search(path.read_text(encoding="utf-8"))]
