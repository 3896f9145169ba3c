"""Only `gen/coefficients/` knows the keys of the coefficient file, for reading and for writing."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

from gen.coefficients.schema import json_schema
from gen.model.effects import registry

GEN = Path(__file__).parents[2] / "gen"

SCHEMA = json_schema()
OBJECTS = {"Document": SCHEMA} | {name: part for name, part in SCHEMA["$defs"].items() if "properties" in part}

#: Words that are names elsewhere by right: a run file's columns, and what an effect calls its own parameters.
ELSEWHERE = {"pwm", "ambient_degC"} | {key for effect in registry().values() for key in effect.parameters.model_fields}
KEYS = {key for part in OBJECTS.values() for key in part["properties"]} - ELSEWHERE

#: Other formats with words of the same name: module -> the words, by what they are keys of.
OTHER_FORMATS = {
    # answers of Prometheus' API, of InfluxDB's, of Grafana's
    "importing/reading/tagged/prometheus.py": {"data", "value"},
    "importing/reading/tagged/signals.py": {"data", "name", "unit"},
    # Telegraf's records
    "importing/reading/tagged/tagged_records.py": {"name"},
    # the JSON summary of `gen refine` (and, of the Python interface, that of `gen identify`)
    "commands/refine.py": {"name", "component", "parameters", "evidence"},
    "interface/identification.py": {"components", "order", "value", "network"},
    "interface/refinement.py": {"name", "component", "parameters", "evidence"},
    "refinement/parts/page.py": {"name", "component", "parameters", "evidence", "note"},
    "refinement/network/page.py": {"name", "component", "parameters", "evidence", "note"},
    "refinement/parts/residual_charts.py": {"component"},
    # the JSON summary of `gen identify`: a measured error by speed, a fitted number with its interval
    "identification/parts/page.py": {"components"},
    "identification/network/telling/page.py": {
        "between",
        "conductance_W_per_K",
        "heats",
        "name",
        "node",
        "nodes",
        "paths",
        "power_W",
    },
    "identification/parts/summary.py": {"components", "value", "model_minus_measured_K"},
    "identification/network/telling/as_json.py": {"value"},
    "identification/network/telling/text.py": {"value"},
    # what a part may follow: another part of the run, or the room
    "identification/logs/room_followers.py": {"ambient"},
    # times and lines as loggers write them, the mapping file of `gen import`, comments of a run file
    "importing/clock.py": {"min"},
    "importing/guessing/evidence.py": {"unit"},
    "importing/provenance.py": {"input"},
    "importing/reading/pairs.py": {"value", "unit"},
    "importing/units.py": {"unit"},
    "importing/mapping.py": {"input"},
    # the manifest of a project
    "certificate/claims.py": {"components", "name"},
    # the certificate of a network
    "certificate/network/document.py": {"components"},
    "firmware/network_certificate.py": {"components", "factors", "paths"},
    # faults, channels and results of `gen emulate`
    # an HTTP request, a row
    "live/access.py": {"method"},
    "live/view.py": {"alarms", "protection"},
    "live/heat.py": {"alarms"},
    "live/signals.py": {"alarms", "protection"},
    "commands/emulate.py": {"alarms", "profile", "ambient", "encoder"},
    "emulate/results.py": {"alarms", "protection"},
    # contexts of templates, and lists of names in them
    "firmware/context.py": {"name", "channels"},
    "firmware/contexts/network.py": {"constant"},
    "firmware/contexts/network_terms.py": {"constant", "heats", "note"},
    "firmware/contexts/network_words.py": {"note"},
    "firmware/contexts/effects.py": {"name", "heats"},
    "firmware/sketch/device.py": {"board", "channels", "encoder", "observe", "memory", "supply", "zero"},
    "firmware/sketch/drive.py": {"direction"},
    "firmware/sketch/inputs.py": {"pin"},
    "firmware/sketch/rows.py": {"ambient"},
    "firmware/sketch/sensors.py": {"column"},
    "firmware/effects_report.py": {"effects"},
    "firmware/render.py": {"name", "effects"},
    "firmware/wiring_svg.py": {"board", "channels", "encoder", "drive", "column", "observe", "direction"},
    # a fleet's store: a run's metadata, a form of the network as a task's arguments, a task's arrays; fsspec's protocol
    "fleet/alarm_thresholds.py": {"name"},
    "fleet/tasks/common.py": {"constant", "paths"},
    "fleet/folder/run_bytes.py": {"ambient", "components", "version"},
    "fleet/folder/store.py": {"memory"},
    # a word of a file, and no key: what a negative gain is taken as
    "model/dynamics.py": {"zero"},
    # a frame's attributes, parameters of an optimiser, fields of the study's targets, the rig's own paths, columns of a
    # verification
    "interface/files.py": {"name"},
    "identification/parts/output_error.py": {"value"},
    "rig/calibrate/targets.py": {"speed_percent", "duration_s"},
    "rig/calibrate/unknowns.py": {"forced"},
    "verification/profiles.py": {"channels"},
    "verification/runners.py": {"name"},
}
#: Where a dict with such keys is no object of the file: an effect's values, which may be a channel or an offset alone.
VALUES = ("airflow", "load_heating", "sensor_offset", "supply_voltage")
OTHER_DICTS = {f"model/effects/catalogue/{name}.py" for name in VALUES} | {
    "firmware/certificate.py",  # the certificate's own form of an equation
    "firmware/network_certificate.py",
    "identification/network/telling/as_json.py",  # the JSON summary of `gen identify`
    # the JSON summary of `gen refine`: a channel that an effect reads, an effect
    *(f"refinement/network/effects/{name}.py" for name in ("airflow", "load_heating", "supply_voltage")),
    "refinement/network/entries.py",
}


def keys_used(tree: ast.AST) -> Iterator[tuple[str, int]]:
    """Keys of the file by which anything is looked up: ``x["key"]``, ``x.get("key")`` and the like, ``"key" in x``."""
    for node in ast.walk(tree):
        key: ast.expr | None = None
        if isinstance(node, ast.Subscript):
            key = node.slice
        elif isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute) and node.args:
            key = node.args[0] if node.func.attr in ("get", "pop", "setdefault") else None
        elif isinstance(node, ast.Compare) and isinstance(node.ops[0], (ast.In, ast.NotIn)):
            key = node.left
        if isinstance(key, ast.Constant) and key.value in KEYS:
            yield str(key.value), node.lineno  # type: ignore[attr-defined]


def objects_built(tree: ast.AST) -> Iterator[tuple[str, int]]:
    """Dict literals, and calls of dict(), with all keys that an object of the file must have, and no foreign one."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Dict):
            keys = {key.value if isinstance(key, ast.Constant) else None for key in node.keys}
        elif isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "dict":
            keys = {keyword.arg for keyword in node.keywords}
        else:
            continue
        keys -= {None}  # ** of another dict
        for name, part in OBJECTS.items():
            if keys and set(part.get("required", ())) <= keys <= set(part["properties"]):
                yield name, node.lineno


def modules() -> list[Path]:
    return [path for path in sorted(GEN.rglob("*.py")) if path.relative_to(GEN).parts[0] != "coefficients"]


def test_no_other_room_looks_anything_up_by_a_key_of_the_file() -> None:
    found = [
        f"{name}:{line}: {key}"
        for path in modules()
        for name in [path.relative_to(GEN).as_posix()]
        for key, line in keys_used(ast.parse(path.read_text(encoding="utf-8")))
        if key not in OTHER_FORMATS.get(name, set())
    ]
    assert found == [], "\n".join(found)


def test_no_other_room_builds_an_object_of_the_file_from_keys() -> None:
    found = [
        f"{name}:{line}: {part}"
        for path in modules()
        for name in [path.relative_to(GEN).as_posix()]
        for part, line in objects_built(ast.parse(path.read_text(encoding="utf-8")))
        if name not in OTHER_DICTS
    ]
    assert found == [], "\n".join(found)


@pytest.mark.parametrize(
    ("source", "looked_up", "built"),
    [
        ('tree["alarms"] = []', ["alarms"], []),
        ('tree.setdefault("provenance", x)["error"] = y', ["error", "provenance"], []),
        ('if "threshold_K" not in rule: pass', ["threshold_K"], []),
        ('{"component": a, "pwm": b, "model_minus_measured_K": c, "note": d}', [], ["ErrorBand"]),
        ("dict(component=a, pwm=b, model_minus_measured_K=c)", [], ["ErrorBand"]),
        ('{"poly": c}', [], ["ConvectionEntry", "Poly", "PolyCurve"]),
        ('{"real": r, **more}', [], ["PoleEntry"]),
        ('columns["pwm"]; band.pwm; {"colour": 1}; x["colour"]', [], []),
    ],
)
def test_the_rule_sees_what_it_is_for(source: str, looked_up: list[str], built: list[str]) -> None:
    tree = ast.parse(source)
    assert sorted(key for key, _ in keys_used(tree)) == looked_up
    assert [name for name, _ in objects_built(tree)] == built
