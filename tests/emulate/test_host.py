"""The emitted library on this computer judges as the references do."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from gen.coefficients import Coefficients
from gen.emulate.host import HostDevice
from gen.emulate.plants.rig import RigPlant
from gen.lowering.lower import lower
from gen.lowering.sensors import sensor_limits
from gen.reference.model import ReferenceModel
from gen.reference.sensors import SensorCheck
from gen.rig import SensorFault
from tests.examples import example


@pytest.mark.parametrize("without", ["none", "casing"])
def test_words_give_the_references_codes_and_states(without: str) -> None:
    """Also where a part has no sensor: it starts at the ambient that was measured."""
    coefficients = _without_chip(example("my1016"), without)
    faults = {
        "brush": (SensorFault("open", 10.0, 14.0), SensorFault("jump", 30.0, 40.0)),
        "magnet": (SensorFault("spike", 5.0, 60.0, every_s=7.0),),
    }
    wiring = coefficients.document.wiring
    assert wiring is not None
    channels = [chip.channel for chip in wiring.thermocouples]
    plant = RigPlant(channels, sensor_faults=faults, start_degC={"brush": 60.0, "casing": 50.0})
    checks = {limits.channel: SensorCheck(limits) for limits in sensor_limits(coefficients)}
    names = coefficients.model.component_names
    model = ReferenceModel(lower(coefficients, "fixed", "table"), {name: [0] for name in names})
    ambient, started, seen = 30_000, False, set()
    with HostDevice(coefficients) as host:
        for sample in range(280):
            pwm = (0, 200, -90)[sample % 280 // 100]
            words = plant.step(pwm, 0.25).words
            expected = {}
            told = ambient  # what rises are over until another one is told
            for channel in channels:
                part = int(model.rises_mK[names.index(channel), 0]) + told if channel in names else 0
                code = checks[channel].check(words[channel], True, part)
                expected[channel] = (int(code), checks[channel].temperature_mC / 1000.0)
                seen.add(int(code))
                if channel == "ambient" and code == 0:
                    ambient = checks[channel].temperature_mC
            assert host.sample(words, pwm) == expected
            if started:
                model.set_channels(np.array([[ambient]]))
                model.step(np.array([pwm]))
            elif all(code == 0 for code, _ in expected.values()):
                started = True
                rises = {name: [checks[name].temperature_mC - ambient if name in checks else 0] for name in names}
                model = ReferenceModel(lower(coefficients, "fixed", "table"), rises, np.array([[ambient]]))
                for check in checks.values():
                    check.model_set()
            assert host.started == started
            for part in range(len(names) if started else 0):
                assert host.temperature_mC(part) == model.rises_mK[part, 0] + ambient
    assert {0, 1, 5, 8} <= seen


def _without_chip(coefficients: Coefficients, channel: str) -> Coefficients:
    wiring = coefficients.document.wiring
    assert wiring is not None
    chips = tuple(chip for chip in wiring.thermocouples if chip.channel != channel)
    fewer = wiring.model_copy(update={"thermocouples": chips})
    return replace(coefficients, document=coefficients.document.model_copy(update={"wiring": fewer}))
