#include "oscillator.h"

#include <Arduino.h>
#include <avr/wdt.h>
#include <util/atomic.h>

namespace oscillator {

namespace {

const uint16_t SAMPLES = 40;  // from one measurement to the next: 10 s
// 2048 turns of an oscillator of 128 kHz are 16 ms. The data sheet calls that typical, says that it falls a little with the supply
// and the temperature, and gives no limits: a fifth is far beyond its curves, and far less than a crystal does that jumps to
// another overtone, or a clock that was divided.
const uint16_t SILENT = 2;  // so many samples without a ring: the oscillator stands still
const uint16_t SHORTEST_US = 12800, LONGEST_US = 19200;

volatile uint32_t began;
volatile uint16_t took;
volatile bool measuring;
uint16_t left;    // samples to the next one
uint16_t waited;  // samples without a ring
uint8_t off;    // measurements in a row that were off, up to 2
bool to_judge;

}  // namespace

}  // namespace oscillator

// From here on it resets again, after 2 s: also a board that hung meanwhile.
ISR(WDT_vect) {
    using namespace oscillator;
    const uint32_t passed = micros() - began;
    wdt_enable(WDTO_2S);
    wdt_reset();  // what was set acts from here on
    took = passed < 0xFFFFu ? (uint16_t)passed : 0xFFFFu;
    measuring = false;
}

namespace oscillator {

void sample() {
    if (measuring) {
        waited = (uint16_t)(waited + (waited < SILENT));
        off = waited < SILENT ? off : 2;  // it stands still: nobody else would tell, for it cannot reset either
        return;
    }
    waited = 0;
    if (to_judge) {
        to_judge = false;
        const bool good = took >= SHORTEST_US && took <= LONGEST_US;
        off = (uint8_t)(good ? 0 : off < 2 ? off + 1 : 2);
    }
    if (left > 0) {
        --left;
        return;
    }
    left = SAMPLES - 1;
    to_judge = true;
    measuring = true;
    ATOMIC_BLOCK(ATOMIC_RESTORESTATE) {
        wdt_reset();
        WDTCSR = _BV(WDCE) | _BV(WDE);
        WDTCSR = _BV(WDIE) | _BV(WDE);  // rings once, then resets: the ring is what hinders that
        wdt_reset();
        began = micros();
    }
}

bool measures() { return measuring; }

bool clock_is_off() { return off >= 2; }

uint16_t took_us() { return took; }

}  // namespace oscillator
