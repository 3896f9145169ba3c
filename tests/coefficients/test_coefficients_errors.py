"""Each fault in a coefficient file gets one message with its place."""

import copy
import json
from collections.abc import Callable
from functools import reduce
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gen.coefficients import load, parse
from gen.coefficients.base import listed
from gen.errors import InputError
from tests.model.examples import EXAMPLES

RAW = (EXAMPLES / "my1016" / "coeffs.json").read_bytes()
BASE: dict[str, Any] = json.loads(RAW)
DELETE = object()
Path_ = tuple[str | int, ...]


def changed(*changes: tuple[Path_, object]) -> dict[str, Any]:
    tree: Any = copy.deepcopy(BASE)
    for (*where, last), value in changes:
        holder = reduce(lambda node, step: node[step], where, tree)
        if value is DELETE:
            del holder[last]
        else:
            holder[last] = value
    return dict(tree)


def failure(tree: object) -> InputError:
    with pytest.raises(InputError) as caught:
        parse(json.dumps(tree).encode())
    return caught.value


C0, C1 = ("components", 0), ("components", 1)
GAIN0, POLE1 = (*C0, "gain"), (*C1, "poles", 0, "real")
THERMO1 = ("wiring", "thermocouples", 1)

# (what to change, to what, place, part of the message)
FAULTS: list[tuple[Path_, object, str, str]] = [
    (("version",), 3, "$.version", "found 3, expected 1 to 2"),
    (("version",), 1000, "$.version", "found 1000, expected 1 to 2: a newer gen wrote this file; install a newer gen"),
    (("version",), "1", "$.version", 'found the text "1", expected 1 to 2'),
    (("version",), 0, "$.version", "found 0, expected 1 to 2"),
    (("version",), 1.5, "$.version", "found 1.5, expected 1 to 2"),
    (("version",), True, "$.version", "found true, expected 1 to 2"),
    (("format",), "x", "$.format", 'found the text "x", expected "gen-coefficients"'),
    (("format",), DELETE, "$", 'missing key "format"'),
    ((*C0, "gain"), DELETE, "$.components[0]", 'missing key "gain"'),
    ((*C0, "gian"), {}, "$.components[0].gian", 'unknown key "gian"; did you mean "gain"?'),
    (("we ird",), 1, '$["we ird"]', 'unknown key "we ird"; expected "format"'),
    ((*GAIN0, "poly", 2), "abc", "$.components[0].gain.poly[2]", 'found the text "abc", expected a number'),
    ((*GAIN0, "poly", 2), True, "$.components[0].gain.poly[2]", "found true, expected a number"),
    ((*GAIN0, "poly"), [], "$.components[0].gain.poly", "found 0 entries, expected at least 1"),
    ((*GAIN0, "poly"), 3, "$.components[0].gain.poly", "found 3, expected a list"),
    ((*GAIN0, "exp1"), [1, 2], "$.components[0].gain", 'found "poly" and "exp1", expected a schedule'),
    (GAIN0, {}, "$.components[0].gain", "found no key, expected a schedule with exactly one of"),
    (GAIN0, {"ploy": [1]}, "$.components[0].gain", 'did you mean "poly"?'),
    (GAIN0, {"poly": [1], "x": 1}, "$.components[0].gain.x", 'unknown key "x"'),
    (GAIN0, 3, "$.components[0].gain", "found 3, expected a schedule"),
    (POLE1, {"exp2": [1, 2, 3]}, "$.components[1].poles[0].real.exp2", "found 3 entries, expected 4"),
    (POLE1, {"exp2": [1] * 5}, "$.components[1].poles[0].real.exp2", "found 5 entries, expected at most 4"),
    (POLE1, {"exp1": [1]}, "$.components[1].poles[0].real.exp1", "found 1 entry, expected 2"),
    (("sample_time_s",), None, "$.sample_time_s", "found null, expected a number"),
    (("sample_time_s",), 0, "$.sample_time_s", "expected a number over 0"),
    ((*C0, "order"), 3.0, "$.components[0].order", "expected a whole number"),
    ((*C0, "order"), 5, "$.components[0].order", "found 5, expected at most 4"),
    ((*C0, "order"), 2, "$.components[0].poles", "found 3 pole(s), expected 2"),
    (("components",), [], "$.components", "found 0 entries, expected at least 1"),
    (("components",), 3, "$.components", "found 3, expected a list"),
    (C0, "x", "$.components[0]", 'found the text "x", expected an object'),
    ((*C0, "negative_gain"), "clamp", "$.components[0].negative_gain", 'expected "zero"'),
    (("validity", "pwm"), [51], "$.validity.pwm", "found 1 entry, expected 2"),
    (("validity", "pwm"), [255, 51], "$.validity.pwm", "expected the lower limit first"),
    (("validity", "pwm", 1), 300, "$.validity.pwm[1]", "found 300, expected at most 255"),
    (("validity", "outside"), "clamp", "$.validity.outside", 'expected "extrapolate" or "hold"'),
    (
        ("domain", "pwm"),
        [60, 255],
        "$.validity.pwm",
        "found [51, 255], expected it within 60..255, the domain",
    ),
    (("input", "full_scale"), 200, "$.domain.pwm", "expected it within 0..200, the input's full scale"),
    (("input", "full_scale"), 256, "$.input.full_scale", "found 256, expected at most 255"),
    (("domain", "temperature_degC"), [150, -10], "$.domain.temperature_degC", "lower limit first"),
    (("domain", "ambient_degC", 0), -300, "$.domain.ambient_degC[0]", "expected at least -273.15"),
    (("ambient",), {}, "$.ambient", 'found neither, expected "fixed_degC"'),
    (("ambient", "fixed_degC"), 80, "$.ambient.fixed_degC", "found 80, expected it within -10..50"),
    (("ambient", "at_once"), "yes", "$.ambient.at_once", 'found the text "yes", expected true or false'),
    (("accuracy", "fixed_limit_K"), 0, "$.accuracy.fixed_limit_K", "expected a number over 0"),
    (("wiring", "led_pin"), 70, "$.wiring.led_pin", "found 70, expected at most 69"),
    (("wiring", "led_pin"), 0, "$.wiring.led_pin", "already taken by the serial port"),
    ((*THERMO1, "cs"), 29, "$.wiring.thermocouples[1].cs", "already taken by thermocouples[0].cs"),
    ((*THERMO1, "so"), 31, "$.wiring.thermocouples[1].so", "already taken by thermocouples[0].sck"),
    ((*THERMO1, "channel"), "brush", "$.wiring.thermocouples[1].channel", "has a thermocouple already"),
    ((*THERMO1, "channel"), "rotor", "$.wiring.thermocouples[1].channel", 'found "rotor", expected the name'),
    (("wiring", "encoder", "pin"), 7, "$.wiring.encoder.pin", "no external interrupt"),
    (("wiring", "drive", "forward_pin"), 30, "$.wiring.drive.forward_pin", "no PWM"),
    (("wiring", "drive", "reverse_pin"), DELETE, "$.wiring.drive", 'missing key "reverse_pin"; expected either'),
    (("wiring", "drive", "reverse_pin"), None, "$.wiring.drive", 'missing key "reverse_pin"; expected either'),
    (("wiring", "drive"), {}, "$.wiring.drive", "found no pin; expected either"),
    (("wiring", "drive"), {"forward_level": "low"}, "$.wiring.drive", "found no pin; expected either"),
    (("wiring", "drive"), {"pwm_pin": 4}, "$.wiring.drive", 'missing key "direction_pin"; expected either'),
    (("wiring", "drive"), {"direction_pin": 4}, "$.wiring.drive", 'missing key "pwm_pin"; expected either'),
    (
        ("wiring", "drive", "pwm_pin"),
        6,
        "$.wiring.drive",
        'and "pwm_pin"; expected either "forward_pin" and "reverse_pin", or "pwm_pin" and "direction_pin"',
    ),
    (
        ("wiring", "drive"),
        {"forward_pin": 4, "direction_pin": 5},
        "$.wiring.drive",
        '"forward_pin" and "direction_pin"; expected either',
    ),
    (
        ("wiring", "drive", "forward_level"),
        "low",
        "$.wiring.drive",
        '"forward_pin", "reverse_pin" and "forward_level"; expected either',
    ),
    (
        ("wiring", "drive"),
        {"pwm_pin": 4, "direction_pin": 7, "forward_level": "on"},
        "$.wiring.drive.forward_level",
        'found the text "on", expected "high" or "low"',
    ),
    (("wiring", "drive"), {"pwm_pin": 30, "direction_pin": 4}, "$.wiring.drive.pwm_pin", "no PWM"),
    (
        ("wiring", "drive"),
        {"pwm_pin": 13, "direction_pin": 4},
        "$.wiring.drive.pwm_pin",
        "is the boot loader's LED",
    ),
    (
        ("wiring", "drive"),
        {"pwm_pin": 4, "direction_pin": 4},
        "$.wiring.drive.direction_pin",
        "already taken by drive.pwm_pin",
    ),
    (
        ("wiring", "drive"),
        {"pwm_pin": 4, "direction_pin": 47},
        "$.wiring.drive.direction_pin",
        "already taken by encoder.pin",
    ),
    (
        ("wiring", "drive"),
        {"pwm_pin": 4, "direction_pin": 1},
        "$.wiring.drive.direction_pin",
        "already taken by the serial port",
    ),
    (("wiring", "drive"), {"pwm_pin": 4, "direction_pin": 70}, "$.wiring.drive.direction_pin", "at most 69"),
    (("wiring", "serial_baud"), 1234, "$.wiring.serial_baud", "found 1234, expected 9600"),
    (("alarms", 0, "kind"), "x", "$.alarms[0]", 'found the kind the text "x", expected "above_model"'),
    (("alarms", 0, "kind"), DELETE, "$.alarms[0]", 'missing key "kind"'),
    (("alarms", 0), 3, "$.alarms[0]", "found 3, expected an alarm rule"),
    (("alarms", 0, "component"), "rotor", "$.alarms[0].component", 'found "rotor", expected the name'),
    (
        ("alarms", 0, "requires"),
        "brush_fault",
        "$.alarms[0].requires",
        "expected the name of an earlier rule",
    ),
    (("alarms", 0, "limit_degC"), 3, "$.alarms[0].limit_degC", 'unknown key "limit_degC"'),
    (("alarms", 0, "speed_percent"), [70, 30], "$.alarms[0].speed_percent", "lower limit first"),
    (("alarms", 0, "threshold_K"), -1, "$.alarms[0].threshold_K", "found -1, expected at least 0"),
    (("alarms", 1, "name"), "FAULT", "$.alarms[1].name", 'is taken by alarms[0] ("fault")'),
    (("provenance", "fit", "rotor"), {}, "$.provenance.fit.rotor", 'found "rotor", expected the name'),
    (("provenance", "error", 0, "component"), "x", "$.provenance.error[0].component", 'found "x"'),
]


@pytest.mark.parametrize(("where", "value", "place", "message"), FAULTS)
def test_fault(where: Path_, value: object, place: str, message: str) -> None:
    error = failure(changed((where, value)))
    assert error.place == place
    assert message in error.message
    assert "\n" not in str(error)


NAMES = [
    ("SP", "macro"),
    ("F", "macro"),
    ("PORTA", "macro"),
    ("DDRB", "macro"),
    ("PINA", "macro"),
    ("OCR1A", "macro"),
    ("B0", "macro"),
    ("PI", "macro"),
    ("INPUT", "macro"),
    ("HIGH", "macro"),
    ("abs", "macro"),
    ("min", "macro"),
    ("round", "macro"),
    ("bit", "macro"),
    ("int", "keyword"),
    ("nullptr", "keyword"),
    ("xor", "keyword"),
    ("Serial", "name of the Arduino core"),
    ("loop", "name of the Arduino core"),
    ("A0", "name of the Arduino core"),
    ("uint8_t", "name of the Arduino core"),
    ("ambient", "reserved"),
    ("Ambient", "reserved"),
    ("2nd", "not a C identifier"),
    ("", "not a C identifier"),
    ("_x", "not a C identifier"),
    ("a b", "not a C identifier"),
    ("a\n", "not a C identifier"),
    ("bürste", "not a C identifier"),
    ("a__b", "two underscores"),
    ("x" * 25, "has 25 characters"),
]


@pytest.mark.parametrize(("name", "reason"), NAMES)
@pytest.mark.parametrize("where", [("name",), (*C1, "name"), ("alarms", 0, "name")])
def test_names_that_cannot_be(name: str, reason: str, where: Path_) -> None:
    error = failure(changed((where, name)))
    assert reason in error.message
    assert error.place is not None
    assert error.place.endswith(".name")


@pytest.mark.parametrize("name", ["x", "winding", "Rotor_2", "sp", "x" * 24])
def test_names_that_can_be(name: str) -> None:
    assert parse(json.dumps(changed((("name",), name))).encode()).name == name


def test_names_differ_in_more_than_case() -> None:
    error = failure(changed(((*C0, "name"), "Bearing")))
    assert error.place == "$.components[1].name"
    assert 'taken by components[0] ("Bearing")' in error.message


def poly(*coefficients: float) -> dict[str, list[float]]:
    return {"poly": list(coefficients)}


PHYSICS: list[tuple[Path_, object, str, str]] = [
    (
        POLE1,
        poly(-1),
        "$.components[1].poles",
        "too fast for the sample time of 0.25 s at PWM 0: pole -1 rad/s",
    ),
    (POLE1, poly(2e-5, -2.001e-3), "$.components[1].poles", '"bearing" is unstable at PWM 101: pole 1.9e-05'),
    (POLE1, poly(0), "$.components[1].poles", "unstable at PWM 0: pole 0 rad/s"),
    (
        (*C1, "gain"),
        poly(-1e-6, 1.505e-4),
        "$.components[1].gain",
        "at PWM 151, inside the validity range 51..255",
    ),
    ((*C1, "gain"), poly(1e-6, -1.05e-5), "$.components[1].gain", "at PWM 1..10, outside the validity range"),
    ((*C1, "gain"), {"exp1": [1, 100]}, "$.components[1].gain", "overflows a 64-bit float at PWM 8"),
    ((*C1, "gain"), {"exp1": [1, 1e200]}, "$.components[1].gain", "overflows a 64-bit float at PWM 1"),
    (
        (*C1, "gain"),
        {"table": {"pwm": [0, 255], "value": [1, -1.1e300], "interpolation": "pchip"}},
        "$.components[1].gain.table.value[1]",
        "found -1.1e+300, expected at least -1e+300",
    ),
    (POLE1, {"exp2": [-1, 1e9, 1, 1e9]}, "$.components[1].poles", "overflows a 64-bit float at PWM 1"),
    ((*C1, "gain"), poly(194.6), "$.components[1].gain", "the units of gain and poles do not fit together"),
    (POLE1, poly(-1e-300), "$.components[1].gain", "settles"),
    (
        (*C0, "negative_gain"),
        DELETE,
        "$.components[0].gain",
        'PWM 1..2, outside the validity range 51..255; add "neg',
    ),
]


@pytest.mark.parametrize(("where", "value", "place", "message"), PHYSICS)
def test_physics(where: Path_, value: object, place: str, message: str) -> None:
    error = failure(changed((where, value)))
    assert error.place == place
    assert message in error.message


def test_complex_pair_that_crosses_the_axis_at_order_three() -> None:
    """Order 3 with real parts that turn positive from PWM 200 on."""
    real = {"table": {"pwm": [0, 199, 200, 255], "value": [-1e-3, -1e-5, 1e-5, 1e-5], "interpolation": "linear"}}
    poles = [
        {"real": real, "imag": poly(2e-3)},
        {"real": real, "imag": poly(-2e-3)},
        {"real": poly(-1e-2)},
    ]
    error = failure(changed(((*C0, "poles"), poles)))
    assert error.place == "$.components[0].poles"
    assert '"brush" is unstable at PWM 200: pole 1e-05' in error.message
    assert "0.002j" in error.message


def table(pwm: list[object], value: list[object], interpolation: str = "pchip") -> dict[str, Any]:
    return {"table": {"pwm": pwm, "value": value, "interpolation": interpolation}}


@pytest.mark.parametrize(
    ("entry", "place", "message"),
    [
        (table([0, 9, 9], [1, 1, 1]), ".table.pwm[2]", "found 9 after 9, expected strictly increasing PWM"),
        (table([0, 9], [1, 1, 1]), ".table.value", "found 3 values, expected 2, one per PWM"),
        (table([0], [1]), ".table.pwm", "found 1 entry, expected at least 2"),
        (table([0, 256], [1, 1]), ".table.pwm[1]", "found 256, expected at most 255"),
        (table([0, 9.5], [1, 1]), ".table.pwm[1]", "found 9.5, expected a whole number"),
        (table([0, 9], [1, 1], "spline"), ".table.interpolation", 'expected "pchip" or "linear"'),
    ],
)
def test_tables(entry: object, place: str, message: str) -> None:
    error = failure(changed((GAIN0, entry)))
    assert error.place == f"$.components[0].gain{place}"
    assert message in error.message


TEXTS: list[tuple[Callable[[bytes], bytes], str, str]] = [
    (lambda t: t[:40], "line 3, column 2", "not valid JSON"),
    (lambda t: t.replace(b'"version": 1,', b'"version": 1'), "line 4, column 2", "expecting ',' delimiter"),
    (lambda t: b"", "", "the file is empty"),
    (lambda t: b" \n", "", "the file is empty"),
    (lambda t: b"[]", "$", "found a list of 0, expected an object"),
    (lambda t: b"[" * 100_000, "$", "nested too deeply"),
    (lambda t: t.replace(b'"order": 3', b'"order": 3, "order": 3'), "$.components[0].order", "appears twice"),
    (
        lambda t: t.replace(b"-1.912e-10", b"NaN"),
        "$.components[0].gain.poly[2]",
        "found NaN, expected a finite",
    ),
    (lambda t: t.replace(b"-1.912e-10", b"-Infinity"), "$.components[0].gain.poly[2]", "found -Infinity"),
    (
        lambda t: t.replace(b"-1.912e-10", b"1e999"),
        "$.components[0].gain.poly[2]",
        "found 1e999, which overflows",
    ),
    (lambda t: t.replace(b"-1.912e-10", b"9" * 5000), "$.components[0].gain.poly[2]", "(5000 characters)"),
    (lambda t: t.replace(b"Carbon", b"Ca\xffbon"), "line 15", "byte 0xff is not UTF-8"),
    (lambda t: t.decode().encode("utf-16"), "line 1", "byte 0xff is not UTF-8"),
]


@pytest.mark.parametrize(("change", "place", "message"), TEXTS)
def test_texts(change: Callable[[bytes], bytes], place: str, message: str) -> None:
    with pytest.raises(InputError) as caught:
        parse(change(RAW))
    assert (caught.value.place or "") == place
    assert message in caught.value.message


def test_the_message_names_the_file(tmp_path: Path) -> None:
    file = tmp_path / "bad.json"
    file.write_text("{", encoding="utf-8")
    with pytest.raises(InputError) as caught:
        load(file)
    assert str(caught.value).startswith(f"{file}: line 1, column 2: not valid JSON")


@pytest.mark.parametrize(("name", "message"), [("none.json", "no such file"), ("", "is a directory")])
def test_files_that_are_none(tmp_path: Path, name: str, message: str) -> None:
    with pytest.raises(InputError, match=message) as caught:
        load(tmp_path / name)
    assert caught.value.file == str(tmp_path / name)


json_values = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False, allow_infinity=False) | st.text(),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=5), inner, max_size=3),
    max_leaves=6,
)


def places(node: object, path: Path_ = ()) -> list[Path_]:
    items = node.items() if isinstance(node, dict) else enumerate(node) if isinstance(node, list) else ()
    below = [place for key, value in items for place in places(value, (*path, key))]
    return ([path] if path else []) + below


@settings(max_examples=300, deadline=None)
@given(st.sampled_from(places(BASE)), json_values)
def test_anything_anywhere_is_taken_or_named(where: Path_, value: object) -> None:
    """Whatever stands anywhere, the file loads or one InputError with a place says why not."""
    try:
        parse(json.dumps(changed((where, value))).encode())
    except InputError as error:
        assert error.place
        assert error.message


@settings(max_examples=200, deadline=None)
@given(st.binary(max_size=200) | st.text(max_size=200).map(lambda t: t.encode("utf-8", "surrogatepass")))
def test_any_bytes(raw: bytes) -> None:
    with pytest.raises(InputError):
        parse(raw)


@pytest.mark.parametrize(
    ("names", "said"),
    [(["casing"], '"casing"'), (["casing", "brush"], '"casing" or "brush"'), (["a", "b", "c"], '"a", "b" or "c"')],
)
def test_what_was_expected_reads_as_a_sentence(names: list[str], said: str) -> None:
    assert listed(names) == said
