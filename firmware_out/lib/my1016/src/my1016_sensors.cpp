// The checks of the thermocouples' samples; see my1016_sensors.h.
#include "my1016_sensors.h"

#include "my1016_platform.h"

namespace {

const uint8_t CONFIRMATIONS = 4;  // consistent samples in a row before a level is believed
const uint16_t NOISE = 4;  // counts (1 K): what two samples of a constant temperature may differ by
const int32_t COUNT_MK = 250;  // what a count is, in thousandths of a kelvin
const uint16_t LONGEST = 4095;  // samples after which every count is within reach

// Counts are quarters of a degree Celsius, samples are readings (250 ms).
struct Limits {
    uint16_t lowest, highest;  // counts, both allowed
    uint16_t step;             // largest physical change from one sample to the next, in counts
    uint32_t stuck_samples;    // the same count for so many samples is a stuck sensor (0: never) ..
    int32_t stuck_mK;          // .. if the model moved by more than this meanwhile (0: in any case)
};

const Limits limits[MY1016_SENSORS] PROGMEM = {
    // brush, $.wiring.thermocouples[0]: 0..250 degC, 5 K/s, stuck after 300 s in which the model moved by 3 K
    {0, 1000, 5, 1200UL, 3000L},
    // bearing, $.wiring.thermocouples[1]: 0..250 degC, 5 K/s, stuck after 300 s in which the model moved by 3 K
    {0, 1000, 5, 1200UL, 3000L},
    // magnet, $.wiring.thermocouples[2]: 0..250 degC, 5 K/s, stuck after 300 s in which the model moved by 3 K
    {0, 1000, 5, 1200UL, 3000L},
    // casing, $.wiring.thermocouples[3]: 0..250 degC, 5 K/s, stuck after 300 s in which the model moved by 3 K
    {0, 1000, 5, 1200UL, 3000L},
    // ambient, $.wiring.thermocouples[4]: 0..60 degC, 5 K/s, not checked for being stuck
    {0, 240, 5, 0UL, 0L},
};

struct Sensor {
    uint8_t code;        // of the last sample
    uint8_t run;         // consistent samples in a row, up to CONFIRMATIONS
    bool known;          // there is a believed sample
    bool watching;       // `unchanged`, `moved` and `model_mC` are about the present model and count
    bool displaced;      // it jumped farther than physics allows, and has not come back
    bool rebase;         // the model was set anew: `then_mC` is to be taken again
    bool moved;          // the model moved by more than stuck_mK since the count changed
    uint16_t previous;   // the last sample with a sound word in the physical range
    uint16_t believed;   // the last sample that passed every check
    uint16_t since;      // samples since then
    uint32_t unchanged;  // samples since the count changed
    int32_t model_mC;    // the model's temperature then
    int32_t then_mC;     // the model's temperature at the last believed sample
};

Sensor sensors[MY1016_SENSORS];

uint16_t distance(uint16_t a, uint16_t b) { return (uint16_t)(a > b ? a - b : b - a); }

uint8_t word_fault(uint16_t word, uint16_t counts, const Limits &limit) {
    if ((word & 0xFFFEu) == 0) {  // bit 0 is not driven by the chip
        return MY1016_SAMPLE_ZEROS;
    }
    if (word & 0x8002u) {  // the sign and the device's number, always 0
        return MY1016_SAMPLE_ONES;
    }
    if (word & 0x0004u) {
        return MY1016_SAMPLE_OPEN;
    }
    return counts < limit.lowest || counts > limit.highest ? MY1016_SAMPLE_RANGE : MY1016_SAMPLE_OK;
}

// A settled motor's thermocouple may rightly show the same count for an hour. It is stuck if the model meanwhile moved
// by more than the model and the sensor can be apart in a change.
bool is_stuck(Sensor *sensor, const Limits &limit, uint16_t counts, int32_t model_mC) {
    if (!sensor->watching || counts != sensor->previous) {
        sensor->watching = true;
        sensor->moved = false;
        sensor->unchanged = 0;
        sensor->model_mC = model_mC;
    } else {
        if (sensor->unchanged < UINT32_MAX) {
            ++sensor->unchanged;
        }
        const int32_t change = model_mC - sensor->model_mC;
        if (change > limit.stuck_mK || change < -limit.stuck_mK) {
            sensor->moved = true;
        }
    }
    return limit.stuck_samples && sensor->unchanged >= limit.stuck_samples && (sensor->moved || !limit.stuck_mK);
}

// Whether a sample cannot be the part's temperature, by the last believed one. Once a sound sample was out of reach, time does
// not make its level true: it is believed again only where the last believed one would be now, had it moved as the model did.
bool is_displaced(Sensor *sensor, const Limits &limit, uint16_t counts, int32_t model_mC) {
    if (!sensor->known) {
        return false;
    }
    if (sensor->rebase) {
        sensor->rebase = false;
        sensor->then_mC = model_mC;
    }
    if (!sensor->displaced) {
        sensor->displaced = distance(counts, sensor->believed) > NOISE + (uint32_t)limit.step * sensor->since;
        return sensor->displaced;
    }
    const int32_t expected_mC = (int32_t)sensor->believed * COUNT_MK + (model_mC - sensor->then_mC);
    const int32_t off_mK = (int32_t)counts * COUNT_MK - expected_mC;
    const int32_t tolerance_mK = (int32_t)(NOISE + limit.step) * COUNT_MK;
    return off_mK > tolerance_mK || off_mK < -tolerance_mK;
}

uint8_t judged(Sensor *sensor, const Limits &limit, uint16_t word, int32_t model_mC) {
    const uint16_t counts = word >> 3;
    const uint8_t fault = word_fault(word, counts, limit);
    if (fault) {
        sensor->run = 0;
        return fault;
    }
    const bool stuck = is_stuck(sensor, limit, counts, model_mC);
    const bool first = sensor->run == 0;
    const bool consistent = !first && distance(counts, sensor->previous) <= NOISE + limit.step;
    if (!consistent) {
        sensor->run = 1;
    } else if (sensor->run < CONFIRMATIONS) {
        ++sensor->run;
    }
    sensor->previous = counts;
    if (stuck) {
        return MY1016_SAMPLE_STUCK;
    }
    if (is_displaced(sensor, limit, counts, model_mC) || (!first && !consistent)) {
        return MY1016_SAMPLE_JUMP;
    }
    if (sensor->run < CONFIRMATIONS) {
        return MY1016_SAMPLE_UNCONFIRMED;
    }
    sensor->believed = counts;
    sensor->then_mC = model_mC;
    sensor->known = true;
    sensor->displaced = false;
    sensor->rebase = false;
    sensor->since = 0;
    return MY1016_SAMPLE_OK;
}

}  // namespace

extern "C" void my1016_sensors_begin(void) {
    for (uint8_t channel = 0; channel < MY1016_SENSORS; ++channel) {
        sensors[channel] = Sensor();
        sensors[channel].code = MY1016_SAMPLE_UNREAD;
    }
}

extern "C" void my1016_sensors_model_set(void) {
    for (uint8_t channel = 0; channel < MY1016_SENSORS; ++channel) {
        sensors[channel].watching = false;
        sensors[channel].rebase = true;
    }
}

extern "C" void my1016_sensors_accept(void) {
    for (uint8_t channel = 0; channel < MY1016_SENSORS; ++channel) {
        Sensor *const sensor = &sensors[channel];
        if (sensor->displaced) {
            sensor->displaced = false;
            sensor->known = false;
            sensor->run = 0;
        }
    }
}

extern "C" uint8_t my1016_sensors_check(uint8_t channel, uint16_t word, uint8_t finished, int32_t model_mC) {
    Sensor *const sensor = &sensors[channel];
    if (sensor->since < LONGEST) {
        ++sensor->since;
    }
    if (!finished) {
        sensor->code = MY1016_SAMPLE_EARLY;
        return sensor->code;
    }
    Limits limit;
    memcpy_P(&limit, &limits[channel], sizeof limit);
    sensor->code = judged(sensor, limit, word, model_mC);
    return sensor->code;
}

extern "C" uint8_t my1016_sensors_code(uint8_t channel) { return sensors[channel].code; }

extern "C" int32_t my1016_sensors_mC(uint8_t channel) { return (int32_t)sensors[channel].believed * COUNT_MK; }
