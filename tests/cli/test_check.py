"""`gen check` as a user meets it."""

from __future__ import annotations

import json
import os
import re
import shutil
import signal
import subprocess
import time
from pathlib import Path

import pytest

from tests.cli.commands import COEFFICIENTS
from tests.command import GEN, gen
from tests.examples import ROOT


@pytest.fixture(scope="module")
def emitted(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A project that nobody edits."""
    folder = tmp_path_factory.mktemp("emitted") / "project"
    assert gen("build", COEFFICIENTS, "--out", folder).returncode == 0
    return folder


def test_check_says_what_is_proven_of_each_part(emitted: Path) -> None:
    done = gen("check", emitted, "--coefficients", COEFFICIENTS)
    assert (done.returncode, done.stderr) == (0, "")
    *parts, last = done.stdout.splitlines()
    assert [line.split(":")[0].strip() for line in parts] == ["brush", "bearing", "magnet", "casing"]
    claimed = json.loads((emitted / "certificate.json").read_text())["components"]
    for line, part in zip(parts, claimed, strict=True):
        word, reading = (float(number) for number in re.findall(r"([\d.e-]+) K", line))
        assert (word, reading) == (part["bound_K"], part["reading_K"])
    assert re.fullmatch(rf"{emitted}: \d+ inequalities hold", last)


@pytest.mark.parametrize("content", [None, '{"format": "gen-certificate", "version": 1', "[]", '{"format": "other"}'])
def test_check_names_a_certificate_that_is_none(content: str | None, tmp_path: Path) -> None:
    if content is not None:
        (tmp_path / "certificate.json").write_text(content)
    done = gen("check", tmp_path)
    assert (done.returncode, done.stdout, done.stderr.count("\n")) == (2, "", 1)
    assert done.stderr.startswith(f"error: {tmp_path / 'certificate.json'}: ")


def test_check_of_a_project_that_is_not_whole(emitted: Path, tmp_path: Path) -> None:
    """Without its manifest it is no project; without a source there is nothing that the claims follow from."""
    project = shutil.copytree(emitted, tmp_path / "project")
    (project / "manifest.json").unlink()
    done = gen("check", project)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.splitlines()[-1].startswith(f"error: {project / 'manifest.json'}: ")
    shutil.copy(emitted / "manifest.json", project)
    (project / "lib" / "my1016" / "src" / "my1016_step.h").unlink()
    done = gen("check", project)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.splitlines()[-1].startswith(f"error: {project / 'lib/my1016/src/my1016_step.h'}: ")


def test_check_fails_with_the_coefficients_of_another_motor(emitted: Path, tmp_path: Path) -> None:
    """Of another name, and of the same name with a gain that differs in its last digit."""
    text = COEFFICIENTS.read_text()
    gain = json.loads(text)["components"][1]["gain"]
    first = str(next(iter(gain.values()))[0])
    assert first in text
    near = tmp_path / "near.json"
    near.write_text(text.replace(first, f"{first}1", 1))
    for other, message in (
        (ROOT / "examples" / "two_mass" / "coeffs.json", "another model or domain"),
        (near, "another equation of bearing"),
    ):
        done = gen("check", emitted, "--coefficients", other)
        assert (done.returncode, done.stdout) == (1, "")
        assert done.stderr.splitlines()[-1] == f"failed: the certificate is about {message}"


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupted_check_leaves_nothing_behind(emitted: Path, tmp_path: Path, number: int) -> None:
    scratch = tmp_path / "scratch"
    scratch.mkdir()
    process = subprocess.Popen(
        [*GEN, "check", str(emitted)],
        env={**os.environ, "TMPDIR": str(scratch)},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    while process.poll() is None and not list(scratch.glob("*/*")):  # the library is being compiled there
        time.sleep(0.02)
    process.send_signal(number)
    out, told = process.communicate(timeout=60.0)
    assert (process.returncode, out) == (130 if number == signal.SIGINT else 143, "")
    assert "Traceback" not in told
    assert list(scratch.iterdir()) == []


def test_without_a_compiler_check_says_which_package_has_it(emitted: Path, tmp_path: Path) -> None:
    nowhere = {**os.environ, "PATH": str(tmp_path)}
    done = subprocess.run([*GEN, "check", str(emitted)], env=nowhere, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout) == (2, "")
    assert "g++ is missing: it is in the Debian package g++" in done.stderr.splitlines()[-1]
