"""What a run file's comments say of the motor's health: ``fault: bearing``, ``motor_fault: brush``, ``healthy: no``."""

from __future__ import annotations

from collections.abc import Mapping

_NONE = {"", "none", "no", "healthy", "0", "false", "-"}
_NOT = {"no", "false", "0"}


def declared_faults(comments: Mapping[str, str]) -> list[str]:
    """Give the faults that comments name, in their order: by ``fault``, or by any key that ends with ``_fault``."""
    named = (value.strip() for key, value in comments.items() if key == "fault" or key.endswith("_fault"))
    return [fault for fault in named if fault.lower() not in _NONE]


def called_unhealthy(comments: Mapping[str, str]) -> bool:
    """Whether comments say that the motor is not healthy, without a fault's name."""
    return comments.get("healthy", "yes").strip().lower() in _NOT
