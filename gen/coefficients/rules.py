"""The rules file of `gen thresholds`: alarm rules as in the coefficient file, whose thresholds may be missing."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from pydantic import ValidationError

from gen.coefficients import jsontext
from gen.coefficients.alarms import MissingHeat, Unsettled
from gen.coefficients.base import listed
from gen.coefficients.messages import described
from gen.errors import InputError

LEAST_HOURS = 10.0
"""Without so many hours of healthy motor no rate of false alarms is told."""
_RULES = "alarms"
_TAKEN_OVER = ("name", "description", "wiring", "protection")
_THRESHOLDS = {
    "above_model": ("threshold_K", "threshold_K_s"),
    "below_model": ("threshold_K", "threshold_K_s"),
    "cusum": ("threshold_K", "threshold_K_s"),
    "over_temperature": ("limit_degC",),
    "missing_heat": ("threshold_K",),
}
"""By a rule's kind: what says that its author has chosen a threshold. A wrong one is refused with the finished file."""


_ANY_UNSETTLED = Unsettled(per_change_K_per_h=0.0, at_start_K_per_h=0.0, decay_s=(1.0, 1.0))


@dataclass(frozen=True)
class RuleDraft:
    """An alarm rule as its author wrote it; it is checked with the finished file.

    Attributes
    ----------
    written
        The rule's JSON.
    """

    written: Mapping[str, Any]

    @property
    def kind(self) -> object:
        """The rule's kind, None if it has none."""
        return self.written.get("kind")

    @property
    def name(self) -> str:
        """The rule's name, empty if it has none."""
        return str(self.written.get("name", ""))

    @property
    def component(self) -> str:
        """The component that is watched."""
        return str(self.written["component"])

    @property
    def relative_to(self) -> str | None:
        """The component whose deviation is subtracted."""
        other = self.written.get("relative_to")
        return None if other is None else str(other)

    @property
    def lacks_threshold(self) -> bool:
        """Whether the rule is of a known kind, and its author left the threshold open."""
        chosen = _THRESHOLDS.get(str(self.kind))
        return chosen is not None and not any(key in self.written for key in chosen)

    def says(self, key: str) -> bool:
        """Whether the rule's author has written so."""
        return key in self.written

    def as_heat(self) -> MissingHeat:
        """Read a rule on missing heat; numbers that its author left open are anything.

        Raises
        ------
        InputError
            With what is wrong with the rest.
        """
        anything = {"slack_K_per_h": 1.0, "threshold_K": 1.0, "unsettled": _ANY_UNSETTLED.model_dump()}
        try:
            return MissingHeat.model_validate(anything | dict(self.written))
        except ValidationError as error:
            first = error.errors()[0]
            raise InputError(f"{'.'.join(map(str, first['loc']))}: {first['msg']}") from error

    def completed(
        self,
        *,
        note: str,
        beyond: Literal["model", "error_band"] | None = None,
        slack_K: float | None = None,
        threshold_K: float | None = None,
        threshold_K_s: float | None = None,
        limit_degC: float | None = None,
        hysteresis_K: float | None = None,
        slack_K_per_h: float | None = None,
        unknown_K_per_h: float | None = None,
        unsettled: Unsettled | None = None,
    ) -> RuleDraft:
        """Give the rule with what its author left open; what is written stays, and None adds nothing."""
        found = {
            "beyond": beyond,
            "slack_K": slack_K,
            "threshold_K": threshold_K,
            "threshold_K_s": threshold_K_s,
            "limit_degC": limit_degC,
            "hysteresis_K": hysteresis_K,
            "slack_K_per_h": slack_K_per_h,
            "unknown_K_per_h": unknown_K_per_h,
            "unsettled": None if unsettled is None else unsettled.model_dump(mode="json"),
            "note": note,
        }
        added = {key: value for key, value in found.items() if value is not None and key not in self.written}
        return RuleDraft({**self.written, **added})


def drafted(
    name: str,
    kind: Literal["above_model", "over_temperature", "missing_heat"],
    component: str,
    description: str,
    *,
    speed_percent: tuple[float, float] | None = None,
    persistence_s: float | None = None,
    settle_s: float | None = None,
    note: str | None = None,
    beyond: Literal["model", "error_band"] | None = None,
    threshold_K: float | None = None,
    limit_degC: float | None = None,
    hysteresis_K: float | None = None,
    weights: Mapping[str, float] | None = None,
    remembered_s: float | None = None,
) -> RuleDraft:
    """Write a rule anew; what is None is left open."""
    written: dict[str, Any] = {"name": name, "description": description, "kind": kind, "component": component}
    further = {
        "weights": None if weights is None else dict(weights),
        "remembered_s": remembered_s,
        "speed_percent": None if speed_percent is None else list(speed_percent),
        "persistence_s": persistence_s,
        "settle_s": settle_s,
        "beyond": beyond,
        "threshold_K": threshold_K,
        "limit_degC": limit_degC,
        "hysteresis_K": hysteresis_K,
        "note": note,
    }
    return RuleDraft(written | {key: value for key, value in further.items() if value is not None})


@dataclass(frozen=True)
class Rules:
    """A rules file.

    Attributes
    ----------
    alarms
        Its rules.
    taken_over
        What else it has for the coefficient file, as JSON: name, description, wiring, protection.
    """

    alarms: tuple[RuleDraft, ...]
    taken_over: Mapping[str, Any]


def read_rules(path: Path, components: Sequence[str]) -> Rules:
    """Read a rules file as far as thresholds are derived from it; the rest is checked with the finished file.

    Parameters
    ----------
    path
        The JSON file.
    components
        Names of the model's components.

    Raises
    ------
    InputError
        With the file, the JSON path (or line and column), what was found and what was expected.
    """
    try:
        tree = jsontext.parse(path.read_text(encoding="utf-8"))
        return _checked(tree, components)
    except (OSError, UnicodeDecodeError) as error:
        reason = error.strerror if isinstance(error, OSError) else "it is not UTF-8"
        raise InputError(f"cannot be read: {reason}", file=str(path)) from error
    except InputError as error:
        raise InputError(error.message, file=str(path), place=error.place) from error


def _checked(tree: object, components: Sequence[str]) -> Rules:
    if not isinstance(tree, dict) or not isinstance(tree.get(_RULES), list):
        raise InputError(f'expected an object with "{_RULES}", a list of rules', place="$")
    for key in tree:
        if key not in (_RULES, *_TAKEN_OVER):
            raise InputError(f'unknown key "{key}"; expected {listed([_RULES, *_TAKEN_OVER])}', place="$")
    if not all(isinstance(rule, dict) for rule in tree[_RULES]):
        raise InputError("expected a list of objects", place=f"$.{_RULES}")
    for number, rule in enumerate(tree[_RULES]):
        for key, name in _named(rule):
            if name not in components:
                found = "" if name is None else f"found {described(name)}, "
                raise InputError(
                    f"{found}expected the name of a component: {listed(list(components))}",
                    place=f"$.{_RULES}[{number}].{key}",
                )
    taken_over = {key: tree[key] for key in _TAKEN_OVER if key in tree}
    return Rules(tuple(RuleDraft(rule) for rule in tree[_RULES]), taken_over)


def _named(rule: Mapping[str, Any]) -> list[tuple[str, object]]:
    """The components that a rule names, by the key that names them."""
    other, weights = rule.get("relative_to"), rule.get("weights")
    found: list[tuple[str, object]] = [("component", rule.get("component"))]
    found += [("relative_to", other)] if other is not None else []
    return found + ([("weights", name) for name in weights] if isinstance(weights, dict) else [])
