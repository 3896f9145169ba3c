"""The emitted effects on this computer and on the emulated Mega, word for word as the reference."""

from __future__ import annotations

import re
import subprocess
from pathlib import Path
from typing import get_args

import pytest

from gen import toolchain
from gen.firmware import render
from gen.firmware.context import project_context
from gen.lowering.kinds import Arithmetic
from gen.verification import compare
from gen.verification.profiles import Profile, campaign, with_channels
from gen.verification.runners import WARNINGS, AvrRunner, HostRunner, Library, write_library
from tests.effects.cases import CASES, TOGETHER, case, lowered

#: What leaves parts of the code out: no heat, no chain, no own state; and what no other case has beside it.
SPECIAL = ("fast", "sensor_offset", "load_heating, own time constant", "ambient, delayed", "ambient, own time constant")


def _library(label: str, arithmetic: Arithmetic, folder: Path) -> Library:
    program = lowered(label, arithmetic)
    context = project_context(case(label), program, "coeffs.json")
    return write_library(program, context, render.library(context), folder)


def _profile(library: Library, lanes: int, length: int) -> Profile:
    return with_channels(campaign(library.program.model, lanes, length, seed=3), library.program.channels)


@pytest.mark.parametrize("arithmetic", get_args(Arithmetic))
@pytest.mark.parametrize("label", [*TOGETHER, *SPECIAL])
def test_every_word_is_equal_on_this_computer(label: str, arithmetic: Arithmetic, tmp_path: Path) -> None:
    library = _library(label, arithmetic, tmp_path)
    profile = _profile(library, 12, 200)
    found = HostRunner(library, "g++ sanitized").run(profile)
    assert compare.first_mismatch(compare.reference_run(library.program, profile), found) is None


@pytest.mark.parametrize("arithmetic", get_args(Arithmetic))
@pytest.mark.parametrize("label", TOGETHER)
def test_every_word_is_equal_on_the_emulated_mega(label: str, arithmetic: Arithmetic, tmp_path: Path) -> None:
    library = _library(label, arithmetic, tmp_path)
    profile = _profile(library, 6, 40)
    found = AvrRunner(library, tmp_path / "cache").run(profile)
    assert compare.first_mismatch(compare.reference_run(library.program, profile), found) is None


@pytest.mark.parametrize("arithmetic", get_args(Arithmetic))
@pytest.mark.parametrize("label", CASES)
def test_every_effect_alone_compiles_without_a_warning(label: str, arithmetic: Arithmetic, tmp_path: Path) -> None:
    library = _library(label, arithmetic, tmp_path)
    source = next(path for path in library.sources if path.name.endswith("_effects.cpp"))
    for name in ("g++", "clang++"):  # of what is not used, one warns more than the other
        compiler = str(toolchain.program(name))
        command = [compiler, "-std=gnu++11", *WARNINGS, "-fsyntax-only", f"-I{library.include}", str(source)]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr


def test_a_planted_fault_in_an_effect_is_caught(tmp_path: Path) -> None:
    library = _library("load_heating, own time constant", "fixed", tmp_path)
    source = next(path for path in library.sources if path.name.endswith("_effects.cpp"))
    factor = re.compile(r"(\d+)UL\);  // 60 s")
    text, changed = factor.subn(lambda found: f"{int(found[1]) + 1}UL);", source.read_text())
    assert changed == 1
    source.write_text(text)
    profile = _profile(library, 4, 50)
    mismatch = compare.first_mismatch(
        compare.reference_run(library.program, profile), HostRunner(library, "g++ -O2").run(profile)
    )
    assert mismatch is not None
    assert mismatch.field == "winding.follower0"
