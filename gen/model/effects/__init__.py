"""Named physical effects that a model of poles and gains scheduled by PWM lacks; one file each, found by name.

An effect belongs to one component. Most are heat: a state E (in K) that is added to the component's rise, with
``E' = q - rate E``, where q is heating in K/s (a simple function of channels, PWM and temperatures) and rate is the
component's own, ``A(0)/A'(0)`` at the present PWM, or 1/tau_s. Others stand between the temperature and its reading
(offset, gain, lag, drift), or change entries that the coefficient file has anyway.

A new effect is a new module in the catalogue with one subclass of :class:`Effect`, or such a class anywhere that
:func:`register` or an entry point of the group ``gen.effects`` makes known; nothing else has to know of it.
"""

from gen.model.effects.base import (
    Applied,
    Effect,
    Free,
    Input,
    Lanes,
    Moment,
    Parameters,
    Setting,
    Tau,
    Values,
    Variant,
)
from gen.model.effects.registry import calibration, catalogue_only, register, registry, tolerance_K, unregister

__all__ = [
    "Applied",
    "Effect",
    "Free",
    "Input",
    "Lanes",
    "Moment",
    "Parameters",
    "Setting",
    "Tau",
    "Values",
    "Variant",
    "calibration",
    "catalogue_only",
    "register",
    "registry",
    "tolerance_K",
    "unregister",
]
