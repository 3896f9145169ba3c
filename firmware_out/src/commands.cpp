#include "commands.h"

#include <Arduino.h>
#include <string.h>
#include <my1016_alarms.h>
#include <my1016_sensors.h>

#include "config.h"
#include "console.h"
#include "drive.h"
#include "selftest.h"

namespace commands {

namespace {

const uint8_t LONGEST = 15;
char command[LONGEST + 1];
uint8_t length;
bool spoilt;          // the line is too long, holds control characters, or bytes of it were lost
uint16_t not_obeyed;  // lines since take_rejected()

// A number of 1 to 5 digits at `text`, with a sign if `sign`; false for anything else.
bool number(const char *text, bool sign, int32_t *value) {
    const bool negative = sign && *text == '-';
    text += negative;
    int32_t sum = 0;
    uint8_t digits = 0;
    for (; *text >= '0' && *text <= '9'; ++text, ++digits) {
        if (digits == 5) {
            return false;
        }
        sum = sum * 10 + (*text - '0');
    }
    *value = negative ? -sum : sum;
    return digits > 0 && *text == 0;
}

bool is(const __FlashStringHelper *text) { return strcmp_P(command, reinterpret_cast<const char *>(text)) == 0; }

bool obey() {
    int32_t value;
    if (number(command, true, &value)) {
        return value >= -config::FULL_SCALE && value <= config::FULL_SCALE && drive::command((int16_t)value);
    }
    if (is(F("?"))) {
        console::begin_status();
    } else if (is(F("reset"))) {
        my1016_alarms_reset();
        my1016_sensors_accept();
        console::event(F("alarms reset"));
    } else if (is(F("test"))) {
        selftest::start();
    } else if (strncmp_P(command, PSTR("rows "), 5) == 0) {
        if (!number(command + 5, false, &value) || value < 1 || value > 0xFFFF) {
            return false;
        }
        console::row_every((uint16_t)value);
    } else {
        return false;
    }
    return true;
}

void take(char c) {
    if (c != '\n' && c != '\r') {
        if (length < LONGEST && c >= ' ') {
            command[length++] = c;
        } else {
            spoilt = true;
        }
        return;
    }
    command[length] = 0;
    if ((spoilt || (length > 0 && !obey())) && not_obeyed < 0xFFFFu) {
        ++not_obeyed;
    }
    length = 0;
    spoilt = false;
}

}  // namespace

void receive() {
    // With a full buffer bytes were lost behind those in it: the line in which that happened must not be obeyed.
    const bool full = Serial.available() >= SERIAL_RX_BUFFER_SIZE - 1;
    for (uint8_t i = 0; i < SERIAL_RX_BUFFER_SIZE && Serial.available() > 0; ++i) {
        take((char)Serial.read());
    }
    spoilt = spoilt || full;
}

uint16_t rejected() { return not_obeyed; }

uint16_t take_rejected() {
    const uint16_t lines = not_obeyed;
    not_obeyed = 0;
    return lines;
}

}  // namespace commands
