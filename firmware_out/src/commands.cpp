#include "commands.h"

#include <Arduino.h>
#include <string.h>
#include <util/crc16.h>
#include <my1016_alarms.h>
#include <my1016_protection.h>
#include <my1016_sensors.h>

#include "commissioning.h"
#include "config.h"
#include "console.h"
#include "drive.h"
#include "output.h"
#include "selftest.h"

namespace commands {

namespace {

const uint8_t LONGEST = 47;
char command[LONGEST + 1];
uint8_t length;
bool spoilt;          // the line is too long, holds control characters, or bytes of it were lost
bool checked;         // a line has had a checksum: from then on every one needs it
uint16_t not_obeyed;  // lines since take_rejected()
uint16_t silent;      // samples since a line was obeyed

const char channel_0[] PROGMEM = "brush";
const char channel_1[] PROGMEM = "bearing";
const char channel_2[] PROGMEM = "magnet";
const char channel_3[] PROGMEM = "casing";
const char channel_4[] PROGMEM = "ambient";
const char *const channels[MY1016_SENSORS] PROGMEM = {channel_0, channel_1, channel_2, channel_3, channel_4};

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

// A hexadecimal digit's value, 16 for anything else.
uint8_t digit(char c) {
    return (uint8_t)(c >= '0' && c <= '9' ? c - '0' : c >= 'A' && c <= 'F' ? c - 'A' + 10 : c >= 'a' && c <= 'f' ? c - 'a' + 10 : 16);
}

// Takes a checksum off the line: '*' and four hexadecimal digits, the CRC-16 of what stands before (polynomial 0x1021, from 0;
// XMODEM's). False if it is wrong, or if there is none although lines have had one.
bool sound() {
    char *const star = strchr(command, '*');
    if (!star) {
        return !checked;
    }
    uint16_t crc = 0;
    for (const char *c = command; c < star; ++c) {
        crc = _crc_xmodem_update(crc, (uint8_t)*c);
    }
    uint16_t told = 0;
    for (uint8_t i = 1; i <= 4; ++i) {
        const uint8_t value = digit(star[i]);
        if (value > 15) {
            return false;
        }
        told = (uint16_t)(told << 4 | value);
    }
    if (star[5] != 0 || told != crc) {
        return false;
    }
    checked = true;
    *star = 0;
    return true;
}

bool accept(const char *channel) {
    for (uint8_t number = 0; number < MY1016_SENSORS; ++number) {
        if (strcmp_P(channel, channel_name(number)) == 0) {
            my1016_sensors_accept(number);
            console::event(F("sensor accepted"));
            return true;
        }
    }
    return false;
}

bool obey() {
    int32_t value;
    if (number(command, true, &value)) {
        if (value < -config::FULL_SCALE || value > config::FULL_SCALE) {
            return false;
        }
        commissioning::end();  // whoever commands a PWM drives the motor from here on, and has to arm it
        if (value && !drive::armed()) {
            console::event(F("not armed"));
            return true;
        }
        return drive::command((int16_t)value);
    }
    if (is(F("?"))) {
        console::begin_status();
    } else if (is(F("reset"))) {
        reset();
        console::event(F("alarms reset"));
    } else if (strncmp_P(command, PSTR("accept "), 7) == 0) {
        return accept(command + 7);
    } else if (is(F("arm"))) {
        if (my1016_alarms_over_limit()) {
            console::event(F("not armed: too hot"));
        } else {
            console::event(drive::arm() ? F("armed") : F("not armed: the motor is stopped"));
        }
    } else if (is(F("test"))) {
        selftest::start();
    } else if (is(F("commission"))) {
        commissioning::start();
    } else if (is(F("yes")) || is(F("no"))) {
        return commissioning::answer(is(F("yes")));
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
    if (spoilt || (length > 0 && !(sound() && obey()))) {
        not_obeyed = (uint16_t)(not_obeyed + (not_obeyed < 0xFFFFu));
        drive::disarm();  // whoever sends this may be noise
        commissioning::end();  // or a person who wants it to stop
    } else if (length > 0) {
        silent = 0;
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

void reset() {
    my1016_alarms_reset();
    my1016_protection_ask();
    const uint32_t waiting_ms = (uint32_t)my1016_protection_waiting() * MY1016_SAMPLE_MS;
    if (waiting_ms) {
        console::begin_event(F("to be reset in "));
        output::put_number((int32_t)((waiting_ms + 999) / 1000));
        output::put(F(" s: it came again"));
        output::end_line();
    }
}

const char *channel_name(uint8_t channel) { return reinterpret_cast<const char *>(pgm_read_ptr(&channels[channel])); }

void sample() { silent = (uint16_t)(silent + (silent < 0xFFFFu)); }

uint16_t samples_silent() { return silent; }

uint16_t rejected() { return not_obeyed; }

uint16_t take_rejected() {
    const uint16_t lines = not_obeyed;
    not_obeyed = 0;
    return lines;
}

}  // namespace commands
