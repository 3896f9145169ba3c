"""The emitted effects on this computer, word for word as the reference."""

from __future__ import annotations

from pathlib import Path
from typing import get_args

import pytest

from gen.firmware import render
from gen.firmware.context import project_context
from gen.lowering.program import Arithmetic
from gen.verify import compare
from gen.verify.effects import with_channels
from gen.verify.profiles import campaign
from gen.verify.runners import HostRunner, write_library
from tests.effects.cases import CASES, case, lowered


@pytest.mark.parametrize("arithmetic", get_args(Arithmetic))
@pytest.mark.parametrize("label", CASES)
def test_every_word_is_equal(label: str, arithmetic: Arithmetic, tmp_path: Path) -> None:
    program = lowered(label, arithmetic)
    context = project_context(case(label), program, "coeffs.json")
    library = write_library(program, context, render.library(context), tmp_path)
    profile = with_channels(campaign(program.model, 12, 250, seed=3), program.effects)
    found = HostRunner(library, "g++ sanitized").run(profile)
    assert compare.first_mismatch(compare.reference_run(program, profile), found) is None
