"""Which way a motor turns, by a column beside its PWM; and words that say that it is off."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from gen.errors import InputError
from gen.runs import read_run
from tests.importing.logs import TRUE, csv, take, taken, write

DRIVEN = TRUE.assign(pwm=np.where(TRUE.index % 40 < 25, 153, 0))
BACK = (TRUE.index // 40 == 1) & (DRIVEN.pwm > 0)


def with_way(name: str, forwards: object, backwards: object, still: object) -> pd.DataFrame:
    """A log with a direction."""
    way = np.where(BACK, backwards, np.where(DRIVEN.pwm > 0, forwards, still))  # type: ignore[call-overload]
    return DRIVEN.assign(**{name: way})


@pytest.mark.parametrize(
    ("name", "forwards", "backwards", "still"),
    [
        ("Direction", "F", "R", "F"),
        ("Dir", "FWD", "REV", "STOP"),
        ("Direction", "right", "left", "brake"),
        ("direction", "+", "-", "+"),
        ("State", "FORWARD", "REVERSE", "IDLE"),
        ("Rotation", "CW", "CCW", "CW"),
        ("direction", 1, -1, 0),
        ("reverse", 0, 1, 0),
        ("reversed", "false", "true", "false"),
    ],
)
def test_a_direction_turns_the_sign(
    name: str, forwards: object, backwards: object, still: object, tmp_path: Path
) -> None:
    run = taken(write(tmp_path, csv(with_way(name, forwards, backwards, still))), tmp_path / "out")
    np.testing.assert_array_equal(run.pwm, np.where(BACK, -DRIVEN.pwm, DRIVEN.pwm))


@pytest.mark.parametrize(("low", "high"), [(0, 1), (1, 2)])
def test_which_of_two_numbers_is_backwards_is_asked_and_kept_in_the_mapping(
    low: int, high: int, tmp_path: Path
) -> None:
    log = write(tmp_path, csv(with_way("Direction", high, low, low)))
    with pytest.raises(InputError, match=rf"holds {low} and {high} where the motor is driven; expected --unit Direc"):
        take(log, tmp_path / "asked")
    signed = np.where(BACK, -DRIVEN.pwm, DRIVEN.pwm)
    mapping = tmp_path / "map.toml"
    found = take(log, tmp_path / "forward", units={"Direction": "forward"}, mapping=mapping)
    np.testing.assert_array_equal(read_run(found.runs[0]).pwm, signed)
    np.testing.assert_array_equal(taken(log, tmp_path / "again", mapping=mapping).pwm, signed)
    turned = taken(log, tmp_path / "reverse", units={"Direction": "reverse"})
    np.testing.assert_array_equal(turned.pwm, -signed)
    left = taken(log, tmp_path / "left", columns={"Direction": ""})
    np.testing.assert_array_equal(left.pwm, DRIVEN.pwm)


@pytest.mark.parametrize("name", ["Direction", "Valve direction"])
def test_a_direction_is_not_applied_twice_nor_another_thing_s(name: str, tmp_path: Path) -> None:
    frame = with_way(name, 1, -1, 1)
    if name == "Direction":
        frame["pwm"] = np.where(BACK, -frame.pwm, frame.pwm)
    np.testing.assert_array_equal(taken(write(tmp_path, csv(frame)), tmp_path / "out").pwm, frame.pwm)


def test_a_direction_that_changes_at_rest_alone_is_not_asked_for(tmp_path: Path) -> None:
    log = write(tmp_path, csv(DRIVEN.assign(direction=np.where(DRIVEN.pwm > 0, 1, 0))))
    np.testing.assert_array_equal(taken(log, tmp_path / "out").pwm, DRIVEN.pwm)


@pytest.mark.parametrize("word", ["OFF", "off", "false", "standby", "Stop"])
def test_a_word_for_off_among_an_input_s_numbers_is_0(word: str, tmp_path: Path) -> None:
    shown = np.where(DRIVEN.pwm > 0, DRIVEN.pwm.astype(str), word)
    found = take(write(tmp_path, csv(DRIVEN.assign(pwm=shown))), tmp_path / "out")
    np.testing.assert_array_equal(read_run(found.runs[0]).pwm, DRIVEN.pwm)
    assert found.counted()["count"]["word for off in pwm, taken for 0"] == (DRIVEN.pwm == 0).sum()


def test_an_input_that_is_often_no_number_is_refused_and_now_and_then_held(tmp_path: Path) -> None:
    odd = np.where(DRIVEN.pwm > 0, DRIVEN.pwm.astype(str), "<1")
    with pytest.raises(InputError, match='found "<1", and no number in 45 of 120 rows'):
        take(write(tmp_path, csv(DRIVEN.assign(pwm=odd))), tmp_path / "often")
    few = DRIVEN.pwm.astype(str).where(TRUE.index % 60 != 10, "1#3")
    found = take(write(tmp_path, csv(DRIVEN.assign(pwm=few))), tmp_path / "few")
    np.testing.assert_array_equal(read_run(found.runs[0]).pwm, DRIVEN.pwm)


def test_an_input_that_is_empty_where_it_may_be_off_is_told(tmp_path: Path) -> None:
    empty = DRIVEN.assign(pwm=np.where(DRIVEN.pwm > 0, DRIVEN.pwm.astype(str), ""))
    found = take(write(tmp_path, csv(empty)), tmp_path / "out")
    (said,) = found.warnings
    assert "45 of 120 rows have none, and no row has 0: the last one is held" in said
    changes = DRIVEN.assign(pwm=DRIVEN.pwm.astype(str).where(DRIVEN.pwm.diff() != 0, ""))  # as of a log of changes
    found = take(write(tmp_path, csv(changes)), tmp_path / "changes")
    assert found.warnings == []
    np.testing.assert_array_equal(read_run(found.runs[0]).pwm, DRIVEN.pwm)


@pytest.mark.parametrize("name", ["Enable", "output", "Relay"])
def test_a_switch_beside_an_input_that_stays_is_told(name: str, tmp_path: Path) -> None:
    on = (DRIVEN.pwm > 0).astype(int)
    found = take(write(tmp_path, csv(DRIVEN.assign(pwm=153, **{name: on}))), tmp_path / "out")
    (said,) = found.warnings
    assert f"{name}: is 0 in 45 rows in which pwm is not; if it switches the motor" in said
    assert take(write(tmp_path, csv(DRIVEN.assign(**{name: on}))), tmp_path / "follows").warnings == []
