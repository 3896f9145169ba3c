"""Effects in the coefficient document: what `gen refine` added to the baseline."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import ConfigDict, Field, ValidationError, model_validator

from gen.coefficients.base import Part, fault, listed
from gen.model.effects import Applied, registry


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
        try:
            self._validated()
        except ValidationError as error:
            first = error.errors(include_url=False)[0]
            raise fault(f"{self.name}: {first['msg']}", "parameters", *first["loc"]) from None
        return self

    def _validated(self) -> dict[str, Any]:
        return registry()[self.name].parameters.model_validate(self.parameters).model_dump()

    def applied(self) -> Applied:
        """Give the effect with its parameters."""
        return Applied(registry()[self.name], self.component, self._validated())
