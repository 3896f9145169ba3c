#include "commissioning.h"

#include <Arduino.h>
#include <my1016_alarms.h>
#include <my1016_sensors_state.h>

#include "commissioned.h"
#include "commissioning_words.h"
#include "config.h"
#include "console.h"
#include "device.h"
#include "drive.h"
#include "encoder.h"
#include "output.h"

using device::now;

namespace commissioning {

namespace {

Phase phase = IDLE;
uint16_t samples;  // in this phase
uint16_t held;     // samples for which what is waited for has held
uint8_t asked;     // the thermocouple that is to be warmed
int16_t base[MY1016_SENSORS];  // counts of 0.25 degC: where each was when this one's turn came ..
int16_t peak;  // .. and the highest that this one has come to since
bool reverse;

// What one sample says of the thermocouples.
struct Change {
    uint8_t channel;  // NOBODY: nothing
    Failure what;     // WARMER (no failure if it was asked for), COLDER, UNREAD
};
Change change;  // that is waited for to hold

// What is to be said as soon as there is room: an instruction, why it failed, or that it was passed.
bool unsaid;
Failure failure;
Phase failed_in;
uint8_t culprit;
uint16_t figure;

void enter(Phase next) {
    phase = next;
    samples = 0;
    held = 0;
    change.channel = NOBODY;
    failure = NONE;
    unsaid = true;
}

void fail(Failure why, uint8_t channel = NOBODY, uint16_t number = 0) {
    drive::command(0);
    drive::disarm();
    if (phase == KEEP) {
        commissioned::set(false);
    }
    failed_in = phase;
    enter(IDLE);
    failure = why;
    culprit = channel;
    figure = number;
}

void say() {
    if (unsaid && output::takes_line()) {
        unsaid = false;
        put({failure == NONE ? phase : failed_in, failure, asked, culprit, figure, reverse});
    }
}

// ---- thermocouples ----------------------------------------------------------------------------------------------

// The last sound sample, believed or not: a hand, or warm water, may be faster than a part of a motor.
int16_t level(uint8_t channel) { return my1016_sensors[channel].latest[0]; }

bool is_read(uint8_t channel) {
    const uint8_t code = my1016_sensors_code(channel);
    return code != MY1016_SAMPLE_OPEN && code != MY1016_SAMPLE_ZEROS && code != MY1016_SAMPLE_ONES;
}

void take_base() {
    for (uint8_t channel = 0; channel < MY1016_SENSORS; ++channel) {
        base[channel] = level(channel);
    }
}

// All are believed, at one temperature, and stay there: only then a change of one of them is a hand's.
void watch_cold() {
    if (samples == 0) {
        take_base();
    }
    uint8_t warmest = 0, coldest = 0;
    for (uint8_t channel = 0; channel < MY1016_SENSORS; ++channel) {
        const uint8_t code = my1016_sensors_code(channel);
        if (code != MY1016_SAMPLE_OK && code != MY1016_SAMPLE_EARLY) {
            fail(UNREAD, channel);
            return;
        }
        const int16_t moved = (int16_t)(level(channel) - base[channel]);
        if (moved > config::STEADY || moved < -config::STEADY) {
            fail(UNSTEADY, channel);
            return;
        }
        warmest = level(channel) > level(warmest) ? channel : warmest;
        coldest = level(channel) < level(coldest) ? channel : coldest;
    }
    const int16_t apart = (int16_t)(level(warmest) - level(coldest));
    if (apart > config::AGREE) {
        fail(APART, warmest, (uint16_t)apart);
    } else if (samples >= config::COLD_SAMPLES) {
        asked = 0;
        take_base();
        enter(WARM);
    }
}

// The thermocouple that has left all others, up or down. Those that were warmed before are cooling: theirs is no fall.
Change seen() {
    Change up = {NOBODY, WARMER}, down = {NOBODY, COLDER};
    int16_t highest = 0, next_highest = 0, lowest = 0, next_lowest = 0;
    for (uint8_t channel = 0; channel < MY1016_SENSORS; ++channel) {
        if (!is_read(channel)) {
            return {channel, UNREAD};
        }
        const int16_t at = level(channel);
        if (channel < asked && at < base[channel]) {
            base[channel] = at;
        }
        const int16_t moved = (int16_t)(at - base[channel]);
        if (moved > highest) {
            next_highest = highest;
            highest = moved;
            up.channel = channel;
        } else if (moved > next_highest) {
            next_highest = moved;
        }
        if (moved < lowest) {
            next_lowest = lowest;
            lowest = moved;
            down.channel = channel;
        } else if (moved < next_lowest) {
            next_lowest = moved;
        }
    }
    if (highest - next_highest >= config::MOVED) {
        return up;
    }
    if (next_lowest - lowest >= config::MOVED) {
        return down;
    }
    return {NOBODY, NONE};
}

void watch_warm() {
    const Change at = seen();
    if (at.channel != change.channel || at.what != change.what) {
        change = at;
        held = 0;
    }
    if (at.channel == NOBODY) {
        if (samples >= config::PERSON_SAMPLES) {
            fail(WAITED);
        }
    } else if (++held >= config::HELD_SAMPLES) {
        if (at.what == WARMER && at.channel == asked) {
            peak = level(asked);
            enter(LET_GO);
        } else {
            fail(at.what, at.channel);
        }
    }
}

// The hand may stay for a while: the next one's turn comes when this one warms no more.
void watch_let_go() {
    if (level(asked) > peak) {
        peak = level(asked);
        held = 0;
    } else if (++held >= config::LET_GO_SAMPLES) {
        my1016_sensors_accept(asked);  // faster than a part may be; somebody has looked at it, and it is the right one
        if (++asked < MY1016_SENSORS) {
            take_base();
            enter(WARM);
        } else {
            reverse = false;
            drive::disarm();
            enter(ARM);
        }
        return;
    }
    if (samples >= config::PERSON_SAMPLES) {
        fail(WAITED);
    }
}

// ---- the motor --------------------------------------------------------------------------------------------------

void run() {
    if (now.rpm > 0) {
        fail(TURNED, NOBODY, now.rpm);
        return;
    }
    enter(RUN);
    drive::command(reverse ? (int16_t)-config::COMMISSIONING_PWM : config::COMMISSIONING_PWM);
}

void watch_arm() {
    if (drive::armed()) {
        run();
    } else if (samples >= config::PERSON_SAMPLES) {
        fail(WAITED);
    }
}

void watch_run() {
    if (!drive::armed()) {
        fail(STOPPED);
        return;
    }
    const int16_t pwm = drive::pwm();
    const bool must_turn = pwm >= config::STALL_PWM || pwm <= -config::STALL_PWM;
    held = must_turn && now.rpm == 0 ? (uint16_t)(held + 1) : 0;
    if (encoder::noisy()) {
        fail(NOISY);
        return;
    }
    if (held >= config::NO_PULSE_SAMPLES || (samples >= config::RUN_SAMPLES && now.rpm == 0)) {
        fail(SILENT);
        return;
    }
    if (samples >= config::RUN_SAMPLES) {
        drive::command(0);
        enter(STOP);
        figure = now.rpm;
    }
}

void watch_stop() {
    held = now.rpm == 0 ? (uint16_t)(held + 1) : 0;
    if (held >= config::HELD_SAMPLES) {
        enter(ASK);
    } else if (samples >= config::STOP_SAMPLES) {
        fail(TURNS_ON, NOBODY, now.rpm);
    }
}

void keep_on() {
    if (!commissioned::busy()) {
        if (commissioned::passed()) {
            enter(IDLE);
        } else {
            fail(UNWRITTEN);
        }
    }
}

void go_on() {
    switch (phase) {
        case COLD:
            watch_cold();
            break;
        case WARM:
            watch_warm();
            break;
        case LET_GO:
            watch_let_go();
            break;
        case ARM:
            watch_arm();
            break;
        case RUN:
            watch_run();
            break;
        case STOP:
            watch_stop();
            break;
        case ASK:
        case OFFER:
            if (samples >= config::PERSON_SAMPLES) {
                fail(WAITED);
            }
            break;
        default:
            keep_on();
            break;
    }
}

}  // namespace

void start() {
    if (phase != IDLE) {
        end();
        return;
    }
    if (drive::pwm() != 0) {
        console::event(F("commissioning: not begun, the motor is driven"));
        return;
    }
    commissioned::set(false);
    enter(COLD);
}

bool answer(bool yes) {
    if (phase == IDLE) {
        return false;
    }
    if (phase == ASK) {
        if (!yes) {
            fail(WRONG_WAY);
        } else if (reverse) {
            commissioned::set(true);
            enter(KEEP);
        } else {
            reverse = true;
            enter(OFFER);
        }
        return true;
    }
    if (phase == OFFER) {
        if (yes) {
            run();
        } else {
            commissioned::set(true);
            enter(KEEP);
        }
        return true;
    }
    if (!yes) {
        fail(ENDED);
    }
    return true;
}

void end() {
    if (phase != IDLE) {
        fail(ENDED);
    }
}

bool drives() { return phase >= ARM; }

void sample() {
    commissioned::sample();
    if (phase != IDLE) {
        if (my1016_alarms()) {
            fail(ALARM);
        } else if (drive::pwm() != 0 && !drives()) {
            fail(DRIVEN);
        } else {
            go_on();
            samples = (uint16_t)(samples + (samples < 0xFFFFu));
        }
    }
    say();
}

}  // namespace commissioning
