#include "indicator.h"

#include <Arduino.h>

namespace indicator {

namespace {

uint16_t latched;
bool faulty;
bool protects;

const uint8_t LED = 13;  // $.wiring.led_pin

// Lengths in slots of 32 ms.
const uint8_t BLINK = 8, DARK = 8;    // of an alarm's number
const uint8_t PAUSE = 48;             // after it; filled with flicker while a sensor is faulty
const uint8_t FLICKER = 2;            // on and off
const uint8_t BEAT = 2, PERIOD = 64;  // healthy: a short flash every two seconds
const uint8_t HELD = 32;              // the board acts on something: on and off for a second each

uint8_t shown;   // the rule whose number is being blinked, 1..; 0: none
uint8_t blinks;  // still to come
uint8_t at;      // slots since the present part began

// The next latched rule after `shown`, round robin; 0 if none is latched.
uint8_t next_rule() {
    for (uint8_t i = 0; i < 16; ++i) {
        const uint8_t rule = (uint8_t)((shown + i) & 15);
        if (latched & (uint16_t)(1u << rule)) {
            return (uint8_t)(rule + 1);
        }
    }
    return 0;
}

bool flicker() { return at & FLICKER; }

bool lit() {
    ++at;
    if (shown == 0) {
        if (latched) {
            shown = next_rule();
            blinks = shown;
            at = 0;
        }
        return protects ? at % PERIOD < HELD : faulty ? flicker() : at % PERIOD < BEAT;
    }
    if (blinks > 0) {
        if (at >= BLINK + DARK) {
            at = 0;
            --blinks;
        }
        return blinks > 0 && at < BLINK;
    }
    if (at >= PAUSE) {
        at = 0;
        shown = next_rule();
        blinks = shown;
        return shown > 0;
    }
    return faulty && flicker();
}

const uint8_t BUTTON = 22;  // $.wiring.button_pin: to ground
uint8_t history;  // the last states, the newest in bit 0; 0: pressed. A button that is held since the reset does nothing

}  // namespace

void begin() {
    pinMode(LED, OUTPUT);
    pinMode(BUTTON, INPUT_PULLUP);
}

void show(uint16_t alarms, bool sensor_fault, bool protection) {
    latched = alarms;
    faulty = sensor_fault;
    protects = protection;
}

bool update() {
    digitalWrite(LED, lit());
    history = (uint8_t)(history << 1 | (digitalRead(BUTTON) == HIGH));
    return (history & 0x0F) == 0x0C;  // up for two slots, then down for two: bouncing is over within one
}

}  // namespace indicator
