"""What the sketch costs on the board, with every part of it busy (``pytest -s`` prints the table)."""

from __future__ import annotations

from gen.avr.compile import sizes
from gen.avr.simulator import FREQUENCY_HZ
from tests.device.board import OPEN
from tests.device.conftest import Open

TICK_CYCLES = 4_000_000
RAM = 8192


def test_the_sketch_leaves_most_of_the_board_free(power_up: Open) -> None:
    board = power_up("often_copied")
    board.encoder.attach(2)
    board.started()
    board.stack.paint()
    board.drive(255)
    board.hear(1.0)
    awake, began = board.cycle - board.asleep, board.cycle
    for second in range(90):
        board.encoder.send(22_083, 1.0)  # 2650 rpm with 500 pulses
        if second % 20 == 10:
            board.drive(255 - second)
            board.chips["brush"].set_word(OPEN)
        board.hear(1.0)
        board.set_celsius("brush", 30.0)
    share = (board.cycle - board.asleep - awake) / (board.cycle - began)
    board.send("?")
    board.hear(1.0)
    board.send("test")
    said = board.hear(5.0)
    assert not any(int(row["flags"]) & 0x300 for row in said.rows)
    stack = board.stack.use().deepest
    board.send("?")
    status = next(event for event in board.hear(2.0).events if "longest_tick_us" in event)
    longest = int(status.split("longest_tick_us ")[1].split()[0]) * FREQUENCY_HZ // 1_000_000
    size = sizes(board.elf)
    print(
        f"\nflash {size.flash} B, RAM {size.ram} B, deepest stack {stack} B, longest tick {longest} cycles "
        f"({longest / TICK_CYCLES:.1%} of a tick, interrupts of the encoder at 22 kHz included), awake {share:.1%}"
    )
    assert size.flash < 48 * 1024
    assert size.ram + stack + 512 < RAM
    assert longest < TICK_CYCLES // 20
    assert share < 0.25
    assert board.resets == 0
