"""`gen` as a user and a script start it: another process."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

GEN = [sys.executable, "-m", "gen"]


def gen(*arguments: str | Path, cwd: Path | None = None) -> subprocess.CompletedProcess[str]:
    return subprocess.run([*GEN, *map(str, arguments)], capture_output=True, text=True, check=False, cwd=cwd)
