"""A network that reads the PWM with its sign, on the emulated Mega."""

from __future__ import annotations

import json
from pathlib import Path

from gen.avr.compile import ArduinoCore, build_elf
from gen.coefficients import parse
from gen.firmware.project import project_files
from gen.lowering.lower import lower
from tests.device.board import Board
from tests.examples import ROOT


def test_a_network_whose_heat_depends_on_the_direction_is_told_it(cache: Path) -> None:
    """Three times the heat backwards: from the same start the model is far warmer after a minute of it."""
    tree = json.loads((ROOT / "examples" / "my1016_rig" / "network.json").read_text(encoding="utf-8"))
    tree["network"].setdefault("channels", []).append({"column": "pwm", "range": [-255, 255], "neutral": 0})
    for heat in tree["network"]["heats"]:
        heat["factors"] = [{"channel": "pwm", "table": {"at": [-1, 0], "value": [3.0, 1.0]}}]
    tree["wiring"].pop("encoder", None)  # no stall
    for chip in tree["wiring"]["thermocouples"]:
        chip["stuck_s"] = 10_000  # the test's room is without noise, and its parts do not warm
    tree["accuracy"] = {"fixed_limit_K": 1e-2}
    coefficients = parse(json.dumps(tree).encode())
    folder = cache / "told_pwm"
    for path, text in project_files(coefficients, lower(coefficients, "fixed", "table"), "coeffs.json", None).items():
        (folder / path).parent.mkdir(parents=True, exist_ok=True)
        (folder / path).write_text(text)
    library = next((folder / "lib").iterdir()) / "src"
    sources = sorted([*(folder / "src").glob("*.cpp"), *library.glob("*.cpp")])
    elf = build_elf(
        sources, [folder / "src", library], folder / "firmware.elf", core=ArduinoCore(cache), optimisation="-Os"
    )
    rises = {}
    for pwm in (200, -200):
        board = Board(elf, cache, coefficients)
        first = board.started().rows[-1]
        board.drive(pwm)
        last = board.hear(60.0).rows[-1]
        assert last["pwm"] == str(pwm)
        models = [column for column in last if column.endswith("_model_degC")]
        rises[pwm] = max(float(last[column]) - float(first[column]) for column in models)
    assert rises[200] > 0.1
    assert 2.0 * rises[200] < rises[-200]
