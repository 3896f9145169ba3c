#include "console.h"

#include <string.h>
#include <my1016_protection.h>
#include <my1016_sensors.h>

#include "board.h"
#include "commands.h"
#include "commissioned.h"
#include "config.h"
#include "device.h"
#include "drive.h"
#include "output.h"
#include "selftest.h"

using device::now;

namespace console {

namespace {

const uint8_t NOTHING = 0xFF;

const char columns[] PROGMEM =
    "time_s,pwm,brush_degC,bearing_degC,magnet_degC,"
    "casing_degC,ambient_degC,speed_rpm,brush_model_degC,bearing_model_degC,"
    "magnet_model_degC,casing_model_degC,flags,sensors,alarms,"
    "protection";

uint8_t header_line;            // next line of the header ..
const char *column = columns;  // .. and place in its last one
bool header_done;
uint8_t status_line = NOTHING;

uint16_t row_samples = config::ROW_SAMPLES;
uint16_t samples_to_row;
bool dropped;  // rows since the last one that was written

// What the last row said.
struct Said {
    int16_t pwm;
    uint16_t flags;
    uint16_t alarms;
    uint32_t protection;
    uint8_t codes[MY1016_SENSORS];
};
Said said;
uint16_t announced;  // alarms
uint32_t announced_protection;

void put_time() {
    output::put_number((int32_t)now.seconds);
    output::put('.');
    output::put((char)('0' + now.milliseconds / 100));
    output::put((char)('0' + now.milliseconds / 10 % 10));
    output::put((char)('0' + now.milliseconds % 10));
}

// ---- header and status ------------------------------------------------------------------------------------------

bool write_header() {
    switch (header_line++) {
        case 0:
            output::put(F("# model: my1016"));
            break;
        case 1:
            output::put(F("# tool: gen 0.1.0, arithmetic fixed, schedule table"));
            break;
        case 2:
            output::put(F("# coefficients_sha256: fa163b1eb2dfe972550fcfaae57eae7470ce47dd14d767b67f9727703124f56d"));
            break;
        case 3:
            output::put(F("# firmware: crc32 "));
            output::put_hex(selftest::crc());
            output::put(F(" of "));
            output::put_number((int32_t)board::flash_bytes());
            output::put(F(" bytes"));
            break;
        case 4:
            output::put(F("# reset: "));
            output::put(board::reset_cause());
            break;
        case 5:
            output::put(F("# row_every_s: 1"));
            break;
        case 6:
            output::put(commissioned::passed() ? F("# commissioned: yes") : F("# commissioned: no"));
            break;
        default:
            --header_line;
            for (uint8_t i = 0; i < output::LINE_BYTES - 2; ++i) {
                const char c = (char)pgm_read_byte(column++);
                if (c == 0) {
                    output::end_line();
                    return false;
                }
                output::put(c);
            }
            return true;
    }
    output::end_line();
    return true;
}

bool write_status() {
    output::put(F("# status: "));
    put_time();
    switch (status_line++) {
        case 0:
            output::put(F(" pwm "));
            output::put_number(drive::pwm());
            output::put(F(" rpm "));
            output::put_number(now.rpm);
            output::put(F(" flags "));
            output::put_number(now.flags);
            output::put(F(" sensors "));
            put_codes();
            output::put(F(" alarms "));
            output::put_number(my1016_alarms());
            output::put(F(" protection "));
            output::put_number((int32_t)my1016_protection());
            output::put(drive::armed() ? F(" armed") : F(" not armed"));
            break;
        case 1:
            output::put(F(" late "));
            output::put_number(now.late);
            output::put(F(" dropped "));
            output::put_number(now.dropped);
            output::put(F(" longest_tick_us "));
            output::put_number((int32_t)now.longest_us);
            output::put(F(" sleep_permille "));
            output::put_number(board::sleep_share());
            break;
        case 2:
            output::put(F(" commands: -255..255 (PWM), arm, ?, reset, accept CHANNEL, test, commission, rows N"));
            break;
        default:
            output::put(F(" reset "));
            output::put(board::reset_cause());
            output::end_line();
            return false;
    }
    output::end_line();
    return true;
}

// One event for the alarms that were raised or ended since the last one.
void announce() {
    const uint16_t alarms = my1016_alarms(), fresh = alarms & (uint16_t)~announced;
    announced &= alarms;
    for (uint8_t rule = 0; fresh != 0 && rule < 16; ++rule) {  // every pass of the loop comes by, nearly always for none
        if (fresh & (uint16_t)(1u << rule)) {
            announced |= (uint16_t)(1u << rule);
            begin_event(F("alarm "));
            output::put_name(my1016_alarm_name(rule));
            output::end_line();
            return;
        }
    }
}

// One event for an entry that has begun to act, or ended, since the last one.
void announce_protection() {
    const uint32_t changed = my1016_protection() ^ announced_protection;
    for (uint8_t entry = 0; changed != 0 && entry < MY1016_PROTECTIONS; ++entry) {
        const uint32_t bit = (uint32_t)1 << entry;
        if (changed & bit) {
            announced_protection ^= bit;
            begin_event(F("protection "));
            output::put_name(my1016_protection_name(entry));
            output::put(announced_protection & bit ? F(" begins") : F(" ends"));
            output::end_line();
            return;
        }
    }
}

}  // namespace

void begin() { Serial.begin(config::SERIAL_BAUD); }

void begin_status() {
    if (status_line == NOTHING && header_done) {
        status_line = 0;
        header_done = false;  // the header goes first, for a recorder that came late
        header_line = 0;
        column = columns;
    }
}

void row_every(uint16_t samples) {
    row_samples = samples;
    samples_to_row = 0;
    if (output::takes_line()) {
        begin_event(F("rows "));
        output::put_number(samples);
        output::end_line();
    }
}

bool work() {
    if (!output::takes_line()) {
        return true;
    }
    if (!header_done) {
        header_done = !write_header();
        return true;
    }
    if (status_line != NOTHING) {
        if (!write_status()) {
            status_line = NOTHING;
        }
        return true;
    }
    announce();
    if (output::takes_line()) {
        announce_protection();
    }
    if (commands::rejected() && output::takes_line()) {
        begin_event(F("rejected lines: "));
        output::put_number(commands::take_rejected());
        output::end_line();
    }
    return false;
}

void sample() {
    Said saying = Said();
    saying.pwm = drive::pwm();
    saying.flags = now.flags;
    saying.alarms = my1016_alarms();
    saying.protection = my1016_protection();
    for (uint8_t channel = 0; channel < MY1016_SENSORS; ++channel) {
        saying.codes[channel] = my1016_sensors_code(channel);
    }
    const bool due = samples_to_row == 0;
    samples_to_row = (uint16_t)((due ? row_samples : samples_to_row) - 1);
    if (!due && memcmp(&saying, &said, sizeof said) == 0) {
        return;
    }
    if (!header_done || output::room() < config::ROW_BYTES) {
        dropped = true;
        if (now.dropped < 0xFFFFu) {
            ++now.dropped;
        }
        return;
    }
    said = saying;
    put_time();
    output::put(',');
    output::put_number(saying.pwm);
    output::put(',');
    if (now.sample.valid & (1u << MY1016_BRUSH)) {
        output::put_thousandths(now.sample.measured_mC[MY1016_BRUSH], 2);
    }
    output::put(',');
    if (now.sample.valid & (1u << MY1016_BEARING)) {
        output::put_thousandths(now.sample.measured_mC[MY1016_BEARING], 2);
    }
    output::put(',');
    if (now.sample.valid & (1u << MY1016_MAGNET)) {
        output::put_thousandths(now.sample.measured_mC[MY1016_MAGNET], 2);
    }
    output::put(',');
    if (now.sample.valid & (1u << MY1016_CASING)) {
        output::put_thousandths(now.sample.measured_mC[MY1016_CASING], 2);
    }
    output::put(',');
    if (!(now.flags & device::AMBIENT)) {
        output::put_thousandths(now.sample.ambient_mC, 2);
    }
    output::put(',');
    if (!(now.flags & device::NOISY)) {
        output::put_number(now.rpm);
    }
    for (uint8_t component = 0; component < MY1016_COMPONENTS; ++component) {
        output::put(',');
        output::put_thousandths(my1016_temperature_mC(component, now.sample.ambient_mC));
    }
    output::put(',');
    output::put_number(saying.flags | (dropped ? device::DROPPED : 0));
    dropped = false;
    output::put(',');
    put_codes();
    output::put(',');
    output::put_number(saying.alarms);
    output::put(',');
    output::put_number((int32_t)saying.protection);
    output::end_line();
}

void begin_event(const __FlashStringHelper *what) {
    output::put(F("# event: "));
    put_time();
    output::put(' ');
    output::put(what);
}

void event(const __FlashStringHelper *what) {
    if (!output::takes_line()) {
        return;
    }
    begin_event(what);
    output::end_line();
}

void put_codes() {
    for (uint8_t channel = 0; channel < MY1016_SENSORS; ++channel) {
        output::put((char)('0' + my1016_sensors_code(channel)));
    }
}

}  // namespace console
