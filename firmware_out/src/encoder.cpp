#include "encoder.h"

#include <Arduino.h>
#include <util/atomic.h>

#include "config.h"

namespace encoder {

namespace {

typedef uint16_t Count;  // wraps round; more than 65535 pulses do not come in a sample

Count before;
uint32_t since;        // microseconds
uint16_t revolutions;  // in a minute
uint16_t without_pulse;  // samples with PWM and without a pulse

volatile Count pulses;

Count counted() {
    Count count;
    ATOMIC_BLOCK(ATOMIC_RESTORESTATE) { count = pulses; }
    return count;
}

}  // namespace

// $.wiring.encoder.pin = 2: external interrupt 4, rising edges.
ISR(INT4_vect) { pulses = pulses + 1; }

void begin() {
    pinMode(2, INPUT_PULLUP);
    EICRB |= _BV(ISC41) | _BV(ISC40);
    EIFR = _BV(INTF4);
    EIMSK |= _BV(INT4);
    since = micros();
}

void sample(int16_t pwm) {
    const Count now = counted();
    const uint32_t count = (Count)(now - before);
    before = now;
    // Pulses * 60 s / (pulses per revolution * time), with the time in 4 us as it really was: samples begin up to 2 ms late.
    const uint32_t factor = 30000UL, most = 143165UL;
    const uint32_t time = micros(), passed = (time - since) >> 2;
    since = time;
    if (passed > 0) {
        const uint32_t rpm = (count < most ? count : most) * factor / passed;
        revolutions = (uint16_t)(rpm < 0xFFFFu ? rpm : 0xFFFFu);
    }
    if (count > 0 || (pwm < config::STALL_PWM && pwm > -config::STALL_PWM)) {
        without_pulse = 0;
    } else if (without_pulse < config::STALL_SAMPLES) {
        ++without_pulse;
    }
}

uint16_t rpm() { return revolutions; }

bool stalled() { return without_pulse >= config::STALL_SAMPLES; }

}  // namespace encoder
