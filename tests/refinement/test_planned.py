"""What a planned run was to decide, and whether it did."""

from __future__ import annotations

import pytest

from gen.refinement.network.planned import Settled


@pytest.mark.parametrize(
    ("remains", "told", "sentence"),
    [
        (("radiation",), True, "it did, by 2.0, radiation remains"),
        ((), True, "it did, by 2.0, neither remains"),
        (("radiation", "coupling"), False, "it did not, by 2.0, both remain"),
        (None, None, "what was found before is found no more, so that is no question now"),
    ],
)
def test_what_nobody_asked_is_not_decided(remains: tuple[str, ...] | None, told: bool | None, sentence: str) -> None:
    one = Settled("monday", "radiation", "coupling", 3.0, 2.0, remains)
    assert one.told is told
    assert one.sentence.endswith(sentence)
    assert one.summary()["told"] is told
