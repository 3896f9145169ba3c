"""Alarm rules: what the firmware compares, where in speed, and for how long."""

from __future__ import annotations

from fractions import Fraction
from math import ceil, floor
from typing import Annotated, Any, Literal

from pydantic import Discriminator, Field, Tag

from gen.coefficients.base import Celsius, Name, NotNegative, Part, Positive

Percent = Annotated[float, Field(allow_inf_nan=False, ge=0, le=100)]


class Rule(Part):
    """What all rules share."""

    name: Name
    description: str = ""
    note: Annotated[str, Field(description="Why the rule's numbers are what they are; goes to README and report.")] = ""
    component: Annotated[str, Field(description="The component whose temperature is watched.")]
    speed_percent: Annotated[
        tuple[Percent, Percent],
        Field(description="The rule is evaluated while |PWM| is in this range, in % of full scale."),
    ] = (0.0, 100.0)
    persistence_s: Annotated[
        NotNegative, Field(description="The condition must hold this long before the alarm is raised, in s.")
    ] = 0.0
    settle_s: Annotated[
        NotNegative, Field(description="The rule sleeps this long after PWM entered the speed range, in s.")
    ] = 0.0
    requires: Annotated[
        str | None, Field(description="The rule is evaluated only while this earlier rule's alarm is raised.")
    ] = None
    unless: Annotated[
        str | None,
        Field(
            description="The rule is not evaluated while this earlier rule's alarm is raised; where that rule is on "
            "missing heat, neither while it is unsettled, nor if it was when the alarm of `requires` came: its silence "
            "says nothing then."
        ),
    ] = None
    stop_motor: Annotated[
        bool | None,
        Field(
            description="The motor stops on this rule's alarm, until a command ends it. Without it an over-temperature "
            "of a driven motor does, and other rules do not. $.protection can say more."
        ),
    ] = None


class ModelRule(Rule):
    """A rule that compares the measured temperature with the model's."""

    beyond: Annotated[
        Literal["model", "error_band"],
        Field(
            description="What the threshold or slack is counted from: the model's temperature, or the end of the error "
            "band that provenance.error declares for the component at the present PWM."
        ),
    ] = "model"
    relative_to: Annotated[
        str | None,
        Field(
            description="Another component, whose own deviation (measured minus model) is subtracted first: what both "
            "share, such as a wrong ambient, cancels."
        ),
    ] = None


class Deviation(ModelRule):
    """Measured minus model beyond a threshold, upwards (above_model) or downwards (below_model)."""

    kind: Literal["above_model", "below_model"]
    threshold_K: NotNegative
    hysteresis_K: Annotated[
        NotNegative,
        Field(description="The alarm ends once the deviation is this much inside the threshold, in K."),
    ] = 0.0


class OverTemperature(Rule):
    """Measured temperature over a limit."""

    kind: Literal["over_temperature"]
    limit_degC: Celsius
    hysteresis_K: NotNegative = 0.0
    look_ahead: Annotated[
        bool,
        Field(
            description="What rises faster than noise counts as what it will soon be, and each kelvin over the limit "
            "shortens persistence_s; false: persistence_s holds however far over the limit the part is."
        ),
    ] = True


class Cusum(ModelRule):
    """The one-sided cumulated sum of (measured minus model minus slack), in K s, over a threshold."""

    kind: Literal["cusum"]
    direction: Literal["above", "below"] = "above"
    slack_K: NotNegative
    threshold_K_s: Positive


class Unsettled(Part):
    """How much heat a healthy motor's model may miss after a change of PWM and after a start, and how that fades."""

    per_change_K_per_h: Annotated[NotNegative, Field(description="At once after a change of PWM by full scale.")]
    at_start_K_per_h: Annotated[
        NotNegative,
        Field(description="At once after a start that only measured temperatures are known of (not cold, no copy)."),
    ]
    decay_s: Annotated[
        tuple[Positive, Positive], Field(description="Its time constant at rest and at full scale; rates go straight.")
    ]


class MissingHeat(Rule):
    """The cumulated sum of the heat that the model lacks since a while ago, over a threshold: a change, wherever it is.

    The heat is the slope of measured minus model, plus its level over the model's slowest time constant.
    """

    kind: Literal["missing_heat"]
    weights: Annotated[
        dict[str, Annotated[float, Field(allow_inf_nan=False)]] | None,
        Field(
            min_length=1,
            description="Weight of each component's missing heat; by itself that of the component alone. A negative "
            "one counts heat that is taken away.",
        ),
    ] = None
    slack_K_per_h: Annotated[
        Positive, Field(description="Heat beyond what was usual that is not counted, as a slope of temperature.")
    ]
    unknown_K_per_h: Annotated[
        NotNegative,
        Field(
            description="Further slack while nothing is learnt of what is usual, as after a start: what offsets of "
            "sensors within their tolerance look like."
        ),
    ] = 0.0
    threshold_K: Annotated[Positive, Field(description="The sum of the counted heat at which the alarm is raised.")]
    usual_s: Annotated[
        Positive, Field(description="Time constant with which missing heat becomes usual, and no change any more.")
    ] = 1800.0
    remembered_s: Annotated[
        Positive | None,
        Field(
            description="Time constant with which heat that was usual is forgotten: what comes back meanwhile, as "
            "after a draught or a pause of a load, is no change. By itself, at once."
        ),
    ] = None
    unsettled: Unsettled

    @property
    def weight_of(self) -> dict[str, float]:
        """Weights by component."""
        return {self.component: 1.0} if self.weights is None else dict(self.weights)


#: Weights of one rule's missing heat, taken together without their signs: the board's sums hold so much.
MOST_WEIGHT = 4.0

#: The board keeps a bit for each rule.
MOST_RULES = 16
#: Longest time that a rule can wait, in samples: the board counts in 16 bits.
MOST_SAMPLES = 65534

KINDS = ("above_model", "below_model", "over_temperature", "cusum", "missing_heat")


def _kind(data: Any) -> str | None:  # noqa: ANN401
    kind = data.get("kind") if isinstance(data, dict) else getattr(data, "kind", None)
    if kind in ("above_model", "below_model"):
        return "tag:deviation"
    return f"tag:{kind}" if isinstance(kind, str) and kind in KINDS else None


AlarmRule = Annotated[
    Annotated[Deviation, Tag("tag:deviation")]
    | Annotated[OverTemperature, Tag("tag:over_temperature")]
    | Annotated[Cusum, Tag("tag:cusum")]
    | Annotated[MissingHeat, Tag("tag:missing_heat")],
    Discriminator(_kind, custom_error_type="alarm", custom_error_message="not an alarm rule"),
]


def window_counts(rule: Rule, full_scale: int) -> range:
    """The |PWM| counts at which a rule is evaluated, empty if its speed range holds no whole count.

    Parameters
    ----------
    rule
        The rule.
    full_scale
        The count that is 100 %.
    """
    low, high = (Fraction(str(percent)) * full_scale / 100 for percent in rule.speed_percent)
    return range(ceil(low), floor(high) + 1)
