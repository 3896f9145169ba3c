"""From the document to the model."""

from __future__ import annotations

from gen.coefficients.base import told
from gen.coefficients.document import ComponentEntry, Document
from gen.model.dynamics import Component, Pole, ThermalModel
from gen.model.network import Network


def to_model(document: Document) -> ThermalModel:
    """Build the thermal model that a document describes.

    Parameters
    ----------
    document
        A validated document.
    """
    fixed = document.ambient.fixed_degC
    return ThermalModel(
        name=document.name,
        sample_time=document.sample_time_s,
        full_scale=document.input.full_scale,
        validity=document.validity.pwm,
        outside=document.validity.outside,
        domain_pwm=document.domain.pwm,
        domain_ambient=(told(document.domain.ambient_degC[0]), told(document.domain.ambient_degC[1])),
        domain_temperature=document.domain.temperature_degC,
        ambient_fixed=None if fixed is None else told(fixed),
        ambient_channel=document.ambient.channel,
        components=tuple(_component(entry, document) for entry in document.components),
        network=_network(document),
        ambient_at_once=_at_once(document),
    )


def _at_once(document: Document) -> bool:
    """Whether components follow the ambient at once: an effect that brings the measured one says itself how it acts."""
    brought = any(entry.applied().effect.replaces_ambient for entry in document.effects)
    return brought or bool(document.ambient.at_once)


def _network(document: Document) -> Network | None:
    if document.network is None:
        return None
    held = document.validity.pwm if document.validity.outside == "hold" else None
    return document.network.network(held, document.input.full_scale)


def _component(entry: ComponentEntry, document: Document) -> Component:
    return Component(
        name=entry.name,
        order=entry.order,
        gain=entry.gain.schedule(),
        poles=tuple(Pole(pole.real.schedule(), pole.imag.schedule() if pole.imag else None) for pole in entry.poles),
        validity=document.validity.pwm,
        outside=document.validity.outside,
        negative_gain=entry.negative_gain,
        description=entry.description,
    )
