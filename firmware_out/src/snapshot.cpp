#include "snapshot.h"

#include <my1016.h>
#include <my1016_sensors_state.h>

#include "config.h"

namespace snapshot {

namespace {

const uint16_t UNMEASURED = 0x8000;  // no chip gives so many counts below 0

uint16_t counts_of(uint8_t channel) {
    const bool believed = my1016_sensors_code(channel) == MY1016_SAMPLE_OK;
    return believed ? (uint16_t)my1016_sensors[channel].believed : UNMEASURED;
}

}  // namespace

void take(Snapshot *to) {
    to->pwm = my1016_model.command;
    for (uint8_t channel = 0; channel < MY1016_SENSORS; ++channel) {
        to->measured[channel] = counts_of(channel);
    }
    to->state = my1016_model.state;
}

bool is_true(const Snapshot &of) {
    uint8_t agreeing = 0;
    const uint8_t on_component[] = {0, 1, 2, 3};
    for (uint8_t channel : on_component) {
        const uint16_t then = of.measured[channel], now = counts_of(channel);
        if (then == UNMEASURED || now == UNMEASURED) {
            continue;
        }
        const int16_t change = (int16_t)((int16_t)now - (int16_t)then);
        if (change > (int16_t)config::COPY_TOLERANCE || change < -(int16_t)config::COPY_TOLERANCE) {
            return false;
        }
        ++agreeing;
    }
    return agreeing > 0;
}

void put(const Snapshot &from) {
    my1016_model.state = from.state;
    my1016_resume(from.pwm);
}

}  // namespace snapshot
