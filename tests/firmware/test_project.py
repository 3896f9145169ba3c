"""The emitted project: the same bytes, and a project that PlatformIO builds and tests unchanged."""

from __future__ import annotations

import hashlib
import json
import shutil
import subprocess
from pathlib import Path
from typing import get_args

import pytest
from platformio.package.manifest.parser import ManifestParserFactory
from platformio.package.manifest.schema import ManifestSchema

from gen.firmware.project import project_files, read_verification
from gen.lowering.kinds import Arithmetic, ScheduleKind
from gen.lowering.lower import lower
from tests.campaign import FULL
from tests.examples import ALL, ROOT, example
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
    own, stored = (json.loads(made["certificate.json"]) for made in (files, kept))
    assert_alike(own, stored)
    manifest, listed = (json.loads(made["manifest.json"]) for made in (files, kept))
    for made in (manifest, listed):
        del made["files"]["certificate.json"]
    assert manifest == listed, "manifest.json differs: rebuild firmware_out"
    for path, text in files.items():
        if path not in ("certificate.json", "manifest.json"):
            assert text.encode() == kept[path], f"{path} differs: rebuild firmware_out"


def assert_alike(one: object, other: object) -> None:
    """A certificate's floats may differ in their last digits from processor to processor, and nothing else."""
    if isinstance(one, dict) and isinstance(other, dict):
        assert list(one) == list(other)
        for key, value in one.items():
            assert_alike(value, other[key])
    elif isinstance(one, list) and isinstance(other, list):
        assert len(one) == len(other)
        for value, its in zip(one, other, strict=True):
            assert_alike(value, its)
    elif isinstance(one, float):
        assert one == pytest.approx(other, rel=1e-9, abs=1e-20), "certificate.json differs: rebuild firmware_out"
    else:
        assert one == other


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


#: Every example but the MY1016's own, which the tests above build: all that a user may copy. As it is built without a
#: word, in fixed point, and each second one in float as well; a full campaign builds the others in float, too.
OTHERS = [
    pytest.param(name, arithmetic, id=f"{name}-{arithmetic}", marks=() if often else pytest.mark.campaign)
    for number, name in enumerate(name for name in ALL if name != "my1016")
    for arithmetic in get_args(Arithmetic)
    if (often := arithmetic == "fixed" or number % 2 == 0) or FULL
]


@pytest.mark.parametrize(("name", "arithmetic"), OTHERS)
def test_the_other_examples_build_and_pass_too(tmp_path: Path, name: str, arithmetic: Arithmetic) -> None:
    project = written(tmp_path / "project", arithmetic, "table", name)
    variables = install(tmp_path / "core", project) | STRICT
    built = pio_run(project, variables=variables)
    assert "warning" not in built.output
    for environment in ("native", "simavr"):
        pio_test(project, environment, variables=variables).check(TESTS)


def test_every_example_is_among_them() -> None:
    assert {"my1016_averaged", "my1016_rig", "network", "two_mass", "two_mass_refined", "two_nodes"} <= {
        name for name, _ in (p.values for p in OTHERS)
    }


@pytest.mark.parametrize("name", ["my1016", "two_mass_refined"])
def test_the_librarys_manifests_are_complete_and_valid(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    """By PlatformIO's own schema; only its list of licences, which lies on the network, is put in place here."""
    project = written(tmp_path, "fixed", "table", name)
    library = next((project / "lib").iterdir())
    monkeypatch.setattr(ManifestSchema, "load_spdx_licenses", lambda _: {"licenses": [{"licenseId": "MIT"}]})
    given = ManifestParserFactory.new_from_file(str(library / "library.json")).as_dict()
    manifest = ManifestSchema().load_manifest(given)
    assert manifest["license"] == "MIT"
    assert manifest["authors"] == [{"name": "the gen authors", "maintainer": True}]
    assert {"temperature", "dc motor"} <= set(manifest["keywords"])
    assert (library / manifest["examples"][0]["base"] / manifest["examples"][0]["files"][0]).is_file()
    assert (library / "src" / manifest["headers"][0]).is_file()
    assert (library / "LICENSE").read_bytes() == (ROOT / "LICENSE").read_bytes()
    arduino = ManifestParserFactory.new_from_file(str(library / "library.properties")).as_dict()
    assert ManifestSchema().load_manifest(arduino)["name"] == given["name"]
    lines = dict(line.split("=", 1) for line in (library / "library.properties").read_text().splitlines())
    assert all(lines[key] for key in ("author", "maintainer", "license", "sentence", "paragraph", "category", "url"))


def test_a_repository_is_named_where_the_package_states_one(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    url = "https://example.org/gen.git"
    monkeypatch.setattr("gen.firmware.project.REPOSITORY", url)
    library = next((written(tmp_path, "float", "table", "two_mass") / "lib").iterdir())
    assert json.loads((library / "library.json").read_text())["repository"] == {"type": "git", "url": url}
    assert f"url={url}\n" in (library / "library.properties").read_text()


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
