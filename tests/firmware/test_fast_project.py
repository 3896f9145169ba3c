"""The emitted project in the fast form: PlatformIO builds and tests it, and every part says what it is."""

from __future__ import annotations

import json
from pathlib import Path

from gen.firmware.project import project_files
from gen.lowering.lower import lower
from tests.platformio.environment import install, pio_run, pio_test
from tests.verify_helpers import example


def files(name: str) -> dict[str, str]:
    coefficients = example(name)
    return project_files(coefficients, lower(coefficients, "fixed", "table", "fast"), "coeffs.json", None)


def test_the_fast_project_builds_and_passes_its_tests(tmp_path: Path) -> None:
    project = tmp_path / "project"
    for path, text in files("my1016").items():
        target = project / path
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_text(text)
    variables = install(tmp_path / "core", project) | {"PLATFORMIO_BUILD_SRC_FLAGS": "-Werror"}
    assert "warning" not in pio_run(project, variables=variables).output
    for environment in ("native", "simavr"):
        pio_test(project, environment, variables=variables).check(4)


def test_the_fast_form_is_named_and_two_builds_give_the_same_bytes() -> None:
    emitted = files("my1016")
    assert emitted == files("my1016")
    manifest = json.loads(emitted["manifest.json"])
    assert manifest["speed"] == "fast"
    assert {component["name"]: component["block"] for component in manifest["components"]} == {
        "brush": 1,
        "bearing": 4,
        "magnet": 4,
        "casing": 4,
    }
    assert "fast form" in emitted["README.md"]
    assert "$.accuracy.fast_limit_K" in emitted["report.html"]
    assert "40-bit states" in emitted["report.html"]
