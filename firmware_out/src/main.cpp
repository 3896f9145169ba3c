// The device: every 250 ms it reads the sensors, checks their samples, moves the model of the healthy motor on by one sample,
// compares, and says what it found. Between the samples it sleeps.
//
// A tick has this order: sensors and their checks; the model, with the PWM that acted over the sample that ends now; the
// alarms; the PWM that acts from now on; then everything that is told to people.
#include <Arduino.h>
#include <avr/wdt.h>
#include <my1016.h>
#include <my1016_alarms.h>
#include <my1016_protection.h>
#include <my1016_sensors.h>

#include "board.h"
#include "commands.h"
#include "commissioned.h"
#include "commissioning.h"
#include "config.h"
#include "console.h"
#include "device.h"
#include "drive.h"
#include "encoder.h"
#include "guard.h"
#include "indicator.h"
#include "latch.h"
#include "memory.h"
#include "oscillator.h"
#include "output.h"
#include "selftest.h"
#include "thermocouples.h"
#include "warm.h"

using device::now;

device::Now device::now;

static uint32_t tick_due;  // milliseconds, as millis() counts them
static bool to_be_kept;  // there has been a sample: what holds now goes to where a reset leaves it
static uint32_t indicator_due;
static uint32_t read_at;           // the last reading of the thermocouples
static uint16_t samples_to_start;  // how long the start still waits for them

// What each thermocouple is on.
static const uint8_t component_of[MY1016_SENSORS] PROGMEM = {
    MY1016_BRUSH,
    MY1016_BEARING,
    MY1016_MAGNET,
    MY1016_CASING,
    MY1016_COMPONENTS,  // none: the ambient
};

// Reads the thermocouples and keeps only what passes its checks. Too early a reading would not only be unfinished, it would
// begin the conversion anew: it is left out.
static void read_thermocouples(uint32_t time) {
    const bool finished = time - read_at >= config::CONVERSION_MS;
    if (finished) {
        read_at = time;
    }
    now.sample.valid = 0;
    now.sample.plausible = 0;
    const int32_t told_mC = now.sample.ambient_mC;  // rises are over this one until another one is told
    now.flags |= device::AMBIENT;
    for (uint8_t channel = 0; channel < MY1016_SENSORS; ++channel) {
        const uint8_t component = pgm_read_byte(&component_of[channel]);
        const uint32_t word = finished ? thermocouples::read(channel) : 0;
        const int32_t model_mC = component < MY1016_COMPONENTS ? my1016_temperature_mC(component, told_mC) : 0;
        const uint8_t code = my1016_sensors_check(channel, word, finished, model_mC);
        if (component < MY1016_COMPONENTS && my1016_sensors_plausible(channel)) {
            now.sample.plausible = (uint16_t)(now.sample.plausible | 1u << component);
            now.sample.measured_mC[component] = my1016_sensors_plausible_mC(channel);
            now.sample.rising_mK[component] = my1016_sensors_rising_mK(channel);
        }
        if (code != MY1016_SAMPLE_OK) {
            continue;
        }
        if (component < MY1016_COMPONENTS) {
            now.sample.valid = (uint16_t)(now.sample.valid | 1u << component);
        } else {
            now.sample.ambient_mC = my1016_sensors_mC(channel);
            now.flags &= (uint16_t)~device::AMBIENT;
        }
    }
}

// Before the first believed ambient it is taken no warmer than the coldest part: at rest no part is colder than the room. In
// the cold a MAX6675 sends zeros, and the model would begin as far off as the room is from the fixed ambient.
static void bound_ambient() {
    for (uint8_t component = 0; component < MY1016_COMPONENTS; ++component) {
        if ((now.sample.valid & (1u << component)) && now.sample.measured_mC[component] < now.sample.ambient_mC) {
            now.sample.ambient_mC = now.sample.measured_mC[component];
        }
    }
}

static bool every_sample_is_valid() {
    for (uint8_t channel = 0; channel < MY1016_SENSORS; ++channel) {
        if (my1016_sensors_code(channel) != MY1016_SAMPLE_OK) {
            return false;
        }
    }
    return true;
}

// Thermocouples that were refused before a reset are refused at this sample, too.
static void disbelieve() {
    for (uint8_t channel = 0; channel < MY1016_SENSORS; ++channel) {
        if (my1016_sensors_code(channel) == MY1016_SAMPLE_OK) {
            continue;
        }
        const uint8_t component = pgm_read_byte(&component_of[channel]);
        if (component < MY1016_COMPONENTS) {
            now.sample.valid = (uint16_t)(now.sample.valid & ~(1u << component));
        } else if (component == MY1016_COMPONENTS) {
            now.sample.ambient_mC = my1016_sensors_mC(channel);  // the last believed one goes on
            now.flags |= device::AMBIENT;
        }
    }
}

// True if every part is measured and at ambient temperature: then it is at rest, too.
static bool is_cold() {
    for (uint8_t component = 0; component < MY1016_COMPONENTS; ++component) {
        const int32_t rise_mK = now.sample.measured_mC[component] - now.sample.ambient_mC;
        if (!(now.sample.valid & (1u << component)) || rise_mK > config::COLD_MK || rise_mK < -config::COLD_MK) {
            return false;
        }
    }
    return true;
}

// Puts the model where the thermocouples are, at rest, and at the ambient where there is none.
static void start_from_measured() {
    for (uint8_t component = 0; component < MY1016_COMPONENTS; ++component) {
        if (now.sample.valid & (1u << component)) {
            my1016_start(component, now.sample.measured_mC[component] - now.sample.ambient_mC);
            continue;
        }
        my1016_start(component, 0);  // the ambient may have been told since my1016_begin()
    }
}

// The model's start. After a reset the motor may be hot: the states come from RAM, or else from EEPROM, if what is there is
// still true, else from the measured temperatures, at rest. A part that is not measured starts at ambient temperature.
static void start() {
    now.started = true;
    my1016_sensors_model_set();
    const bool warm = warm::resume();
    const bool resumed = warm || memory::resume();
    if (warm) {
        disbelieve();
    }
    if (memory::firmware_is_new()) {
        console::event(F("firmware is new"));
    }
    if (!resumed) {
        start_from_measured();
    }
    const uint16_t kept = my1016_alarms();  // from before the reset
    if (!warm) {
        my1016_alarms_begin(resumed || is_cold());
        my1016_alarms_restore(kept);
    }
    if (kept || my1016_protection()) {
        console::event(F("alarms kept from before the reset"));
    }
    console::event(warm ? F("start from RAM") : resumed ? F("start from memory") : now.sample.valid ? F("start from measured") : F("start from ambient"));
}

// Reads the channels, and tells the model what it has to know. While a channel is not believed its last value stays.
static void tell() {
    my1016_channel(MY1016_CHANNEL_AMBIENT, now.sample.ambient_mC);
}

static void pass_sample() {
    now.milliseconds = (uint16_t)(now.milliseconds + MY1016_SAMPLE_MS % 1000);
    now.seconds += MY1016_SAMPLE_MS / 1000;
    if (now.milliseconds >= 1000) {
        now.milliseconds = (uint16_t)(now.milliseconds - 1000);
        ++now.seconds;
    }
}

static void tick(uint32_t time) {
    const uint32_t began = micros();
    now.flags &= device::AMBIENT;  // between two readings of the sensors it stays
    if (time - tick_due > config::LATE_MS) {
        now.flags |= device::LATE;
        if (now.late < 0xFFFFu) {
            ++now.late;
        }
    }
    tick_due += MY1016_SAMPLE_MS;

    read_thermocouples(time);
    if (!now.started && (now.flags & device::AMBIENT)) {
        bound_ambient();
    }
    tell();
    encoder::sample(drive::pwm());
    now.rpm = encoder::rpm();
    now.flags |= encoder::stalled() ? device::STALL : 0;
    now.flags |= encoder::noisy() ? device::NOISY : 0;

    if (now.started) {
        pass_sample();
        my1016_step(drive::pwm());
        my1016_alarms_step(drive::pwm(), &now.sample);
    } else {
        if (!every_sample_is_valid() && samples_to_start > 0) {
            --samples_to_start;
            return;
        }
        start();
    }

    commands::sample();
    selftest::sample();
    commissioning::sample();  // before the copies: its record is short
    const uint8_t most = guard::sample();
    drive::update(most);
    now.flags |= my1016_flags();
    now.flags |= most == 0 ? device::STOPPED : 0;
    latch::update(my1016_alarms(), my1016_protection_lasting());  // before the copies: it matters more
    now.flags |= latch::failed() ? device::MEMORY : 0;
    memory::update();
    now.flags |= memory::failed() ? device::MEMORY : 0;
    to_be_kept = true;
    console::sample();
    const uint32_t took = micros() - began;
    if (took > now.longest_us) {
        now.longest_us = took;
    }
}

static void indicate() {
    indicator::show(my1016_alarms(), !every_sample_is_valid(), my1016_protection_shows());
    if (indicator::update()) {
        commands::reset();
        console::event(F("alarms reset by the button"));
    }
}

static bool is_due(uint32_t when, uint32_t time) {
    return (int32_t)(time - when) >= 0;  // right across the rollover of millis()
}

void setup() {
    board::begin();
    console::begin();
    my1016_begin();
    my1016_alarms_begin(0);
    my1016_protection_begin();
    now.sample.ambient_mC = config::AMBIENT_MC;
    drive::begin();
    thermocouples::begin();
    my1016_sensors_begin();
    samples_to_start = config::START_SAMPLES;
    encoder::begin();
    indicator::begin();
    selftest::begin();
    memory::begin(selftest::crc());
    warm::begin(selftest::crc());
    commissioned::begin();
    latch::begin();
    my1016_alarms_restore(latch::alarms());
    my1016_protection_restore(latch::protection());
    const uint32_t time = millis();
    tick_due = time + MY1016_SAMPLE_MS;
    read_at = time;
    indicator_due = time;
    wdt_reset();  // a sample may be as long as a second
}

void loop() {
    const uint32_t time = millis();
    const bool keep_now = to_be_kept;  // a pass after the sample's own, so that nothing else waits for both
    if (is_due(tick_due, time)) {
        tick(time);
        if (!oscillator::measures()) {
            wdt_reset();  // only here: a board that takes no samples is reset
        }
        oscillator::sample();
    }
    if (is_due(indicator_due, time)) {
        indicator_due = time + indicator::SLOT_MS;
        indicate();
    }
    commands::receive();
    if (keep_now) {
        to_be_kept = false;
        warm::keep();
    }
    const bool keeping = latch::work();
    const bool writing = console::work();
    const bool sent = output::drain();
    if (!selftest::work() && !to_be_kept) {
        uint32_t until = is_due(tick_due, indicator_due) ? tick_due : indicator_due;
        if (writing || !sent || keeping) {
            until = millis() + 2;  // the UART sends 23 bytes meanwhile at 115200 baud, the EEPROM needs 3.4 ms for one
        }
        board::doze(until);
    }
}
