"""The notebook in examples/ runs, and what is stored in it is what comes out."""

from __future__ import annotations

import base64
import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from tests.examples import ROOT

FOLDER = ROOT / "examples" / "notebook"
NOTEBOOK = FOLDER / "from_runs_to_firmware.ipynb"
MOST_BYTES = 700_000


def cells(path: Path) -> list[dict[str, Any]]:
    """The cells with code."""
    return [cell for cell in json.loads(path.read_text(encoding="utf-8"))["cells"] if cell["cell_type"] == "code"]


def verdicts(path: Path) -> dict[str, str]:
    """What the cells that are tagged so print, by cell."""
    return {
        cell["id"]: "".join(
            line for output in cell["outputs"] if output["output_type"] == "stream" for line in output["text"]
        )
        for cell in cells(path)
        if "verdict" in cell["metadata"].get("tags", [])
    }


@pytest.fixture(scope="module")
def executed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A copy that was run beside a copy of what it reads, by the command that stores the outputs."""
    examples = tmp_path_factory.mktemp("notebook") / "examples"
    shutil.copytree(FOLDER, examples / FOLDER.name)
    (examples / "my1016").mkdir()
    shutil.copy(ROOT / "examples" / "my1016" / "coeffs.json", examples / "my1016")
    copy = examples / FOLDER.name / NOTEBOOK.name
    own = {"IPYTHONDIR": str(examples.parent), "JUPYTER_RUNTIME_DIR": str(examples.parent / "runtime")}
    command = [sys.executable, str(FOLDER / "execute.py"), str(copy)]
    done = subprocess.run(command, env=os.environ | own, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return copy


def test_it_runs_with_all_that_it_asserts_and_comes_to_the_stored_verdicts(executed: Path) -> None:
    assert verdicts(executed) == verdicts(NOTEBOOK)
    assert verdicts(NOTEBOOK)["refine"] == "explained\n"
    assert verdicts(NOTEBOOK)["verify"] == "equal\n"
    assert [cell["source"] for cell in cells(executed)] == [cell["source"] for cell in cells(NOTEBOOK)]


def test_its_outputs_are_stored_and_are_those_of_one_run_from_top_to_bottom() -> None:
    stored = cells(NOTEBOOK)
    assert [cell["execution_count"] for cell in stored] == list(range(1, len(stored) + 1))
    assert [cell["id"] for cell in stored if not cell["outputs"]] == ["import"]
    outputs = [output for cell in stored for output in cell["outputs"]]
    assert not [output for output in outputs if output["output_type"] == "error" or output.get("name") == "stderr"]
    pictures = [output["data"]["image/png"] for output in outputs if "image/png" in output.get("data", {})]
    assert len(pictures) >= 4
    assert all(base64.b64decode(picture).startswith(b"\x89PNG") for picture in pictures)


def test_it_is_small_and_names_nobody_s_machine() -> None:
    text = NOTEBOOK.read_text(encoding="utf-8")
    assert len(text) < MOST_BYTES
    outputs = [output for cell in cells(NOTEBOOK) for output in cell["outputs"]]
    for output in outputs:
        output.get("data", {}).pop("image/png", None)
    prose = json.dumps([outputs, [cell["metadata"] for cell in cells(NOTEBOOK)]])
    assert not re.findall(r"(?<![\w./])(?:/[a-z]+){2,}|[A-Z]:\\\\|0x[0-9a-f]{6,}", prose)
    assert '"execution"' not in prose  # times
