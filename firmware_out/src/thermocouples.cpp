#include "thermocouples.h"

#include <Arduino.h>
#include <util/delay.h>
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

// A clock of 1 us high and 1 us low, and as long from CS to the first bit: a metre of wire has some 100 pF, and with that a
// line of the board or of a chip has long settled. The chips ask for 100 ns.
const double HALF_US = 1.0;

const Chip chips[MY1016_SENSORS] PROGMEM = {
    // brush, $.wiring.thermocouples[0]: CS 29, SO 35, SCK 31; MAX6675
    {{(uint16_t)&PORTA, _BV(7)}, {(uint16_t)&PINC, _BV(2)}, {(uint16_t)&PORTC, _BV(6)}},
    // bearing, $.wiring.thermocouples[1]: CS 33, SO 35, SCK 31; MAX6675
    {{(uint16_t)&PORTC, _BV(4)}, {(uint16_t)&PINC, _BV(2)}, {(uint16_t)&PORTC, _BV(6)}},
    // magnet, $.wiring.thermocouples[2]: CS 39, SO 45, SCK 41; MAX6675
    {{(uint16_t)&PORTG, _BV(2)}, {(uint16_t)&PINL, _BV(4)}, {(uint16_t)&PORTG, _BV(0)}},
    // casing, $.wiring.thermocouples[3]: CS 43, SO 45, SCK 41; MAX6675
    {{(uint16_t)&PORTL, _BV(6)}, {(uint16_t)&PINL, _BV(4)}, {(uint16_t)&PORTG, _BV(0)}},
    // ambient, $.wiring.thermocouples[4]: CS 49, SO 46, SCK 51; MAX6675
    {{(uint16_t)&PORTL, _BV(0)}, {(uint16_t)&PINL, _BV(3)}, {(uint16_t)&PORTB, _BV(2)}},
};

volatile uint8_t *at(uint16_t address) { return reinterpret_cast<volatile uint8_t *>(address); }

Chip fetched(uint8_t number) {
    Chip chip;
    memcpy_P(&chip, &chips[number], sizeof chip);
    return chip;
}

// PINx, DDRx and PORTx of a port follow one another.
void make_output(const Line &line) { *at(line.address - 1) |= line.mask; }

// Selects a chip for as long as it lives, and clocks bits in and out.
class Selected {
  public:
    explicit Selected(const Chip &chip) : chip_(chip) {
        *at(chip_.cs.address) &= (uint8_t)~chip_.cs.mask;
    }
    ~Selected() {
        _delay_us(HALF_US);
        *at(chip_.cs.address) |= chip_.cs.mask;
    }
    Selected(const Selected &) = delete;
    Selected &operator=(const Selected &) = delete;

    // Of a chip that is only read: each bit is there after CS or the clock fell.
    uint16_t read() {
        volatile uint8_t *const sck = at(chip_.sck.address);
        const volatile uint8_t *const so = at(chip_.so.address);
        const uint8_t sck_bit = chip_.sck.mask, so_bit = chip_.so.mask;
        uint16_t word = 0;
        for (uint8_t bit = 0; bit < 16; ++bit) {
            _delay_us(HALF_US);
            word = (uint16_t)(word << 1 | ((*so & so_bit) != 0));
            *sck = (uint8_t)(*sck | sck_bit);
            _delay_us(HALF_US);
            *sck = (uint8_t)(*sck & (uint8_t)~sck_bit);
        }
        return word;
    }

  private:
    const Chip &chip_;
};

// Its word, and above it what comes when it is clocked on: by that a MAX31855 is known, which sends its own temperature there.
uint32_t read_max6675(const Chip &chip) {
    Selected selected(chip);
    const uint16_t word = selected.read();
    return (uint32_t)selected.read() << 16 | word;
}

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

uint32_t read(uint8_t number) {
    const Chip chip = fetched(number);
    return read_max6675(chip);
}

}  // namespace thermocouples
