"""A relay's column of ON and OFF as the input, and what is asked of a log that says nothing of itself."""

from __future__ import annotations

from pathlib import Path
from typing import Literal

import numpy as np
import pytest

from gen.errors import InputError
from gen.runs import read_run
from tests.importing.logs import take, write

ROWS = 120
HEATED = np.arange(ROWS) % 40 < 25
TEMPERATURE = 21.0 + np.cumsum(np.where(HEATED, 0.3, -0.2))


def log(words: tuple[str, str], name: str = "Heater") -> str:
    rows = [
        f"{5 * k},{t:.1f},{words[0] if on else words[1]}"
        for k, (t, on) in enumerate(zip(TEMPERATURE.tolist(), HEATED.tolist(), strict=True))
    ]
    return "\n".join([f"time_s,Plate (C),{name}", *rows])


@pytest.mark.parametrize("words", [("ON", "OFF"), ("true", "false"), ("Ein", "Aus"), ("1", "0"), ("Marche", "Arrêt")])
def test_on_is_all_of_it_and_off_is_nothing(words: tuple[str, str], tmp_path: Path) -> None:
    path = write(tmp_path, log(words))
    with pytest.raises(InputError, match=r"expected what drives it, such as --input Heater$"):
        take(path, tmp_path / "out")
    take(path, tmp_path / "out", input="Heater")
    run = read_run(next((tmp_path / "out").glob("*.csv")))
    assert run.pwm.tolist() == np.where(HEATED, 255, 0).tolist()


@pytest.mark.parametrize("drives", ["", "motor", "heater"])
def test_what_it_drives_stands_in_run_files_and_in_the_mapping(
    drives: Literal["", "motor", "heater"], tmp_path: Path
) -> None:
    path, out, mapping = write(tmp_path, log(("255", "0"))), tmp_path / "out", tmp_path / "map.toml"
    found = take(path, out, input="Heater", full_scale=255.0, drives=drives, mapping=mapping)
    assert read_run(found.runs[0]).comments.get("drives", "") == drives
    assert (f", of a {drives}" in str(found.guesses().loc["Heater", "taken"])) == bool(drives)
    take(path, tmp_path / "again", mapping=mapping)
    assert read_run(next((tmp_path / "again").glob("*.csv"))).comments.get("drives", "") == drives
    with pytest.raises(InputError, match="--drives: the mapping file exists and says it"):
        take(path, tmp_path / "twice", mapping=mapping, drives="heater")


def test_it_is_counted(tmp_path: Path) -> None:
    found = take(write(tmp_path, log(("ON", "OFF"))), tmp_path / "out", input="Heater")
    assert found.counted()["count"]["on or off of Heater, taken for 1 or 0"] == ROWS


@pytest.mark.parametrize("words", [("CW", "CCW"), ("forward", "reverse"), ("Rechts", "Links"), ("fwd", "rev")])
def test_words_of_a_direction_give_the_input_its_sign(words: tuple[str, str], tmp_path: Path) -> None:
    rows = [f"{5 * k},{t:.1f},120,{words[k > 9]}" for k, t in enumerate(TEMPERATURE.tolist())]
    found = take(write(tmp_path, "\n".join(["time_s,Plate (C),PWM,direction", *rows])), tmp_path / "out")
    assert found.counted()["count"]["direction of direction, taken for 1 or -1"] == ROWS
    assert read_run(found.runs[0]).pwm.tolist() == [120] * 10 + [-120] * (ROWS - 10)


def test_other_words_stay_words(tmp_path: Path) -> None:
    path = write(tmp_path, log(("ON", "fault")))
    with pytest.raises(InputError, match="holds text, expected numbers"):
        take(path, tmp_path / "out", input="Heater")


@pytest.mark.parametrize(
    "words", [("heater on", "heater off"), ("HEATER_ON", "HEATER_OFF"), ("Heizung: ein", "Heizung: aus")]
)
def test_what_stands_before_on_and_off_alike_says_nothing(words: tuple[str, str], tmp_path: Path) -> None:
    path = write(tmp_path, log(words, "state"))
    with pytest.raises(InputError, match=r"expected --input state, or --input COLUMN"):
        take(path, tmp_path / "out")
    found = take(path, tmp_path / "out", input="state")
    assert read_run(found.runs[0]).pwm.tolist() == np.where(HEATED, 255, 0).tolist()


@pytest.mark.parametrize("words", [("HEATING", "IDLE", "COOLING"), ("motor runs", "motor stopped", "motor waits")])
def test_a_state_that_says_so_is_on_and_the_others_are_off(words: tuple[str, str, str], tmp_path: Path) -> None:
    """Where that is asked for; the mapping says it of further logs."""
    path = write(tmp_path, log(words[:2], "state").replace(words[1], words[2]).replace(words[2], words[1], 7))
    with pytest.raises(InputError, match=rf"expected --input state \(on: {words[0]}; off: {words[1]}, {words[2]}\)"):
        take(path, tmp_path / "out")
    mapping = tmp_path / "map.toml"
    found = take(path, tmp_path / "out", input="state", mapping=mapping)
    assert read_run(found.runs[0]).pwm.tolist() == np.where(HEATED, 255, 0).tolist()
    assert any(what.startswith(f"state of state: {words[0]} taken for 1, ") for what in found.counted().index)
    assert take(path, tmp_path / "again", mapping=mapping).runs[0].read_bytes() == found.runs[0].read_bytes()


@pytest.mark.parametrize(
    "words", [("HEATING", "HOLDING"), ("HEATING", "RUNNING"), ("HEATING", "FAULT"), ("phase 1", "phase 2")]
)
def test_states_that_do_not_say_it_stay_words(words: tuple[str, str], tmp_path: Path) -> None:
    path = write(tmp_path, log(words, "state"))
    with pytest.raises(InputError, match=r"no column is a motor's PWM among Plate"):
        take(path, tmp_path / "out")
    with pytest.raises(InputError, match="holds text, expected numbers"):
        take(path, tmp_path / "out", input="state")


def test_a_log_without_names_is_asked_of_input_and_parts_at_once(tmp_path: Path) -> None:
    rows = [f"{5 * k},{t:.2f},{120 if on else 0}" for k, (t, on) in enumerate(zip(TEMPERATURE, HEATED, strict=True))]
    with pytest.raises(InputError) as caught:
        take(write(tmp_path, "\n".join(rows)), tmp_path / "out")
    assert "no column is a motor's PWM among column_2 (" in str(caught.value)
    assert "and no column is a part's temperature; expected --column OLD=NAME_degC, such as" in str(caught.value)
