"""A gain that its polynomial makes negative is taken as 0 and flagged, by the board as by the reference."""

from __future__ import annotations

import json

import numpy as np

from gen.coefficients import Coefficients, parse
from gen.lowering.lower import lower
from gen.reference.flags import GAIN_ZEROED
from gen.reference.model import ReferenceModel
from gen.verification.verify import verify
from tests.examples import ROOT

ZERO_AT = 100


def crossing() -> Coefficients:
    """A winding of which the gain is negative below PWM 100; two poles, and no rest at which it would not matter."""
    document = json.loads((ROOT / "examples" / "two_mass" / "coeffs.json").read_text())
    winding = document["components"][0]
    winding["negative_gain"] = "zero"
    # A table's knot gives its own value exactly: at PWM 100 the gain is 0 and none that was taken for it.
    winding["gain"] = {"table": {"pwm": [0, ZERO_AT, 255], "value": [-1e-6, 0.0, 1.55e-6], "interpolation": "linear"}}
    document["components"] = [winding]
    document["validity"] = {"pwm": [ZERO_AT, 255], "outside": "extrapolate"}
    document["alarms"] = []
    document["wiring"] = {}
    document.pop("provenance", None)
    return parse(json.dumps(document).encode())


def test_the_flag_is_there_at_the_speeds_of_the_negative_gain_alone() -> None:
    flagged = []
    model = ReferenceModel(lower(crossing(), "fixed", "table"), [0])
    for pwm in range(256):
        model.step(np.array([pwm]))
        if model.record()["flags"][0] & GAIN_ZEROED:
            flagged.append(pwm)
        if 0 < pwm <= ZERO_AT:
            assert model.rises[0, 0] <= 0.0  # nothing warms it
    assert flagged == list(range(1, ZERO_AT))


def test_the_emitted_model_says_the_same() -> None:
    (result,) = verify(crossing(), ["fixed"], ["table"], "host", scale=0.001, host_builds=["g++ -O2"])
    assert result.equal
