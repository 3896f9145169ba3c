"""Changed schedules: a component with factors on its gain and poles at every |PWM|."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from gen.arrays import FloatArray
from gen.model.dynamics import MAX_PWM, Component, Pole, ThermalModel
from gen.model.schedules import Schedule, Table


def scaled(model: ThermalModel, component: str, steady: FloatArray, rate: FloatArray) -> ThermalModel:
    """The model with one component's steady rise and poles multiplied, by tables with a point at every count.

    Parameters
    ----------
    model
        The model.
    component
        Name of the component.
    steady, rate
        Factor of the steady rise and of every pole at |PWM| 0..255, shape (256,).
    """
    made = [_scaled(part, steady, rate) if part.name == component else part for part in model.components]
    return replace(model, components=tuple(made))


def _scaled(part: Component, steady: FloatArray, rate: FloatArray) -> Component:
    def table(schedule: Schedule, factor: FloatArray) -> Table:
        held = [part._held(x) for x in range(MAX_PWM + 1)]
        values = [float(schedule.exact(x)) * float(f) for x, f in zip(held, factor, strict=True)]
        return Table(tuple(range(MAX_PWM + 1)), tuple(values), "linear")

    gain = np.where(np.arange(MAX_PWM + 1) == 0, 1.0, steady * rate**part.order)
    poles = tuple(Pole(table(pole.real, rate), table(pole.imag, rate) if pole.imag else None) for pole in part.poles)
    return replace(part, gain=table(part.gain, gain), poles=poles)
