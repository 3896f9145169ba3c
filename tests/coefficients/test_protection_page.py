"""docs/protection.md: its example, its tables of causes, keys and actions, its defaults."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any, get_args

from gen.coefficients import parse
from gen.coefficients.forecast import Forecast
from gen.coefficients.protecting import protections
from gen.coefficients.protection import Action, Cause, Protection
from tests.examples import ROOT

PAGE = (Path(__file__).parents[2] / "docs" / "protection.md").read_text(encoding="utf-8")


def my1016(wiring: dict[str, Any]) -> dict[str, Any]:
    tree: dict[str, Any] = json.loads((ROOT / "examples" / "my1016" / "coeffs.json").read_text(encoding="utf-8"))
    tree["wiring"] |= wiring
    return tree


def rows(header: str) -> dict[str, str]:
    """First and last cell of each line of a table."""
    table = PAGE.split(header)[1].split("\n\n")[0]
    return dict(re.findall(r"^\| (.+?) \|.*\| (.+?) \|$", table, re.MULTILINE))


def test_the_example_loads() -> None:
    table, ahead = (json.loads("{" + shown + "}") for shown in re.findall(r"```json\n(.*?)```", PAGE, re.DOTALL))
    found = parse(json.dumps(my1016({}) | table).encode()).document.protection
    assert [entry.cause for entry in found] == [entry["cause"] for entry in table["protection"]]
    network = json.loads((ROOT / "examples" / "network" / "coeffs.json").read_text(encoding="utf-8"))
    forecast = parse(json.dumps(network | ahead).encode()).document.forecast
    assert forecast is not None
    assert set(ahead["forecast"]) == set(Forecast.model_fields)
    assert {key.strip("`") for key in rows("| key of `forecast` |")} == set(Forecast.model_fields)


def test_the_tables_have_every_cause_and_key_and_the_page_every_action() -> None:
    causes = re.findall(r"`(\w+)`", " ".join(re.sub(r"\(.*\)", "", cell) for cell in rows("| `cause` |")))
    assert set(causes) == set(get_args(Cause))
    keys = set(re.findall(r"`(\w+)`", " ".join(rows("| key | what it says | left out |"))))
    of_causes = {"rule", "channel", "least", "note"}
    assert keys == set(Protection.model_fields) - of_causes
    assert of_causes - {"note"} <= set(re.findall(r"`(\w+)`", PAGE.split("| key |")[0]))
    assert all(f"`{action}`" in PAGE for action in get_args(Action))


def test_the_defaults_are_those_that_the_table_says() -> None:
    said = {cause: text for cell, text in rows("| `cause` |").items() for cause in re.findall(r"`(\w+)`", cell)}
    wired = {"relay_pin": 12, "command_timeout_s": 20, "supply": {}}
    document = parse(json.dumps(my1016(wired)).encode()).document
    found = protections(document)
    for entry in found:
        text = said[entry.cause]
        assert f"`{entry.action}`" in text
        assert not entry.delay_s or f"after {entry.delay_s:g} s" in text
    without = {cause for cause, text in said.items() if text == "none"} & set(get_args(Cause))
    assert not without & {entry.cause for entry in found}
    assert without | {entry.cause for entry in found} == set(get_args(Cause))
