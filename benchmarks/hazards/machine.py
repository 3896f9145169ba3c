"""Hazards of the motor, its driver, its relay and its encoder."""

from __future__ import annotations

from benchmarks.hazards.hazard import Script, add, hazard
from benchmarks.hazards.scene import Scene

RUN_S = 75.0


def _locked_at_start(pwm: int = 255) -> Script:
    def script(scene: Scene) -> None:
        scene.plant.locked = True
        scene.wait(4.0)
        scene.begins()
        scene.drive(pwm)
        scene.wait(RUN_S)

    return script


def _locked_running(degC: float) -> Script:
    def script(scene: Scene) -> None:
        scene.start()
        scene.plant.temperatures["brush"] = degC
        scene.wait(0.5)
        scene.plant.locked = True
        scene.begins()
        scene.wait(60.0)

    return script


add("locked-start", "rotor locked, PWM 255; brush warms 8 K/s", _locked_at_start())
add("locked-start-plain", "the same, board without a relay", _locked_at_start(), board="plain")
add("locked-slow", "rotor locked at PWM 50, below the stall's threshold", _locked_at_start(50))
add("locked-60", "rotor locked at PWM 60", _locked_at_start(60))
add("locked-running", "rotor locks while running, brush at 103 degC", _locked_running(103.0))


@hazard("locked-again", "rotor locked, and whoever drives arms, resets and commands again every 4 s")
def _locked_again(scene: Scene) -> None:
    scene.plant.locked = True
    scene.wait(4.0)
    scene.begins()
    for _ in range(12):
        scene.send("reset")
        scene.wait(0.5)
        scene.drive(255)
        scene.wait(3.5)


@hazard("locked-at-limit", "rotor locks while the brush is 2 K below its limit; 8 K/s")
def _locked_at_limit(scene: Scene) -> None:
    scene.plant.temperatures["brush"] = 116.0
    scene.start(200)
    scene.plant.locked = True
    scene.begins()
    scene.wait(40.0)


@hazard("encoder-broken", "encoder's wire broken while running")
def _encoder_broken(scene: Scene) -> None:
    scene.start()
    scene.plant.encoder = "broken"
    scene.begins()
    scene.wait(RUN_S)


@hazard("encoder-noisy", "encoder's line noisy, 30 000 pulses/s, while running")
def _encoder_noisy(scene: Scene) -> None:
    scene.start()
    scene.plant.encoder = "noisy"
    scene.begins()
    scene.wait(RUN_S)


@hazard("locked-noisy", "rotor locked and encoder's line noisy", faults=2)
def _locked_noisy(scene: Scene) -> None:
    scene.plant.encoder = "noisy"
    scene.plant.locked = True
    scene.start()
    scene.begins()
    scene.wait(RUN_S)


def _shorted(pwm: int) -> Script:
    def script(scene: Scene) -> None:
        scene.start(pwm)
        scene.plant.shorted = True
        scene.begins()
        scene.wait(90.0)

    return script


add("short-running", "driver shorts while running: full current whatever the pins say", _shorted(255))
add("short-standing", "driver shorts while standing: the motor turns at PWM 0", _shorted(0))
add("short-plain", "driver shorts while running, board without a relay", _shorted(255), board="plain")


@hazard("short-locked", "driver shorts at PWM 0 and the rotor is locked", faults=2)
def _short_locked(scene: Scene) -> None:
    scene.start(0)
    scene.plant.shorted = scene.plant.locked = True
    scene.begins()
    scene.wait(60.0)


@hazard("relay-welded", "the relay's contacts are welded; the brush passes its limit")
def _relay_welded(scene: Scene) -> None:
    scene.plant.relay_closed = lambda: True
    scene.start()
    scene.begins()
    scene.wait(RUN_S)


@hazard("overload", "more load than the motor bears: parts pass their limits at full speed")
def _overload(scene: Scene) -> None:
    scene.start()
    scene.begins()
    scene.wait(RUN_S)


@hazard("reversing", "PWM 255, -255, 255 .. every 3 s, armed each time")
def _reversing(scene: Scene) -> None:
    scene.start()
    scene.begins()
    for turn in range(25):
        scene.drive(-255 if turn % 2 == 0 else 255)
        scene.wait(3.0)


def _supplied(volts: float, reference_V: float) -> Script:
    def script(scene: Scene) -> None:
        scene.board.mega.supply_with(5.0, reference_V=reference_V)
        scene.start()
        scene.begins()
        scene.board.mega.supply_with(volts, reference_V=reference_V)
        scene.wait(RUN_S)

    return script


add("supply-low", "the board's own supply sags to 4.3 V and stays there", _supplied(4.3, 1.1), board="supplied")
add(
    "supply-unmeasured",
    "the same, and nobody measured the chip's reference, which has 1.1 V",
    _supplied(4.3, 1.1),
    board="unmeasured",
)
add(
    "supply-sound",
    "a supply of 4.75 V is none; nobody measured the chip's reference, which has 1.2 V",
    _supplied(4.75, 1.2),
    board="unmeasured",
)


@hazard("supply-dips", "the board's own supply dips to 4 V for half a second, every 5 s", board="supplied")
def _supply_dips(scene: Scene) -> None:
    scene.start()
    scene.begins()
    for _ in range(12):
        scene.board.mega.supply_with(4.0)
        scene.wait(0.5)
        scene.board.mega.supply_with(5.0)
        scene.wait(4.5)


@hazard("observed-limit", "another controller drives; the brush passes its limit", board="observing")
def _observed_limit(scene: Scene) -> None:
    scene.start()
    scene.begins()
    scene.wait(RUN_S)


@hazard("observed-open", "another controller drives; brush: thermocouple open", board="observing")
def _observed_open(scene: Scene) -> None:
    scene.start()
    scene.plant.lies["brush"] = lambda _degC, _time: 0x0004
    scene.begins()
    scene.wait(60.0)


@hazard("observed-locked", "another controller drives; rotor locked", board="observing")
def _observed_locked(scene: Scene) -> None:
    scene.start()
    scene.plant.locked = True
    scene.begins()
    scene.wait(60.0)
