"""`gen verify` where not every compiler is installed."""

from __future__ import annotations

import shutil
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from gen.cli import main
from gen.toolchain import ToolMissing, host_compilers
from gen.verification import verify as verification
from tests.examples import ROOT

COEFFICIENTS = ROOT / "examples" / "my1016" / "coeffs.json"
Without = Callable[..., None]


class Begun(Exception):
    """The work itself, which is not run here."""


@pytest.fixture
def without(monkeypatch: pytest.MonkeyPatch) -> Without:
    """Hide programs."""
    which = shutil.which

    def hide(*names: str) -> None:
        monkeypatch.setattr(shutil, "which", lambda name: None if name in names else which(name))

    return hide


def builds(monkeypatch: pytest.MonkeyPatch, *options: str) -> list[str]:
    """Which builds the command would run."""
    seen: list[str] = []

    def verify(*_: object, host_builds: list[str], **__: Any) -> None:  # noqa: ANN401
        seen.extend(host_builds)
        raise Begun

    monkeypatch.setattr(verification, "verify", verify)
    monkeypatch.setattr(sys, "argv", ["gen", "verify", str(COEFFICIENTS), *options])
    with pytest.raises(Begun):
        main()
    return seen


def refusal(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], *options: str) -> str:
    monkeypatch.setattr(sys, "argv", ["gen", "verify", str(COEFFICIENTS), *options])
    with pytest.raises(SystemExit) as ended:
        main()
    assert ended.value.code == 2
    return capsys.readouterr().err


@pytest.mark.parametrize(("missing", "left"), [("clang++", "g++"), ("g++", "clang++")])
def test_the_compiler_that_is_there_is_used_and_the_other_one_told(
    missing: str, left: str, without: Without, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    without(missing)
    assert builds(monkeypatch, "--target", "host") == [f"{left} -O2", f"{left} sanitized"]
    said = capsys.readouterr().err
    assert said.startswith(f"warning: {missing} is missing")
    assert f"verified with {left} only" in said
    assert said.count("\n") == 1
    assert builds(monkeypatch, "--target", "host", "--compilers", left) == [f"{left} -O2", f"{left} sanitized"]
    assert capsys.readouterr().err == ""


def test_with_both_nothing_is_said(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    for options in ([], ["--compilers", "g++, clang++"]):
        expected = {"g++ -O2", "clang++ -O2", "g++ sanitized", "clang++ sanitized"}
        assert set(builds(monkeypatch, "--target", "host", *options)) == expected
    assert capsys.readouterr().err == ""


def test_a_compiler_that_was_asked_for_must_be_there(
    without: Without, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    without("clang++")
    said = refusal(monkeypatch, capsys, "--target", "host", "--compilers", "g++,clang++")
    assert said.startswith("error: clang++ is missing: it is in the Debian package clang")


def test_one_must_be_left(
    without: Without, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    without("g++", "clang++")
    assert "g++ or clang++ is missing" in refusal(monkeypatch, capsys, "--target", "host")
    with pytest.raises(ToolMissing):
        host_compilers()
    assert builds(monkeypatch, "--target", "avr") == []  # it takes another compiler


@pytest.mark.parametrize(
    "options", [["--compilers", "icc"], ["--compilers", ""], ["--target", "avr", "--compilers", "g++"]]
)
def test_compilers_that_cannot_be_meant_are_usage(
    options: list[str], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert "compilers" in refusal(monkeypatch, capsys, *options)


def test_the_package_itself_asks_for_all_of_them(without: Without, tmp_path: Path) -> None:
    """What calls the function and not the command (these tests do) never leaves a compiler out in silence."""
    from tests.examples import example

    without("clang++")
    with pytest.raises(ToolMissing, match=r"clang\+\+ is missing"):
        verification.verify(example("my1016"), ["fixed"], ["table"], "host", scale=0.001)
