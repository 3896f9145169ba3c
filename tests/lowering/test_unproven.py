"""Components of which nothing can be proven: refused by name, unless the file asks for them; and sought harder for."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner

from gen.coefficients import Coefficients, parse
from gen.commands.build import build
from gen.errors import CheckFailed
from gen.lowering.fixed.lower import lower_component
from gen.lowering.kinds import Arithmetic
from gen.lowering.lower import lower
from gen.model.exact import ExactSolution
from gen.reference.lanes import lanes_of
from tests.examples import ROOT
from tests.work import lines

STIFFER = {"pwm": [0, 255], "value": [0.008, 0.05], "interpolation": "linear"}
SOFTER = {"pwm": [0, 255], "value": [-0.008, -0.05], "interpolation": "linear"}
#: Switched in time, this oscillator pumps itself up.
UNSTABLE = [
    {"real": {"poly": [-0.002]}, "imag": {"table": STIFFER}},
    {"real": {"poly": [-0.002]}, "imag": {"table": SOFTER}},
]


def document(poles: list[dict[str, Any]], gain: float, sample_time_s: float, **accuracy: object) -> bytes:
    tree: dict[str, Any] = json.loads((ROOT / "examples" / "two_mass" / "coeffs.json").read_text())
    tree["components"] = [{"name": "part", "order": len(poles), "gain": {"poly": [gain]}, "poles": poles}]
    tree |= {"sample_time_s": sample_time_s, "alarms": [], "wiring": {}, "accuracy": accuracy}
    tree.pop("provenance", None)
    return json.dumps(tree).encode()


def constant(*poles: float) -> list[dict[str, Any]]:
    return [{"real": {"poly": [pole]}} for pole in poles]


@pytest.mark.parametrize("arithmetic", ["fixed", "float"])
def test_it_is_refused_with_its_name_the_reason_and_the_entry(arithmetic: Arithmetic) -> None:
    with pytest.raises(CheckFailed) as caught:
        lower(parse(document(UNSTABLE, 2e-5, 0.25)), arithmetic, "table")
    assert str(caught.value) == (
        "component part: no error bound can be proven: arbitrary switching between these PWM values is not "
        'contractive; with $.accuracy.unproven = "saturate" it is built without one'
    )


@pytest.mark.parametrize("arithmetic", ["fixed", "float"])
def test_asked_for_it_is_built_and_says_so_last(arithmetic: Arithmetic, tmp_path: Any) -> None:  # noqa: ANN401
    path = tmp_path / "coeffs.json"
    path.write_bytes(document(UNSTABLE, 2e-5, 0.25, unproven="saturate"))
    done = CliRunner().invoke(build, [str(path), "--out", str(tmp_path / "out"), "--arithmetic", arithmetic])
    assert done.exit_code == 0, done.output
    assert done.stdout.splitlines()[-1] == ("NO GUARANTEE for part: as $.accuracy.unproven asks, built without a proof")
    manifest = json.loads((tmp_path / "out" / "manifest.json").read_text())
    assert manifest["without_proof"] == {"part": "arbitrary switching between these PWM values is not contractive"}
    assert "There is no guarantee for part" in (tmp_path / "out" / "report.html").read_text()


def _two_fast_poles() -> Coefficients:
    """Nothing switches, but what a sample makes of a direction lies beyond the facets at it."""
    return parse(document(constant(-0.01, -0.0025), 9.803921568627451e-06, 5.0))


def test_what_lies_beyond_a_direction_s_own_facets_is_proven_all_the_same() -> None:
    loaded = _two_fast_poles()
    component = lower_component(loaded.model, loaded.model.components[0], 1e-5)
    assert component.proof is not None
    pwm = np.random.default_rng(2).choice([0, 255], (4, 400))
    pwm[0] = 255
    exact = ExactSolution(loaded.model).simulate(pwm, {"part": np.zeros(4)})["part"]
    board, before, worst = lanes_of(component, [0] * 4), None, 0.0
    for sample in range(400):
        board.sample(pwm[:, sample], before)
        before = pwm[:, sample]
        worst = max(worst, float(np.abs(board.rise() - exact[:, sample + 1]).max()))
    assert 0.01 * component.proof.bound_K < worst <= component.proof.bound_K
    with pytest.raises(CheckFailed, match=r"component part: the guaranteed error bound of .* exceeds"):
        lower(loaded, "fixed", "table")


def test_a_pole_far_too_slow_for_float32_is_refused_without_long_thought() -> None:
    """Some 1 000 000 lines before, one for every step of every PWM's response."""
    loaded = parse(document(constant(-1e-9), 2e-10, 0.05))

    def refused() -> None:
        with pytest.raises(CheckFailed, match=r"roundings can add up to more than a thousandth of its ranges; with"):
            lower(loaded, "float", "table")

    assert lines(refused) < 200_000
