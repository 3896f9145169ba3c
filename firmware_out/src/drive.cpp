#include "drive.h"

#include <Arduino.h>

#include "config.h"

namespace drive {

namespace {

int16_t acting;
int16_t commanded;
bool is_armed;  // a PWM other than 0 may be commanded
bool stopped;   // the motor has to stand
bool backwards;                           // the direction in which the motor was driven last
uint16_t rested = config::PAUSE_SAMPLES;  // samples at PWM 0, up to the pause

const uint8_t FORWARD = 4;  // $.wiring.drive.forward_pin
const uint8_t REVERSE = 5;  // $.wiring.drive.reverse_pin

void apply(int16_t pwm) {
    const uint8_t forward = (uint8_t)(pwm > 0 ? pwm : 0), reverse = (uint8_t)(pwm < 0 ? -pwm : 0);
    analogWrite(forward ? REVERSE : FORWARD, 0);  // off before the other goes on
    TCCR3B = reverse ? _BV(CS31) | _BV(CS30) : 0;  // Timer 3: 490 Hz, as the Arduino core lets it run
    analogWrite(FORWARD, forward);
    analogWrite(REVERSE, reverse);
}


// What may act of a PWM that is wanted: a change of direction waits at 0.
int16_t shaped(int16_t wanted) {
    if (acting) {
        rested = 0;
    } else if (rested < config::PAUSE_SAMPLES) {
        ++rested;
    }
    if (wanted && (wanted < 0) != backwards) {
        if (acting || rested < config::PAUSE_SAMPLES) {
            wanted = 0;
        } else {
            backwards = !backwards;
        }
    }
    return wanted;
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

bool arm() {
    is_armed = !stopped;
    return is_armed;
}

void disarm() { is_armed = false; }

bool armed() { return is_armed; }

bool follows_line() { return commanded != 0; }

void update(uint8_t most) {
    stopped = most == 0;
    if (stopped) {
        command(0);  // once it may run again the motor stands until it is armed, and commanded
        disarm();
    }
    int16_t next = commanded;
    const int16_t limit = most;
    next = next > limit ? limit : next < -limit ? (int16_t)-limit : next;
    next = shaped(next);
    if (next != acting) {
        apply(next);
    }
    acting = next;
}

int16_t pwm() { return acting; }

}  // namespace drive
