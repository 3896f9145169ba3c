"""docs/format.md: its errors are those that are shown, its table has every command."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import pytest

from gen.cli import cli
from gen.coefficients import Document, load
from gen.coefficients.network import ChannelEntry, HeatEntry, NetworkEntry, NodeEntry, PathEntry, SensorEntry
from gen.errors import InputError
from tests.coefficients.test_coefficients_errors import BASE, DELETE, changed
from tests.examples import ROOT

PAGE = (Path(__file__).parents[2] / "docs" / "format.md").read_text(encoding="utf-8")
SHOWN = re.findall(r"^    coeffs\.json: (.+)$", PAGE, re.MULTILINE)

FAULTS: list[dict[str, Any]] = [
    changed((("network",), {"nodes": []})),
    changed((("version",), 3)),
    changed((("version",), "1")),
    changed((("version",), DELETE)),
    changed((("format",), "other")),
    changed((("accuracy",), {"fixed_limt_K": 1e-3})),
]


@pytest.mark.parametrize(("tree", "line"), [*zip(FAULTS, SHOWN, strict=True)])
def test_an_error_is_shown_as_the_page_says(tree: dict[str, Any], line: str, tmp_path: Path) -> None:
    path = tmp_path / "coeffs.json"
    path.write_text(json.dumps(tree), encoding="utf-8")
    with pytest.raises(InputError) as caught:
        load(path)
    assert str(caught.value) == f"{path}: {line}"


def test_the_table_of_commands_is_complete() -> None:
    assert set(re.findall(r"^\| `gen (\w+)` \|", PAGE, re.MULTILINE)) == set(cli.commands)


def test_the_table_of_keys_is_complete_and_in_the_order_of_the_file() -> None:
    table = PAGE.split("| key | what it says | more |")[1].split("\n\n")[0]
    rows = re.findall(r"^\| ((?:`\w+`(?:, )?)+) \|", table, re.MULTILINE)
    assert [key for row in rows for key in re.findall(r"`(\w+)`", row)] == list(Document.model_fields)


def test_the_keys_that_are_needed_are_those_that_the_page_names() -> None:
    keys = list(Document.model_fields)
    needed = {key for key in keys if Document.model_fields[key].is_required()}
    said = re.search(r"Needed are all keys from `(\w+)` to `(\w+)` but `(\w+)`, and either `(\w+)` or `(\w+)`", PAGE)
    assert said is not None
    first, last, without, *either = said.groups()
    named = keys[keys.index(first) : keys.index(last) + 1]
    assert needed == set(named) - {without}
    assert either == ["components", "network"]  # test_network.py: neither and both are refused


def test_a_key_without_use_is_still_read(tmp_path: Path) -> None:
    path = tmp_path / "coeffs.json"
    path.write_text(json.dumps(BASE | {"accuracy": {"fast_limit_K": 1e-4}}), encoding="utf-8")
    assert load(path).accuracy.fixed_limit_K == 1e-5


def test_the_smallest_network_is_shown_as_the_example_has_it() -> None:
    shown = next(
        block for block in re.findall(r"^```json\n(.+?)^```", PAGE, re.MULTILINE | re.DOTALL) if "network" in block
    )
    example = (ROOT / "examples" / "two_nodes" / "coeffs.json").read_text(encoding="utf-8")
    assert shown in example
    assert json.loads(f"{{{shown}}}")["network"] == json.loads(example)["network"]


def test_every_key_of_a_network_is_in_its_table() -> None:
    table = PAGE.split("| key of `network` | what it says | left out |")[1].split("\n\n")[0]
    named = set(re.findall(r"[A-Za-z_]+", " ".join(re.findall(r"`([^`]+)`", table))))
    parts = (NetworkEntry, NodeEntry, SensorEntry, PathEntry, HeatEntry, ChannelEntry)
    assert {key for part in parts for key in part.model_fields} - named == {"description"}
