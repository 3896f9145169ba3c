"""Fill the templates: a mapping from the emitted path to its text."""

from __future__ import annotations

from collections.abc import Mapping

from gen.firmware.context import LibraryContext, Names
from gen.lowering.kinds import Arithmetic
from gen.templating import environment

# Emitted path -> template, for what the model's library consists of. NAME stands for the model's name.
_MODEL = {
    "lib/NAME/src/NAME.h": "lib/model/src/model.h.j2",
    "lib/NAME/src/NAME_model.h": "lib/model/src/model_state.h.j2",
    "lib/NAME/src/NAME_platform.h": "lib/model/src/platform.h.j2",
}
_ALARMS = {
    "lib/NAME/src/NAME_alarms.h": "lib/model/src/alarms.h.j2",
    "lib/NAME/src/NAME_alarms.cpp": "lib/model/src/alarms.cpp.j2",
    "lib/NAME/src/NAME_alarms_state.h": "lib/model/src/alarms_state.h.j2",
}
_HEAT = {
    "lib/NAME/src/NAME_heat.h": "lib/model/src/heat.h.j2",
    "lib/NAME/src/NAME_heat.cpp": "lib/model/src/heat.cpp.j2",
}
_PROTECTION = {
    "lib/NAME/src/NAME_protection.h": "lib/model/src/protection.h.j2",
    "lib/NAME/src/NAME_protection.cpp": "lib/model/src/protection.cpp.j2",
}
_FORECAST = {
    "lib/NAME/src/NAME_forecast.h": "lib/model/src/forecast.h.j2",
    "lib/NAME/src/NAME_forecast.cpp": "lib/model/src/forecast.cpp.j2",
}
_BODY: Mapping[Arithmetic, Mapping[str, str]] = {
    "fixed": {"lib/NAME/src/NAME.cpp": "lib/model/src/model_fixed.cpp.j2"},
    "float": {"lib/NAME/src/NAME.cpp": "lib/model/src/model_float.cpp.j2"},
}
_ACCUMULATOR = {
    "lib/NAME/src/NAME_accumulator.h": "lib/model/src/accumulator.h.j2",
    "lib/NAME/src/NAME_accumulator.cpp": "lib/model/src/accumulator.cpp.j2",
}
_RECURSION: Mapping[Arithmetic, Mapping[str, str]] = {
    "fixed": {
        "lib/NAME/src/NAME_word.h": "lib/model/src/word.h.j2",
        "lib/NAME/src/NAME_step.h": "lib/model/src/step_fixed.h.j2",
    },
    "float": {
        **_ACCUMULATOR,
        "lib/NAME/src/NAME_step.h": "lib/model/src/step_float.h.j2",
    },
}
_TABLE: Mapping[Arithmetic, Mapping[str, str]] = {
    "fixed": {"lib/NAME/src/NAME_schedule.cpp": "lib/model/src/schedule_table.cpp.j2"},
    "float": {"lib/NAME/src/NAME_schedule.cpp": "lib/model/src/schedule_table_float.cpp.j2"},
}
_ONBOARD = {
    "lib/NAME/src/NAME_schedule.cpp": "lib/model/src/schedule_onboard.cpp.j2",
    "lib/NAME/src/NAME_onboard_math.h": "lib/model/src/onboard_math.h.j2",
}
_EFFECTS = {
    "lib/NAME/src/NAME_effects.h": "lib/model/src/effects.h.j2",
    "lib/NAME/src/NAME_effects.cpp": "lib/model/src/effects.cpp.j2",
}
_NETWORK = {
    "lib/NAME/src/NAME.h": "lib/model/src/model.h.j2",
    "lib/NAME/src/NAME_model.h": "lib/model/src/network_state.h.j2",
    "lib/NAME/src/NAME_platform.h": "lib/model/src/platform.h.j2",
    "lib/NAME/src/NAME.cpp": "lib/model/src/network.cpp.j2",
    "lib/NAME/src/NAME_step.h": "lib/model/src/network_step.h.j2",
    "lib/NAME/src/NAME_sum.h": "lib/model/src/network_sum.h.j2",
    "lib/NAME/src/NAME_step.cpp": "lib/model/src/network_advance.cpp.j2",
    "lib/NAME/src/NAME_schedule.h": "lib/model/src/network_schedule.h.j2",
    "lib/NAME/src/NAME_schedule.cpp": "lib/model/src/network_schedule.cpp.j2",
}
#: Templates that control every line break themselves, with {%- and -%}.
_OWN_LINE_BREAKS = ("lib/model/src/onboard_math.h.j2",)


def render(templates: Mapping[str, str], names: Names) -> dict[str, str]:
    """Render each template under its emitted path; a name that is not among `names` is an error."""
    return {
        path.replace("NAME", str(names["name"])): environment("project", own_line_breaks=template in _OWN_LINE_BREAKS)
        .get_template(template)
        .render(names)
        for path, template in templates.items()
    }


def library(context: LibraryContext) -> dict[str, str]:
    """The model's library for the context's arithmetic and schedule."""
    arithmetic = context.identity["arithmetic"]
    if context.network is not None:
        files = _NETWORK | (_ACCUMULATOR if arithmetic == "float" else {})
        return render(files, context.of_model()) | _alarms(context)
    schedule = _ONBOARD if context.identity["schedule"] == "onboard" else _TABLE[arithmetic]
    return (
        render(_MODEL, context.of_model())
        | render(_BODY[arithmetic], context.of_model())
        | _alarms(context)
        | render(_RECURSION[arithmetic], context.of_model())
        | render(schedule, context.of_schedule())
        | (render(_EFFECTS, context.of_effects()) if context.effects is not None else {})
    )


def _alarms(context: LibraryContext) -> dict[str, str]:
    """The rules, the sums of missing heat where a rule is on them, and what else a file asks for."""
    files = _ALARMS | (_HEAT if context.alarms["heat_rules"] else {})
    files |= _PROTECTION if context.protects else {}
    files |= _FORECAST if context.forecast is not None else {}
    return render(files, context.of_alarms())
