"""What the certificate says of a schedule holds at every |PWM|."""

from __future__ import annotations

import pytest

from gen.firmware.certificate import _schedule
from gen.model import Table


@pytest.mark.parametrize("first", [0, 1, 2, 50])
def test_a_table_is_held_before_its_first_and_behind_its_last_entry(first: int) -> None:
    pieces = _schedule(Table((first, 100, 200), (2.0, 3.0, 7.0), "linear"))["pieces"]
    assert [low for low, _, _ in pieces[1:]] == [high + 1 for _, high, _ in pieces[:-1]]
    assert pieces[-1] == [200, 255, [7.0]]
    assert pieces[0] == [0, first - 1, [2.0]] if first else pieces[0][0] == 0
