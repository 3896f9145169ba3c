"""Hazards of commands, of the line that they come by, and of the board's resets."""

from __future__ import annotations

import random
from binascii import crc_hqx

from benchmarks.hazards.hazard import Script, add, hazard
from benchmarks.hazards.scene import Scene
from benchmarks.hazards.sensing import fallen_off, open_wire
from gen.emulate.wiring.devices import ResetCause

TURNS = 10


def hot(scene: Scene) -> None:
    """Drive until a limit has stopped the motor."""
    scene.start()
    for _ in range(60):
        if not scene.plant.moments[-1].driven:
            break
        scene.wait(1.0)
    scene.begins()


def _again(*lines: str, reset: bool = False, cut_s: float = 0.0) -> Script:
    """Whoever drives wants it to run: the same every 6 s."""

    def script(scene: Scene) -> None:
        hot(scene)
        mega = scene.board.mega
        for _ in range(TURNS):
            if reset:
                mega.press_reset()
            elif cut_s:
                mega.cut_power(cut_s)
            scene.wait(3.0 if reset or cut_s else 0.25)
            for line in lines:
                scene.send(line)
            scene.wait(3.0)

    return script


add("reset-command", "stopped by a limit: `reset`, `arm`, `255` every 3 s", _again("reset", "arm", "255"))
add(
    "reset-board",
    "stopped by a limit: the board is reset, armed and commanded every 6 s",
    _again("arm", "255", reset=True),
)
add(
    "reset-both",
    "stopped by a limit: board reset, `reset`, `arm`, `255` every 6 s",
    _again("reset", "arm", "255", reset=True),
)
add(
    "power-cut",
    "stopped by a limit: power off for 2 s, then `reset`, `arm`, `255`",
    _again("reset", "arm", "255", cut_s=2.0),
)
add(
    "power-blink",
    "stopped by a limit: power off for 50 ms, then `reset`, `arm`, `255`",
    _again("reset", "arm", "255", cut_s=0.05),
)
add(
    "reset-plain",
    "stopped by a limit: board reset, `reset`, `arm`, `255`; without a relay",
    _again("reset", "arm", "255", reset=True),
    board="plain",
)
add("unarmed", "stopped by a limit: `255` without `arm`", _again("reset", "255"))


@hazard("brown-out", "brown-out while running, in the moment in which a limit stops the motor")
def _brown_out(scene: Scene) -> None:
    hot(scene)
    scene.board.mega.cut_power(0.01, cause=ResetCause.BROWN_OUT)
    for _ in range(TURNS):
        scene.wait(3.0)
        scene.send("reset")
        scene.drive(255)


@hazard("reset-running", "the board is reset while running, as by opening a serial monitor")
def _reset_running(scene: Scene) -> None:
    scene.start()
    scene.begins()
    scene.board.mega.press_reset()
    scene.wait(30.0)


@hazard("reset-blind", "brush: open; the board is reset, armed and commanded every 9 s")
def _reset_blind(scene: Scene) -> None:
    scene.start()
    scene.plant.lies["brush"] = open_wire
    scene.begins()
    for _ in range(8):
        scene.wait(6.0)
        scene.board.mega.press_reset()
        scene.wait(3.0)
        scene.drive(255)


@hazard("arm-blind", "brush: open; `arm`, `255` every 3 s")
def _arm_blind(scene: Scene) -> None:
    scene.start()
    scene.plant.lies["brush"] = open_wire
    scene.begins()
    for _ in range(20):
        scene.wait(3.0)
        scene.drive(255)


@hazard("button", "stopped by a limit: the button is held, `arm`, `255` every 3 s")
def _button(scene: Scene) -> None:
    hot(scene)
    scene.board.press(down=True)
    for _ in range(TURNS):
        scene.wait(3.0)
        scene.drive(255)


@hazard("reset-fallen", "brush: fell off; `reset`, which was meant for something else, `arm`, `255`")
def _reset_fallen(scene: Scene) -> None:
    scene.start()
    scene.plant.lies["brush"] = fallen_off()
    scene.begins()
    for _ in range(TURNS):
        scene.wait(3.0)
        scene.send("reset")
        scene.drive(255)
    scene.wait(30.0)


@hazard("accept-fallen", "brush: fell off, and somebody sends `accept brush` without having looked", faults=2)
def _accept_fallen(scene: Scene) -> None:
    scene.start()
    scene.plant.lies["brush"] = fallen_off()
    scene.wait(2.0)
    scene.send("accept brush")
    scene.begins()
    scene.wait(5 * 15.0)


@hazard("accept-all", "`accept` for every sound thermocouple, every second")
def _accept_all(scene: Scene) -> None:
    scene.start()
    scene.begins()
    for _ in range(60):
        scene.wait(1.0)
        for channel in scene.board.thermocouples:
            scene.send(f"accept {channel}")


@hazard("silent", "the line falls silent while running at 255, with a motor that stays cool")
def _silent(scene: Scene) -> None:
    scene.alive = False
    scene.plant.heating = dict.fromkeys(scene.plant.heating, 0.01)
    scene.start()
    scene.begins()
    scene.wait(40.0)


@hazard("zero-lost", "the command `0` is garbled on the line: the motor is not told to stop")
def _zero_lost(scene: Scene) -> None:
    scene.start()
    scene.begins()
    scene.send("\x00")
    scene.wait(60.0)


def _flood(armed: bool, seconds: float) -> Script:
    def script(scene: Scene) -> None:
        scene.alive = False
        scene.start(120 if armed else 0)
        if armed:
            scene.send("arm")
            scene.wait(0.5)
        scene.begins()
        drawn = random.Random(7)
        per_step = 2600  # at simavr's pace of 11 bits a byte, a little less than the line can bear
        for _ in range(round(seconds * 4)):
            scene.board.mega.uart.send(drawn.randbytes(per_step))
            scene.wait(0.25)

    return script


add("flood", "random bytes at 115200 baud for a minute, motor standing", _flood(armed=False, seconds=60.0))
add("flood-armed", "random bytes at 115200 baud for a minute, motor driven and armed", _flood(armed=True, seconds=60.0))


@hazard("cut-command", "the line breaks in mid-command: `2` of `255`, then its end comes as `55`")
def _cut_command(scene: Scene) -> None:
    scene.alive = False
    scene.wait(4.0)
    scene.begins()
    scene.board.mega.uart.send(b"arm\n2")
    scene.wait(30.0)
    scene.board.mega.uart.send(b"55\n")
    scene.wait(60.0)


@hazard("lost-digit", "digits and signs are lost: `255` comes as `25`, `-20` as `20`")
def _lost_digit(scene: Scene) -> None:
    scene.alive = False
    scene.start()
    scene.begins()
    for line in ("25", "20", "2", "255"):
        scene.send(line)
        scene.wait(18.0)


def with_sum(line: str) -> str:
    """The line with its checksum."""
    return f"{line}*{crc_hqx(line.encode(), 0):04X}"


@hazard("checksum", "lines with checksums, one of them wrong: `0` comes as `200`, then without any sum")
def _checksum(scene: Scene) -> None:
    scene.alive = False
    scene.wait(4.0)
    scene.begins()
    for line in (with_sum("arm"), with_sum("60"), "200" + with_sum("0")[1:], "arm", "255"):
        scene.send(line)
        scene.wait(3.0)
    scene.wait(30.0)


@hazard("late", "the loop is 1.5 s late every 5 s")
def _late(scene: Scene) -> None:
    scene.start()
    scene.begins()
    for _ in range(12):
        scene.wait(5.0)
        scene.board.mega.hold_up(1500)


@hazard("hung", "the loop hangs for ever, while running")
def _hung(scene: Scene) -> None:
    scene.start()
    scene.begins()
    mega = scene.board.mega
    mega.memory.poke(scene.address("tick_due"), (2**31 - 1).to_bytes(4, "little"))
    scene.wait(30.0)


@hazard("hung-again", "the loop hangs every 10 s, and whoever drives commands again")
def _hung_again(scene: Scene) -> None:
    scene.start()
    scene.begins()
    mega = scene.board.mega
    for _ in range(8):
        mega.memory.poke(scene.address("tick_due"), (2**31 - 1).to_bytes(4, "little"))
        scene.wait(6.0)
        scene.drive(255)
        scene.wait(4.0)


@hazard("rollover", "millis() rolls over, 15 s before the limit is reached")
def _rollover(scene: Scene) -> None:
    scene.board.mega.start_clock_at(2**32 - 30_000)
    scene.start()
    scene.begins()
    scene.wait(4 * 15.0)
