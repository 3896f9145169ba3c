"""What a board with thermocouples lacks for its rules and its model: allowed, but seldom meant."""

from __future__ import annotations

from gen.coefficients.alarms import AlarmRule, MissingHeat, ModelRule
from gen.coefficients.document import Document
from gen.coefficients.protecting import can_stop, watched_channels


def check_wiring(document: Document) -> tuple[str, ...]:
    """Warn of rules on parts that the board does not measure, and of an ambient that nobody tells it.

    A file without thermocouples is for a library in somebody's own sketch, which may have them from elsewhere: it is
    let pass.

    Returns
    -------
    tuple of str
        Warnings.
    """
    wired = document.wiring.thermocouples if document.wiring is not None else ()
    if not wired:
        return ()
    measured = {chip.channel for chip in wired}
    warnings = []
    for index, rule in enumerate(document.alarms):
        for key, part in _parts(rule):
            if part not in measured:
                warnings.append(
                    f'$.alarms[{index}].{key}: the rule "{rule.name}" is never raised, because "{part}" has no '
                    "thermocouple in $.wiring.thermocouples"
                )
    warnings += _stops(document)
    if "ambient" not in measured and document.ambient.fixed_degC is None:
        warnings.append(
            "$.ambient: no thermocouple measures the ambient, and there is no fixed_degC: the board takes 25 degC"
        )
    return tuple(warnings)


def _stops(document: Document) -> list[str]:
    """Stops that can never act, and a motor that nothing would stop."""
    if not can_stop(document.wiring):
        return [
            f'$.alarms[{index}].stop_motor: the rule "{rule.name}" stops nothing: $.wiring has neither "drive" nor '
            '"relay_pin"'
            for index, rule in enumerate(document.alarms)
            if rule.stop_motor
        ]
    if not watched_channels(document):
        return [
            "$.alarms: nothing stops this motor when it is too hot: no over_temperature rule that stops it watches a "
            "part with a thermocouple"
        ]
    return []


def _parts(rule: AlarmRule) -> list[tuple[str, str]]:
    """The parts without which a rule says nothing, each with the key that names it."""
    if isinstance(rule, MissingHeat) and rule.weights is not None:
        return [("weights", name) for name in rule.weights]
    other = rule.relative_to if isinstance(rule, ModelRule) else None
    return [("component", rule.component), *([] if other is None else [("relative_to", other)])]
