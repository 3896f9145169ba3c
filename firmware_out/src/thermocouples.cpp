#include "thermocouples.h"

#include <Arduino.h>
#include <my1016_sensors.h>

namespace thermocouples {

namespace {

// A line is an address and a mask: digitalWrite() looks the pin up in three tables at every edge and takes some 80 cycles,
// a store 2. No interrupt writes to a port, so a port's value may be kept while a chip is read.
struct Line {
    uint16_t address;  // PORTx of an output, PINx of an input
    uint8_t mask;
};

struct Chip {
    Line cs, so, sck;
};

const Chip chips[MY1016_SENSORS] PROGMEM = {
    // brush, $.wiring.thermocouples[0]: CS 29, SO 35, SCK 31
    {{(uint16_t)&PORTA, _BV(7)}, {(uint16_t)&PINC, _BV(2)}, {(uint16_t)&PORTC, _BV(6)}},
    // bearing, $.wiring.thermocouples[1]: CS 33, SO 35, SCK 31
    {{(uint16_t)&PORTC, _BV(4)}, {(uint16_t)&PINC, _BV(2)}, {(uint16_t)&PORTC, _BV(6)}},
    // magnet, $.wiring.thermocouples[2]: CS 39, SO 45, SCK 41
    {{(uint16_t)&PORTG, _BV(2)}, {(uint16_t)&PINL, _BV(4)}, {(uint16_t)&PORTG, _BV(0)}},
    // casing, $.wiring.thermocouples[3]: CS 43, SO 45, SCK 41
    {{(uint16_t)&PORTL, _BV(6)}, {(uint16_t)&PINL, _BV(4)}, {(uint16_t)&PORTG, _BV(0)}},
    // ambient, $.wiring.thermocouples[4]: CS 49, SO 47, SCK 51
    {{(uint16_t)&PORTL, _BV(0)}, {(uint16_t)&PINL, _BV(2)}, {(uint16_t)&PORTB, _BV(2)}},
};

volatile uint8_t *at(uint16_t address) { return reinterpret_cast<volatile uint8_t *>(address); }

Chip fetched(uint8_t number) {
    Chip chip;
    memcpy_P(&chip, &chips[number], sizeof chip);
    return chip;
}

// PINx, DDRx and PORTx of a port follow one another.
void make_output(const Line &line) { *at(line.address - 1) |= line.mask; }

}  // namespace

void begin() {
    for (uint8_t number = 0; number < MY1016_SENSORS; ++number) {
        const Chip chip = fetched(number);
        *at(chip.cs.address) |= chip.cs.mask;  // not selected
        make_output(chip.cs);
        *at(chip.sck.address) &= (uint8_t)~chip.sck.mask;
        make_output(chip.sck);
        *at(chip.so.address + 2) |= chip.so.mask;  // pull-up: a missing chip reads as all ones
    }
}

// Each bit is valid 100 ns after CS or the clock fell, and the clock has to stay high and low for 100 ns: 2 cycles each.
uint16_t read(uint8_t number) {
    const Chip chip = fetched(number);
    volatile uint8_t *const cs = at(chip.cs.address);
    volatile uint8_t *const sck = at(chip.sck.address);
    volatile uint8_t *const so = at(chip.so.address);
    *cs &= (uint8_t)~chip.cs.mask;
    const uint8_t low = *sck;
    const uint8_t high = low | chip.sck.mask;
    uint16_t word = 0;
    for (uint8_t bit = 0; bit < 16; ++bit) {
        word = (uint16_t)(word << 1);
        if (*so & chip.so.mask) {
            word |= 1;
        }
        *sck = high;
        *sck = low;
    }
    *cs |= chip.cs.mask;
    return word;
}

}  // namespace thermocouples
