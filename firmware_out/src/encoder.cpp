#include "encoder.h"

#include <Arduino.h>
#include <util/atomic.h>

#include "config.h"

namespace encoder {

namespace {

typedef uint16_t Count;

// A noisy line must not keep the board from its samples: after three samples' worth of pulses at 3313 rpm (a late
// sample loses none) the interrupt switches itself off until the next one. Nor may it keep the board from its time: pulses
// that follow one another within the interrupt itself, some 3 us, would leave no turn to Timer 0's, which is served after
// it, and millis() would stand still meanwhile. The motor gives none such, so few of them are enough.
const Count MOST = 20704u;
const uint8_t MOST_CLOSE = 100;  // in the worst case 100 interrupts without a gap: 0.4 ms
volatile Count left;             // pulses that may still come in this sample
volatile uint8_t close_left;     // those that may still follow within the interrupt
bool was_off;                    // it had switched itself off
uint32_t since;        // microseconds
uint16_t revolutions;  // in a minute
uint16_t without_pulse;  // samples with PWM and without a pulse
bool impossible;         // more pulses than the motor can give

// Pulses since the last time.
uint32_t take() {
    Count count;
    ATOMIC_BLOCK(ATOMIC_RESTORESTATE) {
        count = (Count)(MOST - left);
        left = MOST;
        close_left = MOST_CLOSE;
        was_off = !(EIMSK & _BV(INT4));
    }
    if (was_off) {
        EIFR = _BV(INTF4);
        EIMSK |= _BV(INT4);
    }
    return count;
}

}  // namespace

// $.wiring.encoder.pin = 2: external interrupt 4, rising edges.
ISR(INT4_vect) {
    const Count rest = (Count)(left - 1);
    left = rest;
    if (rest == 0 || ((EIFR & _BV(INTF4)) && --close_left == 0)) {
        EIMSK &= (uint8_t)~_BV(INT4);
    }
}

void begin() {
    pinMode(2, INPUT_PULLUP);
    EICRB |= _BV(ISC41) | _BV(ISC40);
    EIFR = _BV(INTF4);
    left = MOST;
    close_left = MOST_CLOSE;
    EIMSK |= _BV(INT4);
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
    impossible = was_off;
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
