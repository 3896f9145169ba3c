"""Effects in the firmware: from the equations in :mod:`gen.model.effects` to tapes of whole numbers or float32."""

from gen.lowering.effects.lower import lower_effects
from gen.lowering.effects.program import EffectComponent, EffectsProgram

__all__ = ["EffectComponent", "EffectsProgram", "lower_effects"]
