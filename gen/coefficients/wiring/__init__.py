"""The board's wiring: which pin carries what, and what is plausible on it."""

from gen.coefficients.wiring.board import Memory, Wiring, Zero
from gen.coefficients.wiring.drive import Drive, Observe, Profile, ProfileStep
from gen.coefficients.wiring.pins import BoardName
from gen.coefficients.wiring.sensors import (
    REGISTER_CHIPS,
    SUPPLY_V,
    ChannelInput,
    CHIP_RANGES_degC,
    ChipName,
    Encoder,
    Thermocouple,
)
from gen.coefficients.wiring.supply import HYSTERESIS_mV, Supply
from gen.coefficients.wiring.thermistor import ENDS_degC, Thermistor

__all__ = [
    "REGISTER_CHIPS",
    "SUPPLY_V",
    "BoardName",
    "CHIP_RANGES_degC",
    "ChannelInput",
    "ChipName",
    "Drive",
    "ENDS_degC",
    "Encoder",
    "HYSTERESIS_mV",
    "Memory",
    "Observe",
    "Profile",
    "ProfileStep",
    "Supply",
    "Thermistor",
    "Thermocouple",
    "Wiring",
    "Zero",
]
