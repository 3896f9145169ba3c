// The ATmega2560 itself: reset, watchdog, idle sleep, flash and RAM.
#ifndef BOARD_H
#define BOARD_H

#include <Arduino.h>

namespace board {

// Stops what this wiring does not use, marks the free RAM and switches the watchdog on (2 s).
void begin();

// Why the board was reset last.
const __FlashStringHelper *reset_cause();

// Whether RAM may hold what it held before the reset: not after one by power or brown-out that nobody hid.
bool kept_ram();

// Sleeps until a time (milliseconds), or until a byte has arrived.
void doze(uint32_t until);

// Share of the time asleep, in thousandths; of the last minutes. Interrupts that do not end the sleep count as sleep.
uint16_t sleep_share();

// Bytes of RAM that nothing has touched since begin(). Takes some 30 000 cycles.
uint16_t untouched_ram();

// Writes two patterns to a byte of RAM, reads them, and puts back what was there: some 30 cycles without interrupts.
bool ram_holds(uint16_t address);

// Bytes of program and constants in flash, and one of them.
uint32_t flash_bytes();
uint8_t flash_byte(uint32_t address);

}  // namespace board

#endif
