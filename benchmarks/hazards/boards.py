"""The coefficient files of the hazards' boards, and their firmware."""

from __future__ import annotations

import json
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any, Literal

from gen.coefficients import Coefficients, parse
from gen.coefficients.alarms import OverTemperature
from gen.coefficients.protecting import limited_parts, protections
from gen.coefficients.wiring import Wiring
from gen.emulate.firmware import Firmware, build_firmware, cache_folder

ROOT = Path(__file__).parents[2]
PULSES = 20
"""The encoder's, in a revolution."""
SEEN_S = 1.0
"""What a board may need, beyond a cause's delay, to see it and to act."""

Kind = Literal["relay", "plain", "observing", "commissioned", "supplied", "unmeasured"]


@dataclass(frozen=True)
class Variant:
    """A board: its coefficient file and its firmware."""

    kind: Kind
    coefficients: Coefficients
    firmware: Firmware

    @property
    def wiring(self) -> Wiring:
        """The coefficient file's."""
        wiring = self.coefficients.document.wiring
        assert wiring is not None
        return wiring

    @property
    def limits(self) -> dict[str, float]:
        """By part, the lowest temperature that stops the motor, degC."""
        document = self.coefficients.document
        stopping = limited_parts(document)
        limits: dict[str, float] = {}
        for rule in document.alarms:
            if isinstance(rule, OverTemperature) and rule.component in stopping:
                limits[rule.component] = min(rule.limit_degC, limits.get(rule.component, rule.limit_degC))
        return limits

    @property
    def blind_s(self) -> float:
        """For how long the file lets the motor be driven blind, s."""
        lost = [entry for entry in protections(self.coefficients.document) if entry.cause == "sensor_lost"]
        return max((entry.delay_s for entry in lost if entry.stops), default=0.0) + SEEN_S

    @property
    def actions(self) -> dict[str, str]:
        """What the board does, by the name of the entry."""
        return {entry.label: entry.action for entry in protections(self.coefficients.document)}


@cache
def variant(kind: Kind) -> Variant:
    """Build a board's firmware, unless that was done before."""
    tree: dict[str, Any] = json.loads((ROOT / "examples" / "my1016" / "coeffs.json").read_text(encoding="utf-8"))
    wiring = tree["wiring"]
    wiring["encoder"]["pulses_per_revolution"] = PULSES  # each costs the emulator an interrupt
    if kind == "observing":
        del wiring["drive"]
        wiring |= {"observe": {"forward_pin": 4, "reverse_pin": 5}, "relay_pin": 12}
    else:
        wiring["command_timeout_s"] = 20
        if kind != "plain":
            wiring["relay_pin"] = 12
    if kind == "commissioned":
        tree["protection"] = [{"cause": "not_commissioned", "action": "stop"}]
    if kind in ("supplied", "unmeasured"):  # whether somebody measured the chip's reference
        wiring["supply"] = {"bandgap_mV": 1100} if kind == "supplied" else {}
        tree["protection"] = [{"cause": "supply_low", "delay_s": 1, "action": "stop"}]
    coefficients = parse(json.dumps(tree).encode())
    folder = cache_folder()
    folder.mkdir(parents=True, exist_ok=True)
    return Variant(kind, coefficients, build_firmware(coefficients, "fixed", "table", "coeffs.json", folder))
