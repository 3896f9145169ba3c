"""One file an effect; :mod:`gen.model.effects.registry` finds them."""
