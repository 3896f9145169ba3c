"""Good coefficient files: what is loaded, what is warned of, and the published schema."""

import copy
import hashlib
import json
import os
import shutil
import subprocess
from pathlib import Path
from typing import Any

import jsonschema
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gen.coefficients import Document, parse
from gen.coefficients.checks.model_checks import _hurwitz, spans
from gen.coefficients.names import reserved
from gen.coefficients.schema import STORED, json_schema, published, schema_text
from gen.coefficients.versions import VERSION
from gen.errors import InputError
from gen.model import ExponentialSum, Polynomial, Table
from tests.coefficients.test_coefficients_errors import BASE, FAULTS, changed
from tests.model.examples import EXAMPLES, NAMES, example

# Faults that relate one part of the file to another, or that JSON does not know (3.0 is an integer there).
BEYOND_SCHEMA = (
    "as many as the order",
    "found 3 pole(s)",
    "lower limit first",
    "expected it within",
    "found neither",
    "already taken",
    "has a thermocouple already",
    "expected the name",
    'found "',
    "is taken by",
    "no external interrupt",
    "no PWM",
    "boot loader's LED",
    "expected a whole number",
)


def test_a_rule_that_says_no_hysteresis_has_none() -> None:
    """It clears as soon as its condition is not met any more."""
    tree = json.loads((EXAMPLES / "my1016" / "coeffs.json").read_text())
    for rule in tree["alarms"]:
        rule.pop("hysteresis_K", None)
    rules = parse(json.dumps(tree).encode()).document.alarms
    assert {rule.kind for rule in rules} >= {"over_temperature", "above_model", "below_model"}
    assert {getattr(rule, "hysteresis_K", 0.0) for rule in rules} == {0.0}


@pytest.mark.parametrize("name", NAMES)
def test_examples(name: str) -> None:
    raw = (EXAMPLES / name / "coeffs.json").read_bytes()
    loaded = example(name)
    assert loaded.name == name
    assert loaded.sha256 == hashlib.sha256(raw).hexdigest()
    assert (loaded.accuracy.fixed_limit_K, loaded.accuracy.float_limit_K) == (1e-5, 1e-3)
    assert loaded.model.sample_time == 0.25
    assert loaded.model.domain_pwm == (0, 255)
    tree = json.loads(raw)
    for version in range(tree["version"], VERSION + 1):
        jsonschema.validate(tree | {"version": version}, schema_of(version))


def test_my1016_is_the_study() -> None:
    loaded = example("my1016")
    brush, bearing, magnet, casing = loaded.model.components
    assert [c.order for c in loaded.model.components] == [3, 1, 1, 1]
    assert brush.gain == Polynomial((-2.586e-13, 6.931e-11, -1.912e-10))
    assert brush.poles[0].real == ExponentialSum(((0.0005619, 0.01276), (-0.001848, 0.00903)))
    assert brush.poles[1].imag == Polynomial((1.969e-07, -4.718e-05, -0.0007725))
    assert brush.poles[2].imag is None
    assert casing.poles[0].real == ExponentialSum(((-0.0009327, -0.001456), (0.0007804, -0.008379)))
    assert (bearing.name, magnet.name, casing.name) == ("bearing", "magnet", "casing")
    assert loaded.model.validity == (51, 255)
    assert loaded.model.ambient_fixed == 30.0
    assert len(loaded.warnings) == 3  # the other two: the study's brush rules lie inside its model's error
    assert "PWM 1..2, outside the validity range 51..255; it is taken as 0" in loaded.warnings[0]
    assert loaded.document.wiring is not None
    assert {t.channel for t in loaded.document.wiring.thermocouples} == {
        *loaded.model.component_names,
        "ambient",
    }


def test_two_mass_uses_both_interpolations() -> None:
    housing = example("two_mass").model.component("housing")
    kinds = {s.interpolation for s in (housing.gain, housing.poles[0].real) if isinstance(s, Table)}
    assert kinds == {"pchip", "linear"}
    (warning,) = example("two_mass").warnings
    assert warning.startswith("$.alarms[1].slack_K")


@pytest.mark.parametrize("name", NAMES)
def test_document_survives_writing_and_reading(name: str) -> None:
    document = example(name).document
    again = parse(json.dumps(document.model_dump(mode="json")).encode())
    assert again.document == document
    assert again.model == example(name).model
    assert Document.model_validate(document.model_dump()) == document


def test_byte_order_mark_is_let_pass() -> None:
    raw = (EXAMPLES / "two_mass" / "coeffs.json").read_bytes()
    assert parse(b"\xef\xbb\xbf" + raw).document == example("two_mass").document


def test_optional_parts_may_be_left_out() -> None:
    tree = copy.deepcopy(BASE)
    for key in ("description", "accuracy", "provenance", "wiring", "alarms"):
        del tree[key]
    loaded = parse(json.dumps(tree).encode())
    assert loaded.accuracy.fixed_limit_K == 1e-5
    assert loaded.document.alarms == ()


def test_hold_needs_no_treatment_of_negative_gain() -> None:
    tree = changed((("validity", "outside"), "hold"))
    del tree["components"][0]["negative_gain"]
    tree["alarms"] = []
    del tree["wiring"]
    assert parse(json.dumps(tree).encode()).warnings == ()


def test_warnings() -> None:
    short = {"table": {"pwm": [60, 200], "value": [1e-4, 2e-4], "interpolation": "linear"}}
    tree = changed((("components", 1, "gain"), short), (("components", 2, "poles", 0, "imag"), {"poly": [3e-4]}))
    warnings = parse(json.dumps(tree).encode()).warnings
    assert any("table covers PWM 60..200 only" in w and "$.components[1].gain" in w for w in warnings)
    assert any("far from conjugate pairs" in w and "$.components[2].poles" in w for w in warnings)


def test_a_board_that_measures_too_little_is_pointed_at() -> None:
    """The brush's rules could never be raised, and the model's temperatures would stand on a made-up ambient."""
    tree = copy.deepcopy(BASE)
    tree["ambient"] = {"channel": "ambient_degC"}
    chips = tree["wiring"]["thermocouples"]
    kept = [chip for chip in chips if chip["channel"] not in ("brush", "ambient")]
    before = parse(json.dumps(tree).encode()).warnings
    tree["wiring"]["thermocouples"] = kept
    new = set(parse(json.dumps(tree).encode()).warnings) - set(before)
    watching = [i for i, rule in enumerate(tree["alarms"]) if "brush" in (rule["component"], rule.get("relative_to"))]
    rules = [f"$.alarms[{i}]." for i in watching]
    assert rules
    assert all(any(w.startswith(at) and "no thermocouple" in w for w in new) for at in rules)
    assert any(w.startswith("$.ambient:") and "25 degC" in w for w in new)
    tree["wiring"]["thermocouples"] = []  # somebody's own sketch may have them
    assert not any("thermocouple" in w for w in parse(json.dumps(tree).encode()).warnings)


def test_stored_schema_is_what_the_models_make() -> None:
    assert STORED.read_text(encoding="utf-8") == schema_text(), "run python -m gen.coefficients.schema"
    jsonschema.Draft202012Validator.check_schema(json_schema())


def schema_of(version: int) -> dict[str, Any]:
    return dict(json.loads(published(version).read_text(encoding="utf-8")))


def test_the_schema_of_version_1_is_that_of_0_1_0() -> None:
    """What others check their files with; it is never written anew."""
    digest = hashlib.sha256(published(1).read_bytes()).hexdigest()
    assert digest == "7cad550ab89820a693736f79f1c02ee8300e7854169d77fe72ad1d5f3784a47b"
    jsonschema.Draft202012Validator.check_schema(schema_of(1))


def test_a_schema_takes_files_of_its_own_version_only() -> None:
    for version in range(1, VERSION + 1):
        validator = jsonschema.Draft202012Validator(schema_of(version))
        taken = [found for found in range(VERSION + 2) if validator.is_valid(BASE | {"version": found})]
        assert taken == [version]


@pytest.mark.parametrize("version", range(1, VERSION + 1))
@pytest.mark.parametrize(("where", "value", "place", "message"), FAULTS)
def test_schema_rejects_what_it_can_express(
    where: tuple[str | int, ...], value: object, place: str, message: str, version: int
) -> None:
    validator = jsonschema.Draft202012Validator(schema_of(version))
    valid = validator.is_valid(changed((("version",), version), (where, value)))
    expressible = not any(part in message for part in BEYOND_SCHEMA)
    # 'found "' also begins the messages about a schedule's keys, which the schema does express.
    expressible |= "expected a schedule" in message
    assert not (valid and expressible)


@given(st.integers(1, 4), st.data())
def test_hurwitz_agrees_with_the_roots(order: int, data: st.DataObject) -> None:
    a = np.array([1.0, *data.draw(st.lists(st.floats(-2.0, 2.0), min_size=order, max_size=order))])
    largest = np.roots(a).real.max()
    if abs(largest) > 1e-3:
        assert bool(_hurwitz(a[None])[0]) == (largest < 0)


_PAIR = st.tuples(st.floats(-2.0, 0.3), st.floats(0.0, 3.0))


@given(st.lists(_PAIR, min_size=1, max_size=2), st.lists(st.floats(-2.0, -0.01), max_size=1))
def test_hurwitz_sees_an_oscillation_that_grows(pairs: list[tuple[float, float]], real: list[float]) -> None:
    """Drawn by its poles: coefficients drawn one by one hardly ever come near the border with all signs right."""
    poles = [complex(re, sign * im) for re, im in pairs for sign in (1, -1)] + real
    if len(poles) <= 4 and abs(largest := max(complex(pole).real for pole in poles)) > 1e-3:
        assert bool(_hurwitz(np.asarray(np.poly(poles).real[None], dtype=np.float64))[0]) == (largest < 0)


def test_spans() -> None:
    assert spans(np.array([1, 2, 7, 9, 10, 11])) == "1..2, 7, 9..11"


def test_reserved_names_hold_every_macro_of_the_headers(tmp_path: Path) -> None:
    """Against the compiler: a macro missing from the list would break a build."""
    core = Path(os.environ.get("ARDUINO_AVR", "/usr/share/arduino/hardware/arduino/avr"))
    compiler = shutil.which("avr-g++")
    assert compiler is not None and core.is_dir(), "needs avr-g++ and the Arduino core: scripts/setup.sh installs them"
    source = tmp_path / "macros.cpp"
    source.write_text("#include <Arduino.h>\n#include <avr/wdt.h>\n#include <util/crc16.h>\n", encoding="utf-8")
    includes = [f"-I{core / 'cores/arduino'}", f"-I{core / 'variants/mega'}"]
    command = [
        compiler,
        "-mmcu=atmega2560",
        "-DF_CPU=16000000L",
        "-DARDUINO=10819",
        *includes,
        "-dM",
        "-E",
        str(source),
    ]
    defined = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    names = {line.split()[1].split("(")[0] for line in defined.splitlines()}
    missing = {n for n in names if n[0].isalpha() and len(n) <= 24 and "__" not in n}
    missing -= reserved("macros") | reserved("keywords")
    assert missing == set()


def test_a_rule_relative_to_another_component_where_there_is_none() -> None:
    tree = changed()
    tree["components"] = [{**tree["components"][1], "name": "only"}]
    rule = {"name": "odd", "kind": "above_model", "component": "only", "threshold_K": 1, "relative_to": "other"}
    tree |= {"alarms": [rule], "wiring": None, "provenance": None}
    with pytest.raises(InputError, match=r'found "other", expected none') as caught:
        parse(json.dumps(tree).encode())
    assert caught.value.place == "$.alarms[0].relative_to"


def test_document_built_in_python_is_checked_too() -> None:
    """What identifies a model builds documents without a file."""
    tree: dict[str, Any] = changed((("version",), VERSION), (("components", 0, "name"), "SP"))
    with pytest.raises(ValueError, match="macro"):
        Document.model_validate(tree)
    with pytest.raises(InputError):
        parse(json.dumps(tree).encode())
