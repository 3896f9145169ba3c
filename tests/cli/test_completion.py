"""Completion in the shell, as docs/systems.md says to set it up."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from gen.cli import cli

GEN = Path(sys.executable).parent / "gen"
COMPLETE = """
eval "$(_GEN_COMPLETE=bash_source gen)"
COMP_WORDS=({words}) COMP_CWORD={at}
_gen_completion gen
printf '%s\\n' "${{COMPREPLY[@]}}"
"""


def completed(*words: str) -> list[str]:
    """What bash would offer for the last word."""
    script = COMPLETE.format(words=" ".join(f"'{word}'" for word in words), at=len(words) - 1)
    environment = {**os.environ, "PATH": f"{GEN.parent}{os.pathsep}{os.environ['PATH']}"}
    done = subprocess.run(["bash", "--norc", "-c", script], capture_output=True, text=True, check=True, env=environment)
    return done.stdout.split()


def test_commands_are_completed() -> None:
    assert sorted(completed("gen", "")) == sorted(cli.commands)
    assert sorted(completed("gen", "i")) == ["identify", "import", "init"]


def test_options_and_their_choices_are_completed() -> None:
    assert completed("gen", "build", "--ari") == ["--arithmetic"]
    assert completed("gen", "build", "--arithmetic", "f") == ["fixed", "float"]


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_each_shell_has_a_script(shell: str) -> None:
    done = subprocess.run(
        [GEN], env={**os.environ, "_GEN_COMPLETE": f"{shell}_source"}, capture_output=True, text=True, check=True
    )
    assert f"_GEN_COMPLETE={shell}_complete" in done.stdout
