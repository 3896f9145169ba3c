#include "drive.h"

#include <Arduino.h>

#include "config.h"

namespace drive {

namespace {

int16_t acting;
int16_t commanded;

const uint8_t FORWARD = 4;  // $.wiring.drive.forward_pin
const uint8_t REVERSE = 5;  // $.wiring.drive.reverse_pin

void apply(int16_t pwm) {
    const uint8_t forward = (uint8_t)(pwm > 0 ? pwm : 0), reverse = (uint8_t)(pwm < 0 ? -pwm : 0);
    analogWrite(forward ? REVERSE : FORWARD, 0);  // off before the other goes on
    TCCR3B = reverse ? _BV(CS31) | _BV(CS30) : 0;  // Timer 3, as the Arduino core lets it run
    analogWrite(FORWARD, forward);
    analogWrite(REVERSE, reverse);
}

}  // namespace

void begin() {
    pinMode(FORWARD, OUTPUT);
    pinMode(REVERSE, OUTPUT);
    apply(0);
}

bool command(int16_t pwm) {
    if (pwm > config::FULL_SCALE || pwm < -config::FULL_SCALE) {
        return false;
    }
    commanded = pwm;
    return true;
}

void update(bool stop) {
    if (stop) {
        command(0);  // after the alarm's reset the motor stands until the next command
    }
    const int16_t next = commanded;
    if (next != acting) {
        apply(next);
    }
    acting = next;
}

int16_t pwm() { return acting; }

}  // namespace drive
