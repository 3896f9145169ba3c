"""Networks on the emulated board and on this computer against the reference, word for word, and what they cost."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from gen.avr.compile import build_elf
from gen.avr.simulator import MAILBOX_FOLDER
from gen.coefficients import Coefficients, load
from gen.firmware import render
from gen.firmware.context import project_context
from gen.lowering.kinds import Arithmetic
from gen.lowering.lower import lower
from gen.verification import compare
from gen.verification.profiles import Profile, campaign, with_channels
from gen.verification.runners import AvrRunner, HostRunner, Library, write_library
from tests.drawn_networks import drawn, with_laws
from tests.examples import ROOT

LANES, SAMPLES = 3, 40
#: Nodes of each network, by its seed; what else it has is drawn.
SIZES = (1, 2, 4, 6, 7, 10)


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
@pytest.mark.parametrize(("seed", "size"), [(0, 1), (1, 3), (3, 5), (4, 6)])
def test_networks_with_laws_agree_word_for_word(seed: int, size: int, arithmetic: Arithmetic, tmp_path: Path) -> None:
    emitted = library(written(with_laws(seed, size), tmp_path), tmp_path, arithmetic)
    profile = profile_of(emitted)
    expected = compare.reference_run(emitted.program, profile)
    mega = AvrRunner(emitted, tmp_path / "cache")
    assert compare.first_mismatch(expected, HostRunner(emitted, "g++ sanitized").run(profile)) is None
    assert compare.first_mismatch(expected, mega.run(profile)) is None
    assert arithmetic == "float" or mega.helper_symbols() == []


@pytest.mark.parametrize("law", ["convection", "radiation"])
def test_a_law_takes_under_1500_cycles(law: str, tmp_path: Path) -> None:
    """Its whole path, beside the other paths of the closed motor; the bound is 1e-4 K."""
    tree = json.loads((ROOT / "examples" / "natural_cooling" / "coeffs.json").read_text())
    tree["accuracy"]["fixed_limit_K"] = 1e-3
    cycles = []
    for kinds in ((), (law,)):
        paths = [path for path in tree["network"]["paths"] if not {"convection", "radiation"} & set(path)]
        paths += [path for path in tree["network"]["paths"] if any(kind in path for kind in kinds)]
        folder = tmp_path / str(len(kinds))
        folder.mkdir()
        own = {**tree, "network": {**tree["network"], "paths": paths}}
        emitted = library(written(own, folder), folder)
        mega, profile = AvrRunner(emitted, tmp_path / "cache"), profile_of(emitted)
        mega.run(profile)
        cost = mega.cost(profile)
        cycles.append(max(cost.cycles_constant, cost.cycles_change))
    assert cycles[1] - cycles[0] < 1500


def test_the_closed_motor_stays_within_what_was_asked(tmp_path: Path) -> None:
    emitted = library(load(ROOT / "examples" / "natural_cooling" / "coeffs.json"), tmp_path)
    assert emitted.program.network is not None
    assert max(node.proof.bound_K for node in emitted.program.network.components()) <= 1e-4


@pytest.mark.parametrize("arithmetic", ["fixed", "float"])
@pytest.mark.parametrize("optimisation", ["-O0", "-Os"])
def test_the_boards_compiler_has_nothing_to_warn_of(arithmetic: Arithmetic, optimisation: str, tmp_path: Path) -> None:
    emitted = library(written(drawn(5, 6), tmp_path), tmp_path, arithmetic)
    sources = [tmp_path / "verify_avr.cpp", *emitted.sources]
    build_elf(sources, [MAILBOX_FOLDER, emitted.include], tmp_path / "model.elf", optimisation=optimisation)
