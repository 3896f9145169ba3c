"""A model whose switching cannot be proven stable: it saturates, counts and flags, and never wraps round."""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path
from typing import Any, get_args

import numpy as np
import pytest

from gen.coefficients import Coefficients, parse
from gen.lowering.fixed.component import FixedComponent
from gen.lowering.float32 import FloatComponent
from gen.lowering.kinds import Arithmetic
from gen.lowering.lower import lower
from gen.reference.flags import SATURATED
from gen.reference.model import ReferenceModel
from gen.verification.compare import first_mismatch, reference_run
from gen.verification.profiles import Profile, with_channels
from gen.verification.verify import Target, verify
from tests.examples import ROOT


@cache
def unstable() -> Coefficients:
    """Two lightly damped oscillators of different stiffness: switched in time, they pump each other up."""
    document: dict[str, Any] = json.loads((ROOT / "examples" / "two_mass" / "coeffs.json").read_text())
    component = next(item for item in document["components"] if item["order"] == 2)
    real = {"poly": [-0.002]}
    imag = {"table": {"pwm": [0, 255], "value": [0.008, 0.05], "interpolation": "linear"}}
    negative = {"table": {"pwm": [0, 255], "value": [-0.008, -0.05], "interpolation": "linear"}}
    component["poles"] = [{"real": real, "imag": imag}, {"real": real, "imag": negative}]
    component["gain"] = {"poly": [2e-5]}
    document["components"] = [component]
    document["accuracy"] = {"unproven": "saturate"}
    document["alarms"] = []
    document["wiring"] = {}
    document.pop("provenance", None)
    return parse(json.dumps(document).encode())


def pumping(samples: int) -> Profile:
    """Full stiffness on the way back, little on the way out, in the unstable rhythm."""
    soft, stiff = round(np.pi / 2 / 0.008 / 0.25), round(np.pi / 2 / 0.05 / 0.25)
    cycle = np.concatenate([np.zeros(soft, dtype=np.int64), np.full(stiff, 255, dtype=np.int64)])
    return Profile(np.tile(cycle, samples // cycle.size + 1)[None, :samples], np.array([150_000]))


@pytest.mark.parametrize("arithmetic", get_args(Arithmetic))
def test_there_is_no_proof(arithmetic: Arithmetic) -> None:
    program = lower(unstable(), arithmetic, "table")
    assert program.components[0].proof is None
    assert program.saturates


@pytest.mark.parametrize("arithmetic", get_args(Arithmetic))
def test_saturation_is_counted_and_flagged_and_nothing_wraps(arithmetic: Arithmetic) -> None:
    program = lower(unstable(), arithmetic, "table")
    profile = pumping(60_000)
    model = ReferenceModel(program, [150_000])
    before, largest_step = model.rises[0, 0], 0.0
    for pwm in profile.pwm[0]:
        model.step(np.array([pwm]))
        largest_step = max(largest_step, abs(model.rises[0, 0] - before))
        before = model.rises[0, 0]
    assert model.saturations[0] > 0
    assert model.record()["flags"][0] & SATURATED
    # A wrap would be a step by the whole range of the word.
    component = program.components[0]
    if isinstance(component, FloatComponent):
        whole = 2.0 ** (32 - component.fraction_bits[0])
    else:
        assert isinstance(component, FixedComponent)
        whole = 2.0 ** (48 - component.layout.fraction_bits[0])
    assert largest_step < whole / 8.0


@pytest.mark.parametrize("arithmetic", get_args(Arithmetic))
@pytest.mark.parametrize("target", ["host", "avr"])
def test_the_board_saturates_in_the_same_samples(target: Target, arithmetic: Arithmetic) -> None:
    result = verify(unstable(), [arithmetic], ["table"], target, scale=0.02, host_builds=["g++ sanitized"])[0]
    assert result.equal
    assert result.bound_K == {"winding": None}


@pytest.mark.parametrize("arithmetic", get_args(Arithmetic))
def test_the_host_s_words_are_the_reference_s_through_saturation(arithmetic: Arithmetic, tmp_path: Path) -> None:
    from gen.firmware import render
    from gen.firmware.context import project_context
    from gen.verification.runners import HostRunner, write_library

    program = lower(unstable(), arithmetic, "table")
    context = project_context(unstable(), program, "coeffs.json")
    library = write_library(program, context, render.library(context), tmp_path)
    profile = with_channels(pumping(60_000), program.channels)
    expected = reference_run(program, profile)
    assert expected["saturations"][0, -1] > 0
    assert first_mismatch(expected, HostRunner(library, "g++ sanitized").run(profile)) is None
