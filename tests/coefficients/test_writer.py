"""What is written reads back the same, and what somebody else wrote stays as it was."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from gen.coefficients import Document, as_json, dump, load, parse, with_effects, with_rules
from gen.coefficients.document import Ambient
from gen.coefficients.effects import EffectEntry
from gen.coefficients.messages import building
from gen.coefficients.provenance import ErrorBand
from gen.coefficients.rules import RuleDraft, Rules
from gen.coefficients.versions import VERSION
from gen.coefficients.wiring import Wiring
from gen.errors import InputError
from tests.coefficients.test_coefficients_errors import BASE

OLD = sorted((Path(__file__).parent / "version1").glob("*.json"))
FILES = [*OLD, *sorted((Path(__file__).parent / "version2").glob("*.json"))]
WITH_COMPONENTS = [path for path in FILES if load(path).document.network is None]
by_name = pytest.mark.parametrize("path", FILES, ids=lambda path: f"{path.parent.name}/{path.stem}")
DRIFT = EffectEntry(name="drift", component="casing", parameters={"drift_K_per_h": 0.5}, evidence={"level": 0.01})
LAG = EffectEntry(name="sensor_lag", component="brush", parameters={"lag_s": 20.0})


@by_name
def test_a_document_survives_writing_and_reading(path: Path) -> None:
    loaded = load(path)
    text = dump(loaded.document)
    again = parse(text.encode())
    assert again.document == loaded.document
    assert again.model == loaded.model
    assert dump(again.document) == text


@by_name
def test_what_is_written_is_what_the_file_says_and_no_more(path: Path) -> None:
    """By JSON alone: the same keys and numbers; only a null that means the same as a missing key is gone."""

    def said(value: Any) -> Any:  # noqa: ANN401
        if isinstance(value, dict):
            return {k: said(v) for k, v in value.items() if v is not None or k == "memory"}
        return [said(item) for item in value] if isinstance(value, list) else value

    written = said(json.loads(dump(load(path).document)))
    assert written.pop("version") == VERSION
    read = said(json.loads(path.read_text(encoding="utf-8")))
    assert read.pop("version") == int(path.parent.name.removeprefix("version"))
    assert list(written) == [key for key in Document.model_fields if key in read]
    assert written == read


def test_the_layout_is_stable() -> None:
    text = dump(load(next(path for path in OLD if path.stem == "two_mass")).document)
    assert text.startswith('{\n "format": "gen-coefficients",\n "version": 2,\n "name": "two_mass",\n')
    assert text.endswith("\n}\n")


def test_what_was_not_said_is_not_written() -> None:
    assert as_json(Ambient(fixed_degC=None, channel="ambient_degC")) == {"channel": "ambient_degC"}
    assert as_json(Wiring(memory=None, observe=None)) == {"memory": None}  # no copies; without it there are some
    assert as_json(ErrorBand(component="a", pwm=(0, 9), model_minus_measured_K=(-1.0, 2.0))) == {
        "component": "a",
        "pwm": [0, 9],
        "model_minus_measured_K": [-1.0, 2.0],
    }


def test_names_of_all_languages_stay_readable() -> None:
    text = dump(parse(json.dumps(BASE | {"description": "Lüfter 冷却"}).encode()).document)
    assert '"description": "Lüfter 冷却"' in text
    assert parse(text.encode()).document.description == "Lüfter 冷却"


@pytest.mark.parametrize("path", WITH_COMPONENTS, ids=lambda path: f"{path.parent.name}/{path.stem}")
def test_effects_are_added_and_the_rest_stays_as_it_was_written(path: Path) -> None:
    raw = path.read_text(encoding="utf-8")
    before = json.loads(raw, object_pairs_hook=list, parse_float=str, parse_int=str)
    names = [part.name for part in load(path).document.components]
    entry = EffectEntry(name="drift", component=names[0], parameters={"drift_K_per_h": 0.0625})
    text = with_effects(raw, [entry])
    after = dict(json.loads(text, object_pairs_hook=list, parse_int=str))
    added = after["effects"].pop()
    assert added == [("name", "drift"), ("component", names[0]), ("parameters", [("drift_K_per_h", 0.0625)])]
    assert [key for key, _ in before] == [key for key in after if key in dict(before)]
    # Whole numbers without a point stay so, and every other number is the same.
    newest = [(key, str(VERSION) if key == "version" else value) for key, value in before]
    assert _with_numbers(newest) == _with_numbers(
        [(key, value) for key, value in after.items() if key != "effects" or value]
    )
    assert parse(text.encode()).document.effects[-1] == entry


def _with_numbers(value: Any) -> Any:  # noqa: ANN401
    """Numbers with a point by value, whole ones as written: 1.0E-3 may become 0.001, but 10 not 10.0."""
    if isinstance(value, (list, tuple)):
        return [_with_numbers(item) for item in value]
    if isinstance(value, str) and any(mark in value for mark in ".eE"):
        try:
            return float(value)
        except ValueError:
            return value
    return value


def test_effects_that_the_file_has_already_stay() -> None:
    text = with_effects(with_effects(json.dumps(BASE), [DRIFT]), [LAG])
    assert parse(text.encode()).document.effects == (DRIFT, LAG)
    assert json.loads(text)["effects"] == [as_json(DRIFT), as_json(LAG)]
    assert with_effects(text, []) == text


def test_rules_take_the_place_of_the_file_s_and_are_written_as_their_author_did() -> None:
    written = {"kind": "cusum", "name": "slow", "component": "casing", "persistence_s": 60}
    rule = RuleDraft(written).completed(beyond="error_band", slack_K=0.0, threshold_K_s=900.0, note="made up")
    band = ErrorBand(component="casing", pwm=(0, 255), model_minus_measured_K=(-1.0, 2.0))
    rules = Rules((RuleDraft(written),), {"description": "mine"})
    text = with_rules(json.dumps(BASE), rules, [rule], [band], source="nobody")
    made = json.loads(text)
    assert list(made) == list(BASE)
    assert list(made["alarms"][0].items()) == [
        *written.items(),
        ("beyond", "error_band"),
        ("slack_K", 0.0),
        ("threshold_K_s", 900.0),
        ("note", "made up"),
    ]
    assert made["description"] == "mine"
    assert made["provenance"] == BASE["provenance"] | {"error": [as_json(band)]}
    assert parse(text.encode()).document.provenance is not None


@pytest.mark.parametrize("provenance", [{}, {"provenance": None}])
def test_a_file_without_provenance_gets_one_for_its_bands(provenance: dict[str, None]) -> None:
    tree = {key: value for key, value in BASE.items() if key not in ("provenance", "alarms")} | provenance
    made = json.loads(with_rules(json.dumps(tree), Rules((), {}), [], [], source="gen thresholds"))
    assert made["provenance"] == {"source": "gen thresholds", "error": []}


def test_what_the_author_of_a_rule_chose_stays() -> None:
    draft = RuleDraft({"kind": "above_model", "component": "casing", "note": "mine", "hysteresis_K": 3})
    made = draft.completed(threshold_K=2.0, hysteresis_K=1.0, note="ours").written
    assert (made["note"], made["hysteresis_K"], made["threshold_K"]) == ("mine", 3, 2.0)


@pytest.mark.parametrize(
    ("written", "lacks"),
    [
        ({"kind": "above_model"}, True),
        ({"kind": "below_model", "threshold_K": 2}, False),
        ({"kind": "cusum", "slack_K": 1}, True),
        ({"kind": "cusum", "threshold_K_s": 9}, False),
        ({"kind": "over_temperature"}, True),
        ({"kind": "over_temperature", "limit_degC": 99}, False),
        ({"kind": "no such kind"}, False),
        ({}, False),
    ],
)
def test_only_a_rule_of_a_known_kind_without_a_threshold_lacks_one(written: dict[str, Any], lacks: bool) -> None:
    assert RuleDraft(written).lacks_threshold is lacks


def test_a_part_that_cannot_be_built_is_said_with_its_place() -> None:
    with pytest.raises(InputError, match="expected the lower limit first") as caught, building():
        ErrorBand(component="a", pwm=(9, 0), model_minus_measured_K=(0.0, 0.0))
    assert caught.value.place == "ErrorBand.pwm"
    with pytest.raises(InputError, match="name of a file of the sketch") as caught, building():
        type(load(FILES[0]).document).model_validate(BASE | {"version": VERSION, "name": "board"})
    assert caught.value.place == "$.name"
