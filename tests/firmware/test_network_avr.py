"""Networks on the emulated board and on this computer against the reference, word for word, and what they cost."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gen.avr.compile import build_elf
from gen.avr.simulator import MAILBOX_FOLDER
from gen.coefficients import Coefficients, load
from gen.firmware import render
from gen.firmware.context import project_context
from gen.lowering.kinds import Arithmetic
from gen.lowering.lower import lower
from gen.verification import compare
from gen.verification.effects import with_channels
from gen.verification.profiles import Profile, campaign
from gen.verification.runners import AvrRunner, HostRunner, Library, write_library

LANES, SAMPLES = 3, 40
#: Nodes of each network, by its seed; what else it has is drawn.
SIZES = (1, 2, 4, 6, 7, 10)


def drawn(seed: int, size: int) -> dict[str, Any]:
    """A coefficient file with a random network: a tree, some more paths, and every kind of term in some of them."""
    rng = np.random.default_rng(seed)

    def pick(*chances: float) -> int:
        return int(rng.choice(len(chances), p=np.array(chances) / sum(chances)))

    channels = [
        {"column": "fan_percent", "range": [0, 100], "neutral": 0},
        {"column": "current_A", "range": [-12.5, 20.125], "neutral": 0},
    ][: seed % 3]

    def factors() -> dict[str, Any]:
        if not channels or pick(2, 1) == 0:
            return {}
        fan = {
            "channel": "fan_percent",
            "table": {"at": [0, 30.5, 100], "value": [1, *rng.uniform(0.4, 3.0, 2).round(3)]},
        }
        square = {"channel": "current_A", "poly": [*rng.uniform(0.0005, 0.005, 1).round(5), 0.0, 0.2]}
        return {"factors": [fan, square][: 1 + pick(1, 1)] if len(channels) > 1 else [fan]}

    def curve(scale: float) -> dict[str, Any]:
        kind, a, b = pick(2, 2, 1), *np.round(scale * rng.uniform(0.2, 1.0, 2), 4)
        if kind == 0:
            return {"poly": [a]}
        made: dict[str, Any] = {"power": {"constant": a, "forced": b, "exponent": 0.8}}
        return made if kind == 1 else {**made, "at_rest": round(float(a) / 2, 4)}

    def name(k: int) -> str:
        return f"part{k}"

    pairs = [(k, int(rng.integers(0, k))) for k in range(1, size)]
    pairs += [(a, b) for a in range(size) for b in range(a) if (a, b) not in pairs and rng.random() < 0.15]
    paths = [{"between": [name(a), name(b)], "conductance_W_per_K": curve(1.5), **factors()} for a, b in pairs]
    warm = sorted({0, *(k for k in range(size) if rng.random() < 0.4)})
    paths += [{"between": [name(k), "ambient"], "conductance_W_per_K": curve(1.6), **factors()} for k in warm]
    heats = []
    for k in range(size):
        power = {"poly": [round(float(rng.uniform(1e-5, 2e-4)), 7), round(float(rng.uniform(0, 0.02)), 5), 0]}
        growth = {"per_K": [0.0015, -0.001][pick(1, 1)], "reference_degC": 25} if pick(2, 1) else {}
        heats += [{"node": name(k), "power_W": power, **growth, **factors()}]
    nodes = []
    for k in range(size):
        sensor = {"offset_K": float(np.round(rng.normal(), 2)), "lag_s": [0.0, 6.0][pick(3, 1)]}
        shown = {"sensor": sensor} if k == 0 or rng.random() < 0.7 else {}
        nodes.append({"name": name(k), "capacity_J_per_K": float(np.round(rng.uniform(40, 900), 1)), **shown})
    return {
        "format": "gen-coefficients",
        "version": 2,
        "name": f"drawn{seed}",
        "sample_time_s": 0.25,
        "input": {"name": "pwm", "full_scale": 255, "nominal_speed_rpm": 2650},
        "ambient": {"fixed_degC": 25, "channel": "ambient_degC"},
        "validity": {"pwm": [[0, 255], [20, 230]][seed % 2], "outside": "hold"},
        "domain": {"pwm": [[0, 255], [10, 240]][seed % 2], "ambient_degC": [0, 45], "temperature_degC": [-10, 120]},
        "accuracy": {"fixed_limit_K": 1.0, "float_limit_K": 10.0},
        "network": {"channels": channels, "nodes": nodes, "paths": paths, "heats": heats},
    }


def written(file: dict[str, Any], folder: Path) -> Coefficients:
    path = folder / "coeffs.json"
    path.write_text(json.dumps(file))
    return load(path)


def library(coefficients: Coefficients, folder: Path, arithmetic: Arithmetic = "fixed") -> Library:
    program = lower(coefficients, arithmetic, "table")
    context = project_context(coefficients, program, "coeffs.json")
    return write_library(program, context, render.library(context), folder)


def profile_of(emitted: Library) -> Profile:
    program = emitted.program
    return with_channels(campaign(program.model, LANES, SAMPLES, seed=3), program.channels)


@pytest.mark.parametrize(("seed", "size"), list(enumerate(SIZES)))
def test_the_board_the_computer_and_the_reference_agree_word_for_word(seed: int, size: int, tmp_path: Path) -> None:
    emitted = library(written(drawn(seed, size), tmp_path), tmp_path)
    profile = profile_of(emitted)
    expected = compare.reference_run(emitted.program, profile)
    mega = AvrRunner(emitted, tmp_path / "cache")
    assert compare.first_mismatch(expected, HostRunner(emitted, "g++ sanitized").run(profile)) is None
    assert compare.first_mismatch(expected, mega.run(profile)) is None
    assert mega.helper_symbols() == []  # no 64-bit arithmetic, no float


def six_nodes() -> dict[str, Any]:
    """A motor: four sensed parts, the winding and the air inside, ten paths of which six change with |PWM|."""

    def turning(constant: float, forced: float) -> dict[str, Any]:
        return {"power": {"constant": constant, "forced": forced, "exponent": 0.8}}

    paths: list[tuple[str, str, dict[str, Any]]] = [
        ("winding", "magnet", turning(0.5, 0.9)),
        ("winding", "bearing", {"poly": [0.32]}),
        ("winding", "brush", {"poly": [0.41]}),
        ("winding", "air", turning(0.2, 0.5)),
        ("air", "casing", turning(0.3, 0.6)),
        ("brush", "casing", {"poly": [0.36]}),
        ("bearing", "casing", {"poly": [0.55]}),
        ("magnet", "casing", {"poly": [3.1]}),
        ("casing", "ambient", {**turning(0.9, 0.8), "at_rest": 0.8}),
        ("bearing", "ambient", turning(0.04, 0.1)),
    ]
    sensed = {"bearing": 95, "brush": 62, "magnet": 640, "casing": 1450}
    hidden = {"winding": 310, "air": 180}
    heats = {
        "winding": [3.6e-4, 0, 0],
        "brush": [1.1e-5, 0.031, 0],
        "bearing": [4e-5, 0.012, 0],
        "magnet": [2e-5, 6e-3, 0],
    }
    file = drawn(0, 1)
    file["name"] = "six"
    del file["accuracy"]
    file["network"] = {
        "channels": [],
        "nodes": [{"name": name, "capacity_J_per_K": c, "sensor": {}} for name, c in sensed.items()]
        + [{"name": name, "capacity_J_per_K": c} for name, c in hidden.items()],
        "paths": [{"between": [a, b], "conductance_W_per_K": curve} for a, b, curve in paths],
        "heats": [{"node": name, "power_W": {"poly": poly}} for name, poly in heats.items()],
    }
    return file


def test_six_nodes_stay_within_what_was_asked(tmp_path: Path) -> None:
    """At most 6 000 cycles a sample, 40 KB of flash, 120 bytes of RAM and 1e-5 K."""
    emitted = library(written(six_nodes(), tmp_path), tmp_path)
    assert emitted.program.network is not None
    profile = profile_of(emitted)
    mega = AvrRunner(emitted, tmp_path / "cache")
    found = mega.run(profile)
    assert compare.first_mismatch(compare.reference_run(emitted.program, profile), found) is None
    cost = mega.cost(profile)
    assert max(cost.cycles_constant, cost.cycles_change) < 6000
    assert cost.flash_bytes < 40_000
    assert cost.ram_bytes <= 120
    assert max(node.proof.bound_K for node in emitted.program.network.components()) <= 1e-5


@pytest.mark.parametrize("arithmetic", ["fixed", "float"])
@pytest.mark.parametrize("optimisation", ["-O0", "-Os"])
def test_the_boards_compiler_has_nothing_to_warn_of(arithmetic: Arithmetic, optimisation: str, tmp_path: Path) -> None:
    emitted = library(written(drawn(5, 6), tmp_path), tmp_path, arithmetic)
    sources = [tmp_path / "verify_avr.cpp", *emitted.sources]
    build_elf(sources, [MAILBOX_FOLDER, emitted.include], tmp_path / "model.elf", optimisation=optimisation)
