"""Hazards of thermocouples: what is wrong with a word, and when."""

from __future__ import annotations

import random
from collections.abc import Iterable

from benchmarks.hazards.hazard import Script, add, hazard
from benchmarks.hazards.plant import Lie
from benchmarks.hazards.scene import Scene
from gen.emulate.plants.plant import AMBIENT, word_of

PARTS = ("brush", "bearing", "magnet", "casing")
AS_THE_MODEL = {"brush": 0.004, "bearing": 0.019, "magnet": 0.019, "casing": 0.018}
"""K/s at full current: what the MY1016's model says of the first minutes from cold."""
RUN_S = 75.0
"""Long enough for every part to pass its limit, where nothing stops the motor."""


def open_wire(degC: float, _: float) -> int:
    """What a MAX6675 says of an open thermocouple."""
    return word_of(degC) | 0x0004


def zeros(_degC: float, _: float) -> int:
    """A data line at ground, or a MAX6675 below 0 degC."""
    return 0


def ones(_degC: float, _: float) -> int:
    """A data line at the supply, or a converter without power."""
    return 0xFFFF


def frozen_at(degC: float) -> Lie:
    """One and the same word for ever."""
    return lambda _degC, _time: word_of(degC)


def fallen_off(room_degC: float = 25.0) -> Lie:
    """A thermocouple that is in the room, not in the motor."""
    return frozen_at(room_degC + 0.5)


def half(degC: float, _: float) -> int:
    """A MAX31855 at 25 degC: read as a MAX6675 it is half of what it measures."""
    return (round(degC * 4.0) & 0x3FFF) << 18 | 25 * 16 << 4


def shifted(degC: float, _: float) -> int:
    """A clock edge too many: all bits one place up."""
    return word_of(degC) << 1


def stuck_bit(degC: float, _: float) -> int:
    """A bit of 32 degC that is always 0, from crosstalk at one place of the word."""
    return word_of(degC) & ~(128 << 3)


def drifting(scene: Scene, K_per_s: float) -> Lie:
    """Farther and farther below the truth."""
    began_s = scene.plant.time_s
    return lambda degC, time_s: word_of(max(degC - K_per_s * (time_s - began_s), 1.0))


def noisy(sigma_K: float) -> Lie:
    """Noise."""
    drawn = random.Random(1)
    return lambda degC, _: word_of(max(drawn.gauss(degC, sigma_K), 1.0))


def loose(degC: float, time_s: float) -> int:
    """A loose contact: open for a second in every two."""
    return open_wire(degC, time_s) if int(time_s) % 2 else word_of(degC)


def now(part: str, scene: Scene) -> Lie:
    """The word that it gives now, for ever."""
    return frozen_at(scene.plant.temperatures[part])


def _at_start(parts: Iterable[str], lie: Lie) -> Script:
    def script(scene: Scene) -> None:
        scene.plant.lies |= dict.fromkeys(parts, lie)
        scene.wait(0.5)
        scene.begins()
        scene.start()
        scene.wait(12.0)
        scene.drive(255)  # whoever drives tries again once the board has started
        scene.wait(RUN_S)

    return script


def _while_running(parts: Iterable[str], lie: Lie) -> Script:
    def script(scene: Scene) -> None:
        scene.start()
        scene.plant.lies |= dict.fromkeys(parts, lie)
        scene.begins()
        scene.wait(RUN_S)

    return script


_WORDS: dict[str, tuple[str, Lie]] = {
    "open": ("thermocouple open", open_wire),
    "zeros": ("data line at ground", zeros),
    "ones": ("data line at the supply", ones),
    "room": ("thermocouple fell off, reads the room", fallen_off()),
    "shifted": ("words shifted by a clock edge", shifted),
}
for _name, (_cause, _lie) in _WORDS.items():
    add(f"{_name}-start", f"brush: {_cause}, from the start", _at_start(["brush"], _lie))
    add(f"{_name}-running", f"brush: {_cause}, while running", _while_running(["brush"], _lie))
    add(f"{_name}-all-start", f"all parts: {_cause}, from the start", _at_start(PARTS, _lie))
    add(f"{_name}-all-running", f"all parts: {_cause}, while running", _while_running(PARTS, _lie))
add("max31855", "brush: MAX31855 in place of a MAX6675", _at_start(["brush"], half), others=("brush",))
add("max31855-all", "all parts: MAX31855 in place of a MAX6675", _at_start(PARTS, half), others=PARTS)
add("open-two", "brush and casing: open", _while_running(["brush", "casing"], open_wire), faults=2)
add("loose", "brush: loose contact, open every other second", _while_running(["brush"], loose))
add("bit", "brush: the bit of 32 degC always 0", _while_running(["brush"], stuck_bit))
add("noise-3", "brush: noise, sigma 3 K", _while_running(["brush"], noisy(3.0)))
add("noise-20", "brush: noise, sigma 20 K", _while_running(["brush"], noisy(20.0)))
add("jump-up", "brush: reads 140 degC at once", _while_running(["brush"], frozen_at(140.0)))
add("jump-down", "brush: reads 60 degC at once", _while_running(["brush"], frozen_at(60.0)))
add("frozen-start", "brush: always 90 degC, from the start", _at_start(["brush"], frozen_at(90.0)))
add("ambient-open", "ambient: open, while running", _while_running([AMBIENT], open_wire))
add("ambient-zeros", "ambient: below 0 degC, from the start", _at_start([AMBIENT], zeros))
add("ambient-hot", "ambient: reads 45 degC for ever", _while_running([AMBIENT], frozen_at(45.0)))


@hazard("frozen", "brush: the same word for ever; it warms 0.5 K/s")
def _frozen(scene: Scene) -> None:
    scene.start()
    scene.plant.lies["brush"] = now("brush", scene)
    scene.begins()
    scene.wait(RUN_S)


@hazard("frozen-all", "all parts: the same words for ever; they warm 0.4 to 0.5 K/s")
def _frozen_all(scene: Scene) -> None:
    scene.start()
    scene.plant.lies |= {part: now(part, scene) for part in PARTS}
    scene.begins()
    scene.wait(RUN_S)


@hazard("frozen-slow", "brush: the same word for ever; it warms 0.06 K/s from 110 degC")
def _frozen_slow(scene: Scene) -> None:
    scene.plant.temperatures["brush"] = 110.0
    scene.plant.heating |= {"brush": 0.2, "bearing": 0.11, "magnet": 0.11, "casing": 0.11}
    scene.start()
    scene.plant.lies["brush"] = now("brush", scene)
    scene.begins()
    scene.wait(28 * 15.0)


def _frozen_while_healthy(parts: Iterable[str]) -> Script:
    def script(scene: Scene) -> None:
        scene.plant.temperatures |= dict.fromkeys(PARTS, scene.plant.room_degC)
        scene.plant.heating |= AS_THE_MODEL
        scene.start()
        scene.plant.lies |= {part: now(part, scene) for part in parts}
        scene.begins()
        scene.wait(400.0)

    return script


add(
    "frozen-healthy",
    "bearing: the same word for ever; the motor begins cold and warms as the model says",
    _frozen_while_healthy(["bearing"]),
)
add("frozen-all-healthy", "all parts: the same words for ever, likewise", _frozen_while_healthy(PARTS))


@hazard("drift", "brush: drifts down as fast as the part warms, 0.5 K/s")
def _drift(scene: Scene) -> None:
    scene.start()
    scene.plant.lies["brush"] = drifting(scene, 0.5)
    scene.begins()
    scene.wait(RUN_S)


@hazard("drift-slow", "brush: drifts down 0.05 K/s")
def _drift_slow(scene: Scene) -> None:
    scene.start()
    scene.plant.lies["brush"] = drifting(scene, 0.05)
    scene.begins()
    scene.wait(RUN_S)


def _exchange(scene: Scene) -> None:
    """Brush and bearing have each other's thermocouple."""
    truth = scene.plant.temperatures
    scene.plant.lies |= {
        "brush": lambda _degC, _time: word_of(truth["bearing"]),
        "bearing": lambda _degC, _time: word_of(truth["brush"]),
    }


def _reverse(scene: Scene) -> None:
    """The brush's thermocouple reads as much below the room as the brush is above."""
    room = scene.plant.room_degC
    scene.plant.lies["brush"] = lambda degC, _: word_of(max(2.0 * room - degC, 0.0))


@hazard("swapped", "brush and bearing exchanged")
def _swapped(scene: Scene) -> None:
    _exchange(scene)
    scene.start()
    scene.begins()
    scene.wait(RUN_S)


@hazard("reversed", "brush: leads exchanged; warmer reads colder, about the room")
def _reversed(scene: Scene) -> None:
    _reverse(scene)
    scene.wait(0.5)
    scene.begins()
    scene.start()
    scene.wait(RUN_S)


def _found_by_hand(fault: Script) -> Script:
    """Somebody begins to commission the cold motor, warms its brush by hand, and later drives it all the same."""

    def script(scene: Scene) -> None:
        hot = dict(scene.plant.temperatures)
        scene.plant.temperatures |= dict.fromkeys(hot, scene.plant.room_degC)
        fault(scene)
        scene.wait(4.0)
        scene.begins()
        scene.send("commission")
        scene.wait(15.0)
        for _ in range(8):
            scene.plant.temperatures["brush"] += 1.0
            scene.wait(1.0)
        scene.board.mega.cut_power(1.0)
        scene.plant.temperatures |= hot
        scene.start()
        scene.wait(12.0)
        scene.drive(255)
        scene.wait(RUN_S)

    return script


add(
    "swapped-commissioned",
    "brush and bearing exchanged, a board that wants commissioning",
    _found_by_hand(_exchange),
    board="commissioned",
)
add(
    "reversed-commissioned",
    "brush: leads exchanged, a board that wants commissioning",
    _found_by_hand(_reverse),
    board="commissioned",
)


@hazard("brush-260", "brush at 260 degC at the start, beyond the sensor's range")
def _brush_260(scene: Scene) -> None:
    scene.plant.temperatures["brush"] = 260.0
    scene.begins()
    scene.start()
    scene.wait(20.0)
    scene.drive(255)
    scene.wait(15.0)


@hazard("hot-start", "brush at 130 degC at the start")
def _hot_start(scene: Scene) -> None:
    scene.plant.temperatures["brush"] = 130.0
    scene.begins()
    scene.start()
    scene.wait(20.0)
    scene.drive(255)
    scene.wait(15.0)


def _rising(K_per_s: float) -> Script:
    def script(scene: Scene) -> None:
        scene.start(100)
        scene.plant.heating["brush"] = K_per_s
        scene.drive(255)
        scene.begins()
        scene.wait(60.0)

    return script


for _rate in (1.0, 2.0, 4.0, 8.0):
    add(f"rise-{_rate:g}", f"brush: a real rise of {_rate:g} K/s", _rising(_rate))
add("rise-8-plain", "brush: a real rise of 8 K/s, board without a relay", _rising(8.0), board="plain")
add("open-plain", "brush: open, board without a relay", _while_running(["brush"], open_wire), board="plain")
