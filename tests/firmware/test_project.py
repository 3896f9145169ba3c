"""The emitted project: the same bytes, and a project that PlatformIO builds and tests unchanged."""

from __future__ import annotations

import hashlib
import json
import shutil
import subprocess
from pathlib import Path
from typing import get_args

import pytest

from gen.firmware.project import project_files, read_verification
from gen.lowering.kinds import Arithmetic, ScheduleKind
from gen.lowering.lower import lower
from tests.examples import ROOT, example
from tests.platformio.environment import install, pio_ci, pio_run, pio_test

EMITTED = ROOT / "firmware_out"
STRICT = {"PLATFORMIO_BUILD_SRC_FLAGS": "-Werror"}
TESTS = 4


def tree(folder: Path) -> dict[str, bytes]:
    return {
        str(path.relative_to(folder)): path.read_bytes()
        for path in sorted(folder.rglob("*"))
        if path.is_file() and ".pio" not in path.parts
    }


def written(folder: Path, arithmetic: Arithmetic, schedule: ScheduleKind, name: str = "my1016") -> Path:
    coefficients = example(name)
    files = project_files(coefficients, lower(coefficients, arithmetic, schedule), "coeffs.json", None)
    for path, text in files.items():
        target = folder / path
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_text(text)
    return folder


def test_the_project_in_the_repository_is_what_build_writes() -> None:
    coefficients = example("my1016")
    record = read_verification(EMITTED / "verification.json", coefficients)
    files = project_files(coefficients, lower(coefficients, "fixed", "table"), "coeffs.json", record)
    kept = tree(EMITTED)
    assert sorted(files) == sorted(kept)
    for path, text in files.items():
        assert text.encode() == kept[path], f"{path} differs: rebuild firmware_out"


def test_the_verification_in_the_repository_is_of_equality() -> None:
    record = json.loads((EMITTED / "verification.json").read_text())
    assert record["verdict"] == "equal"
    assert record["differing"] == 0
    assert {(item["arithmetic"], item["schedule"]) for item in record["combinations"]} == {
        (arithmetic, schedule) for arithmetic in get_args(Arithmetic) for schedule in get_args(ScheduleKind)
    }


def test_the_manifest_lists_every_file_with_its_hash() -> None:
    listed = json.loads((EMITTED / "manifest.json").read_text())["files"]
    kept = tree(EMITTED)
    assert set(kept) - set(listed) == {"manifest.json", "report.html", "verification.json"}
    for path, digest in listed.items():
        assert hashlib.sha256(kept[path]).hexdigest() == digest


def test_pio_builds_and_tests_the_project_unchanged(tmp_path: Path) -> None:
    project = tmp_path / "project"
    shutil.copytree(EMITTED, project)
    variables = install(tmp_path / "core", project) | STRICT
    built = pio_run(project, variables=variables)
    assert "warning" not in built.output
    for environment in ("native", "simavr"):
        pio_test(project, environment, variables=variables).check(TESTS)
    example_sketch = project / "lib" / "my1016" / "examples" / "Basic"
    pio_ci(
        example_sketch,
        [project / "lib" / "my1016"],
        board="megaatmega2560",
        build_dir=tmp_path / "ci",
        variables=variables,
    )
    assert tree(EMITTED) == tree(project)


@pytest.mark.parametrize(("arithmetic", "schedule"), [("float", "table"), ("float", "onboard"), ("fixed", "onboard")])
def test_the_other_combinations_build_and_pass_too(
    tmp_path: Path, arithmetic: Arithmetic, schedule: ScheduleKind
) -> None:
    project = written(tmp_path / "project", arithmetic, schedule)
    variables = install(tmp_path / "core", project) | STRICT
    pio_run(project, variables=variables)
    for environment in ("native", "simavr"):
        pio_test(project, environment, variables=variables).check(TESTS)


@pytest.mark.parametrize("name", ["my1016_averaged", "two_mass"])
def test_the_other_examples_build_and_pass_too(tmp_path: Path, name: str) -> None:
    project = written(tmp_path / "project", "fixed", "table", name)
    variables = install(tmp_path / "core", project) | STRICT
    pio_run(project, variables=variables)
    pio_test(project, "native", variables=variables).check(TESTS)


def test_the_emitted_c_style_interface_compiles_as_c(tmp_path: Path) -> None:
    source = tmp_path / "user.c"
    source.write_text('#include "my1016.h"\nint main(void) { my1016_begin(); my1016_step(3); return 0; }\n')
    done = subprocess.run(
        ["gcc", "-std=c99", "-Wall", "-Wextra", "-Werror", "-c", f"-I{EMITTED / 'lib/my1016/src'}", str(source), "-o",
         str(tmp_path / "user.o")],
        capture_output=True,
        text=True,
        check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
