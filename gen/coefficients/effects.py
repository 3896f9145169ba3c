"""Effects in the coefficient document: what `gen refine` added to the baseline."""

from __future__ import annotations

import json
import re
from collections.abc import Sequence
from typing import Annotated, Any

from pydantic import ConfigDict, Field, ValidationError, model_validator

from gen.coefficients.base import Part, fault, listed
from gen.coefficients.messages import explained
from gen.model.effects import Applied, registry

_COLUMN = re.compile(r'[^\x00-\x1f\x7f,;"\\]{1,64}')


def _schema(schema: dict[str, Any]) -> None:
    """Say in the published schema which parameters each effect has."""
    choices = []
    for effect in registry().values():
        parameters = effect.parameters.model_json_schema()
        parameters["description"] = f"{effect.title}: {effect.equation}"
        choices.append({"properties": {"name": {"const": effect.name}, "parameters": parameters}})
    schema["oneOf"] = choices


class EffectEntry(Part):
    """A named effect at a component, beside the baseline's schedules."""

    model_config = ConfigDict(strict=True, extra="forbid", frozen=True, json_schema_extra=_schema)

    name: Annotated[str, Field(description="Name of the effect.")]
    component: Annotated[str, Field(description="The component that it acts on.")]
    parameters: Annotated[dict[str, Any], Field(description="By name, units in the names.")]
    evidence: Annotated[
        dict[str, Any],
        Field(description="What speaks for it: errors on left-out runs, p-value, intervals, look-alikes."),
    ] = Field(default_factory=dict)

    @model_validator(mode="after")
    def _check(self) -> EffectEntry:
        if self.name not in registry():
            raise fault(f'found "{self.name}", expected the name of an effect: {listed(list(registry()))}', "name")
        unknown = [key for key in self.parameters if key not in registry()[self.name].parameters.model_fields]
        if unknown:
            known = listed(list(registry()[self.name].parameters.model_fields))
            raise fault(f'unknown parameter "{unknown[0]}" of {self.name}; expected {known}', "parameters", unknown[0])
        try:
            values = self._validated()
        except ValidationError as error:
            message, place = explained(error)
            raise fault(message, "parameters", *place) from None
        for source, name in registry()[self.name].reads(values):
            _check_column(name, "parameters", source.parameter)
        return self

    def _validated(self) -> dict[str, Any]:
        # As JSON: strict validation of Python objects would take no list for a tuple.
        parameters = registry()[self.name].parameters
        return parameters.model_validate_json(json.dumps(self.parameters), strict=True).model_dump()

    def without_evidence(self) -> tuple[str, str, dict[str, Any]]:
        """Give what the effect does, without what speaks for it."""
        return self.name, self.component, self._validated()

    def applied(self) -> Applied:
        """Give the effect with its parameters."""
        return Applied(registry()[self.name], self.component, self._validated())


def check_effects(effects: Sequence[EffectEntry], components: list[str]) -> None:
    """Check what effects say of components and of each other.

    Parameters
    ----------
    effects
        The document's effects.
    components
        Names of its components.

    Raises
    ------
    PydanticCustomError
        For an unknown component, heat from a part to itself or from nowhere, or an effect that is there twice.
    """
    for i, effect in enumerate(effects):
        if effect.component not in components:
            raise fault(
                f'found "{effect.component}", expected the name of a component: {listed(components)}',
                *("effects", i, "component"),
            )
        others = [name for name in components if name != effect.component]
        applied = effect.applied()
        for source, name in applied.effect.reads(applied.values, "component"):
            if name not in others and not source.fits(name):
                raise fault(
                    f'found "{name}", expected {_expected(others, source.units)}',
                    *("effects", i, "parameters", source.parameter),
                )
        if effect.without_evidence() in [earlier.without_evidence() for earlier in effects[:i]]:
            raise fault("this effect is there already, with the same parameters; expected it once", "effects", i)


def _expected(others: list[str], units: Sequence[str]) -> str:
    component = f"the name of another component ({listed(others)})" if others else ""
    column = f"a column that ends in {listed(list(units))}" if units else ""
    return " or ".join(text for text in (component, column) if text) or "another component, of which there is none"


def _check_column(name: str, *at: str) -> None:
    """A run file's column by its name: what stands in its header, and in comments of the C++."""
    if name in ("time_s", "pwm"):
        raise fault(f'"{name}" is every run file\'s own; expected another column', *at)
    if not _COLUMN.fullmatch(name) or name != name.strip():
        raise fault(f"{json.dumps(name)} cannot be the name of a run file's column; expected another", *at)
