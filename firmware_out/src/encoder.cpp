#include "encoder.h"

#include <Arduino.h>
#include <util/atomic.h>

#include "config.h"

namespace encoder {

namespace {

uint16_t before;  // wraps round; more than 65535 pulses do not come in a sample
uint32_t since;        // microseconds
uint16_t revolutions;  // in a minute
uint16_t without_pulse;  // samples with PWM and without a pulse
bool impossible;         // more pulses than the motor can give

// Pulses since the last time.
uint32_t take() {
    uint16_t now;
    ATOMIC_BLOCK(ATOMIC_RESTORESTATE) { now = TCNT5; }
    const uint16_t count = (uint16_t)(now - before);
    before = now;
    return count;
}

}  // namespace

// Timer 5 counts rising edges at T5, $.wiring.encoder.pin = 47: no interrupt, no cycles.
void begin() {
    pinMode(47, INPUT_PULLUP);
    TCCR5A = 0;
    TCCR5B = _BV(CS52) | _BV(CS51) | _BV(CS50);
    before = TCNT5;
    since = micros();
}

void sample(int16_t pwm) {
    const uint32_t time = micros();
    if (time - since < 62500UL) {
        return;  // a sample that makes up for a late one: a pulse more or less would be too much; they wait for the next
    }
    const uint32_t count = take();
    // Pulses * 60 s / (pulses per revolution * time), with the time in 4 us as it really was: samples begin up to 2 ms late.
    const uint32_t factor = 30000UL, most = 143165UL;
    const uint32_t passed = (time - since) >> 2;
    since = time;
    impossible = count >= 20704u;
    if (passed > 0) {
        const uint32_t rpm = (count < most ? count : most) * factor / passed;
        revolutions = (uint16_t)(rpm < 0xFFFFu ? rpm : 0xFFFFu);
        impossible = impossible || rpm > 3313u;
    }
    if (count > 0 || (pwm < config::STALL_PWM && pwm > -config::STALL_PWM)) {
        without_pulse = 0;
    } else if (without_pulse < config::STALL_SAMPLES) {
        ++without_pulse;
    }
}

uint16_t rpm() { return revolutions; }

bool noisy() { return impossible; }

bool stalled() { return without_pulse >= config::STALL_SAMPLES; }

}  // namespace encoder
