"""docs/python.md says nothing that does not run."""

from __future__ import annotations

import contextlib
import io
import re
import shutil
from pathlib import Path
from typing import Any

import pytest

import gen
from tests.examples import ROOT

PAGE = (ROOT / "docs" / "python.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"^```python\n(.*?)^```$", PAGE, re.MULTILINE | re.DOTALL)


def test_the_blocks_of_the_page_run_in_its_order(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """In a folder that has the examples which the page reads, and where it may write."""
    for name in set(re.findall(r'"(examples/[^"]+)"', PAGE)):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(ROOT / name, tmp_path / name)
    monkeypatch.chdir(tmp_path)
    names: dict[str, Any] = {}
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed):
        for number, block in enumerate(BLOCKS, start=1):
            exec(compile(block, f"docs/python.md, block {number}", "exec"), names)
    assert f"`{printed.getvalue().strip()}`" in PAGE  # what is said to be printed
    assert names["refined"].verdict == "explained"
    assert names["identified"].verdict.startswith("Good")
    assert [round(rise, 1) for rise in names["rises"].loc[[51, 153, 255], "casing"]] == [23.7, 34.4, 33.5]
    assert list(names["heater"].columns) == ["pwm", "sensor1_degC", "ambient_degC", "heater2_percent"]
    for written in ("bench.json", "bench.html", "refined.json", "refined.html", "verification.json", "firmware"):
        assert (tmp_path / written).exists()


def test_the_page_has_every_function_and_what_each_gives() -> None:
    code = "\n".join(BLOCKS)
    for name in ("load", "read_run", "simulate", "identify", "refine", "build", "verify"):
        assert f"gen.{name}(" in code
    for function, result, members in re.findall(r"^\| `gen\.(\w+)` \|.*\| `(\w+)`: (.*) \|$", PAGE, re.MULTILINE):
        assert callable(getattr(gen, function))
        of = getattr(gen, result)
        fields = getattr(of, "__dataclass_fields__", {})
        for member in re.findall(r"`(\w+)(?:\(\))?`", members):
            assert hasattr(of, member) or member in fields, (result, member)
