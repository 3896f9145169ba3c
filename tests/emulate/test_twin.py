"""The twin raises the alarms that the firmware itself raises, at the same samples."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gen.coefficients import parse
from gen.emulate.board import Board
from gen.emulate.firmware import build_firmware
from gen.emulate.plants.plant import Reading
from gen.emulate.plants.rig import RigPlant
from gen.emulate.plants.twin import alarm_times
from gen.emulate.results import results_of
from gen.emulate.session import run_session
from gen.rig import Profile, SensorConfig
from tests.examples import ROOT

DURATION_S = 240.0
NAMES = ("brush", "bearing", "magnet", "casing")


RULE: dict[str, object] = {"speed_percent": [0, 100], "settle_s": 20, "persistence_s": 15}


def test_the_twin_and_the_firmware_agree(cache: Path) -> None:
    document = json.loads((ROOT / "examples" / "my1016" / "coeffs.json").read_text())
    document["alarms"] = [
        {
            "name": "warm",
            "kind": "over_temperature",
            "component": "casing",
            "limit_degC": 31.5,
            "stop_motor": False,
            **RULE,
        },
        {"name": "slow", "kind": "cusum", "component": "magnet", "slack_K": 0.2, "threshold_K_s": 40.0, **RULE},
        {"name": "above", "kind": "above_model", "component": "bearing", "threshold_K": 0.5, **RULE},
        {"name": "below", "kind": "below_model", "component": "casing", "threshold_K": 0.5, **RULE},
    ]
    assert len(_raised_alike(document, cache)) >= 2


def test_they_agree_where_a_thermocouple_of_its_own_feeds_an_effect(cache: Path) -> None:
    document = json.loads((ROOT / "examples" / "my1016" / "coeffs.json").read_text())
    document["wiring"]["thermocouples"].append({"channel": "winding_degC", "cs": 37, "so": 35, "sck": 31})
    # Far more heat from the winding than the casing really takes: its model must run away from what is measured.
    coupling = {"source": "winding_degC", "conductance_per_s": 5e-3}
    document["alarms"] = [{"name": "below", "kind": "below_model", "component": "casing", "threshold_K": 2.0, **RULE}]
    assert _raised_alike(document, cache) == set(), "without the effect there is nothing to raise"
    document["effects"] = [{"name": "coupling", "component": "casing", "parameters": coupling}]
    assert _raised_alike(document, cache) == {"below"}


def _raised_alike(document: dict[str, Any], cache: Path) -> set[str]:
    """Rules that twin and firmware both raise, at the same time."""
    document["wiring"].pop("encoder", None)  # the plant turns none, and a stall would stop the motor
    coefficients = parse(json.dumps(document).encode())
    wiring = coefficients.document.wiring
    assert wiring is not None
    channels = [chip.channel for chip in wiring.thermocouples]
    # Without noise both start from the same temperature, though the board starts some samples later.
    quiet = {channel.removesuffix("_degC"): SensorConfig(noise_K=0.0) for channel in channels}
    first = alarm_times(coefficients, [RigPlant(channels, sensors=quiet)], [204], DURATION_S)[0]

    firmware = build_firmware(coefficients, "fixed", "table", "coeffs.json", cache)
    board = Board(firmware.elf, firmware.cache, wiring, RigPlant(channels, sensors=quiet))
    session = run_session(board, DURATION_S, profile=((0.0, 204),))
    raised = {alarm.rule: alarm.raised_s for alarm in results_of(coefficients.document, board, session).alarms}
    board.close()
    expected = {rule["name"]: time for rule, time in zip(document["alarms"], first, strict=True) if not np.isnan(time)}
    assert set(raised) == set(expected)
    # The motor begins to move one step of the plant after the board's PWM.
    assert [raised[name] for name in expected] == pytest.approx(list(expected.values()), abs=0.51)
    return set(raised)


class Stepping:
    """Parts at 30 degC, and the casing at 60 from a sample on for a while; notes what it is driven with."""

    def __init__(self, hot: range) -> None:
        self.driven: list[int] = []
        self._hot = hot

    def step(self, pwm: int, dt_s: float) -> Reading:
        self.driven.append(pwm)
        celsius = dict.fromkeys((*NAMES, "ambient"), 30.0)
        celsius["casing"] = 60.0 if len(self.driven) - 1 in self._hot else 30.0
        return Reading({name: round(value * 4) << 3 for name, value in celsius.items()}, 0, {})


def test_an_alarm_is_dated_by_the_first_sample_that_raised_it() -> None:
    """Sample 0 is the start; PWM acts over the sample that ends with a reading."""
    document = json.loads((ROOT / "examples" / "my1016" / "coeffs.json").read_text())
    limit = {"name": "hot", "kind": "over_temperature", "component": "casing", "limit_degC": 50.0}
    document["alarms"] = [limit, {**limit, "name": "never", "limit_degC": 70.0}]
    plant = Stepping(range(9, 12))
    profile = Profile((0.0, 1.0), (0, 100), 5.0)
    ((first, never),) = alarm_times(parse(json.dumps(document).encode()), [plant], [profile], 5.0)
    assert first == 9 * 0.25
    assert np.isnan(never)
    assert plant.driven == [0] + [0] * 4 + [100] * 16  # before the start; a second at rest; four seconds at 100
