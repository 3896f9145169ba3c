"""Heat from another part, modelled or measured."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, ClassVar

from pydantic import Field

from gen.model.effects.base import Effect, Free, Input, Lanes, Moment, Parameters, Setting, Tau, Values, Variant


class CouplingParameters(Parameters):
    """Parameters."""

    source: Annotated[str, Field(description="A component of the model, or a column (degC, or % and W of a heater).")]
    conductance_per_s: Annotated[
        float, Field(ge=0.0, le=0.1, description="Heating k for each unit of the source, in 1/s (degC) or K/s.")
    ]
    exchange: Annotated[
        bool, Field(description="The source's temperature minus the own one drives; else the source's rise alone.")
    ] = True
    tau_s: Tau = None


class Coupling(Effect):
    """Heat exchanged with a part beside it, or made by a heater that the model does not have."""

    name = "coupling"
    title = "heat exchanged with another part"
    equation = "E' = k (T_source - T) - rate E,  or k source - rate E"
    parameters = CouplingParameters
    inputs = (Input("source", of="component", units=("_degC", "_percent", "_pct", "_W")),)
    tau = "tau_s"
    signature = "the residual follows another part's temperature with the delay of the own thermal mass"
    lookalikes: ClassVar[Mapping[str, str]] = {
        "hidden_node": "heat the two parts apart from each other: log a run in which only the other part is warm",
        "ambient": "hold the ambient constant for 2 h while the other part warms",
        "radiation": "reach the same own temperature with the other part cold and warm",
    }

    def variants(self, setting: Setting) -> list[Variant]:  # noqa: D102
        made = []
        free = Free("conductance_per_s", 0.1 * setting.rate, 0.0, 0.1)
        for source in (*setting.others, *setting.ending("_degC")):
            made.append(Variant({"source": source, "exchange": True, "tau_s": None}, (free,)))
            made.append(Variant({"source": source, "exchange": False, "tau_s": None}, (free,)))
        for source in setting.ending("_percent", "_W", "_pct"):
            made.append(Variant({"source": source, "exchange": False, "tau_s": None}, (free,)))
        return made

    def heat(self, p: Values, m: Moment) -> Lanes:  # noqa: D102
        source = p["source"]
        if source in m.others:
            return p["conductance_per_s"] * m.others[source]
        if source.endswith("_degC"):
            return p["conductance_per_s"] * (m.channels[source] - m.ambient)
        return p["conductance_per_s"] * m.channels[source]

    def per_rise(self, p: Values, m: Moment) -> Lanes:  # noqa: D102
        return -p["conductance_per_s"] if p["exchange"] else 0.0
