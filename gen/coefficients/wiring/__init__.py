"""The board's wiring: which pin of the Mega carries what, and what is plausible on it."""

from gen.coefficients.wiring.board import Memory, Wiring
from gen.coefficients.wiring.drive import Drive, Observe, Profile, ProfileStep
from gen.coefficients.wiring.sensors import SUPPLY_V, ChannelInput, Encoder, Thermocouple

__all__ = [
    "SUPPLY_V",
    "ChannelInput",
    "Drive",
    "Encoder",
    "Memory",
    "Observe",
    "Profile",
    "ProfileStep",
    "Thermocouple",
    "Wiring",
]
