"""What is the same effect at motors that each have candidates of their own."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from gen.errors import CheckFailed
from gen.fleet.shared_effects import key_of, variants


def candidate(name: str, component: str, begins: float, *, held: bool = False) -> Any:  # noqa: ANN401
    return SimpleNamespace(name=name, component=component, acts_by={}, held_by_the_file=held, begins=begins)


def test_candidates_that_begin_elsewhere_are_one_effect() -> None:
    every = [
        candidate("hidden_node", "brush", 1.0),
        candidate("sensor_gain", "brush", 2.0),
        candidate("hidden_node", "casing", 3.0),
        candidate("hidden_node", "brush", 4.0),
        candidate("hidden_node", "brush", 5.0, held=True),
    ]
    assert variants(every, key_of(every[0])) == [every[0], every[3]]
    with pytest.raises(CheckFailed, match="cannot act on this motor"):
        variants(every[1:3], key_of(every[0]))
