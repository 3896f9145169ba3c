// The checks of the thermocouples' samples; see my1016_sensors.h.
#include "my1016_sensors.h"

#include <string.h>

#include "my1016_platform.h"
#include "my1016_sensors_state.h"

my1016_Sensor my1016_sensors[MY1016_SENSORS];

namespace {

const uint8_t CONFIRMATIONS = 4;  // consistent samples in a row before a level is believed
const uint8_t PLAUSIBLE = 3;  // sound samples in a row that could be one part's before they are plausible
const uint8_t FASTER = 4;  // by how much a part that fails may outrun its largest physical change
const uint16_t NOISE = 4;  // counts (1 K): what two samples of a constant temperature may differ by
const int32_t COUNT_MK = 250;  // what a count is, in thousandths of a kelvin
const int16_t MOST_RISING = 262;  // counts: what 16 bits hold in thousandths of a kelvin
const uint16_t LONGEST = 9000;  // samples after which every count is within reach

// Counts are quarters of a degree Celsius, samples are readings (250 ms).
struct Limits {
    int16_t lowest, highest;   // counts, both allowed
    uint16_t step;             // largest physical change from one sample to the next, in counts
    uint32_t stuck_samples;    // the same count for so many samples is a stuck sensor (0: never) ..
    int32_t stuck_mK;          // .. if the model moved by more than this meanwhile (0: in any case)
};

const Limits limits[MY1016_SENSORS] PROGMEM = {
    // brush, $.wiring.thermocouples[0]: MAX6675, 0..250 degC, 5 K/s, stuck after 30 s in which the model moved by 3 K
    {0, 1000, 5, 120UL, 3000L},
    // bearing, $.wiring.thermocouples[1]: MAX6675, 0..250 degC, 5 K/s, stuck after 30 s in which the model moved by 3 K
    {0, 1000, 5, 120UL, 3000L},
    // magnet, $.wiring.thermocouples[2]: MAX6675, 0..250 degC, 5 K/s, stuck after 30 s in which the model moved by 3 K
    {0, 1000, 5, 120UL, 3000L},
    // casing, $.wiring.thermocouples[3]: MAX6675, 0..250 degC, 5 K/s, stuck after 30 s in which the model moved by 3 K
    {0, 1000, 5, 120UL, 3000L},
    // ambient, $.wiring.thermocouples[4]: MAX6675, 0..60 degC, 5 K/s, not checked for being stuck
    {0, 240, 5, 0UL, 0L},
};

using Sensor = my1016_Sensor;

uint16_t distance(int16_t a, int16_t b) { return (uint16_t)(a > b ? a - b : b - a); }

// Behind a MAX6675's word come bits that are all the same, or its word again; a MAX31855 sends its own temperature there, and
// its faults. Read as a MAX6675 it would give half of what it measures.
bool is_max31855(uint16_t upper, uint16_t lower) {
    if (lower == 0 || lower == 0xFFFFu || lower == upper || (lower & 0x0008u)) {
        return false;
    }
    const int16_t own = (int16_t)((int16_t)(lower & 0xFFF0u) / 16);
    return own >= -55 * 16 && own <= 125 * 16 && ((upper & 1u) != 0) == ((lower & 7u) != 0);
}

uint8_t decoded_max6675(uint32_t word, int16_t *counts) {
    const uint16_t own = (uint16_t)word;  // bit 0 is not driven by the chip
    if ((own & 0x8002u) || is_max31855(own, (uint16_t)(word >> 16))) {  // the sign and the device's number, always 0
        return MY1016_SAMPLE_ONES;
    }
    if ((own & 0xFFFEu) == 0) {
        return MY1016_SAMPLE_ZEROS;
    }
    *counts = (int16_t)(own >> 3);
    return own & 0x0004u ? MY1016_SAMPLE_OPEN : MY1016_SAMPLE_OK;
}

// What is wrong with a word; its temperature where nothing is.
uint8_t decoded(const Limits &limit, uint32_t word, int16_t *counts) {
    (void)limit;
    return decoded_max6675(word, counts);
}

// Below 0 degC a MAX6675 sends zeros: they go on from a temperature that has just come down to them.
bool is_cold(const Sensor *sensor, const Limits &limit) {
    (void)limit;
    return sensor->known && sensor->believed <= (int16_t)NOISE && sensor->since <= CONFIRMATIONS;
}

// Keeps a sound sample; whether it agrees with the one before it.
bool is_consistent(Sensor *sensor, const Limits &limit, int16_t counts) {
    const uint16_t apart = distance(counts, sensor->latest[0]);
    if (sensor->agreed == 0 || apart > NOISE + (uint32_t)FASTER * limit.step) {
        sensor->agreed = 1;
    } else if (sensor->agreed < CONFIRMATIONS) {
        ++sensor->agreed;
    }
    memmove(sensor->latest + 1, sensor->latest, sizeof sensor->latest - sizeof *sensor->latest);
    sensor->latest[0] = counts;
    return apart <= NOISE + limit.step;
}

// A part that fails outruns its largest physical change: the samples since the last believed one rise together, none by more
// than half of it all. A step is no such rise, and a fall neither: a sensor that comes off falls.
bool is_rise(const Sensor *sensor) {
    if (sensor->agreed < CONFIRMATIONS || sensor->since >= CONFIRMATIONS) {
        return false;
    }
    int16_t largest = 0;
    for (uint8_t i = 1; i < CONFIRMATIONS; ++i) {
        const int16_t rise = (int16_t)(sensor->latest[i - 1] - sensor->latest[i]);
        largest = rise > largest ? rise : largest;
    }
    const int16_t all = (int16_t)(sensor->latest[0] - sensor->latest[CONFIRMATIONS - 1]);
    return all > (int16_t)NOISE && 2 * largest <= all + (int16_t)NOISE;
}

// A settled motor's thermocouple may rightly show the same count for an hour. It is stuck if the model meanwhile moved
// by more than the model and the sensor can be apart in a change.
bool is_stuck(Sensor *sensor, const Limits &limit, int16_t counts, int32_t model_mC) {
    if (!sensor->watching || counts != sensor->latest[0]) {
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
bool is_displaced(Sensor *sensor, const Limits &limit, int16_t counts, int32_t model_mC) {
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

uint8_t judged(Sensor *sensor, const Limits &limit, uint32_t word, int32_t model_mC) {
    int16_t counts = 0;
    uint8_t fault = decoded(limit, word, &counts);
    if (fault == MY1016_SAMPLE_ZEROS && is_cold(sensor, limit)) {
        fault = MY1016_SAMPLE_OK;
    }
    if (fault) {
        sensor->run = 0;
        sensor->agreed = 0;
        return fault;
    }
    if (counts < limit.lowest || counts > limit.highest) {
        is_consistent(sensor, limit, counts);
        sensor->run = 0;
        return MY1016_SAMPLE_RANGE;
    }
    const bool stuck = is_stuck(sensor, limit, counts, model_mC);
    const bool consistent = is_consistent(sensor, limit, counts);
    const bool jumped = sensor->run > 0 && !consistent;
    if (sensor->run == 0 || jumped) {
        sensor->run = 1;
    } else if (sensor->run < CONFIRMATIONS) {
        ++sensor->run;
    }
    if (stuck) {
        return MY1016_SAMPLE_STUCK;
    }
    if (is_displaced(sensor, limit, counts, model_mC) || jumped) {
        if (!is_rise(sensor)) {
            return MY1016_SAMPLE_JUMP;
        }
    } else if (sensor->run < CONFIRMATIONS) {
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
        my1016_sensors[channel] = Sensor();
        my1016_sensors[channel].code = MY1016_SAMPLE_UNREAD;
    }
}

extern "C" void my1016_sensors_model_set(void) {
    for (uint8_t channel = 0; channel < MY1016_SENSORS; ++channel) {
        my1016_sensors[channel].watching = false;
        my1016_sensors[channel].rebase = true;
    }
}

extern "C" void my1016_sensors_accept(uint8_t channel) {
    Sensor *const sensor = &my1016_sensors[channel];
    if (sensor->displaced) {
        sensor->displaced = false;
        sensor->known = false;
        sensor->run = 0;
    }
}

void my1016_sensors_restore(uint8_t channel, const my1016_Sensor *before) {
    if (before->displaced || before->code == MY1016_SAMPLE_STUCK) {
        my1016_sensors[channel] = *before;
    }
}

extern "C" uint8_t my1016_sensors_check(uint8_t channel, uint32_t word, uint8_t finished, int32_t model_mC) {
    Sensor *const sensor = &my1016_sensors[channel];
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

extern "C" uint8_t my1016_sensors_code(uint8_t channel) { return my1016_sensors[channel].code; }

extern "C" int32_t my1016_sensors_mC(uint8_t channel) { return (int32_t)my1016_sensors[channel].believed * COUNT_MK; }

extern "C" uint8_t my1016_sensors_plausible(uint8_t channel) {
    const Sensor *const sensor = &my1016_sensors[channel];
    const bool read = sensor->code != MY1016_SAMPLE_EARLY && sensor->code != MY1016_SAMPLE_STUCK;
    return read && sensor->agreed >= PLAUSIBLE;
}

extern "C" int32_t my1016_sensors_plausible_mC(uint8_t channel) { return (int32_t)my1016_sensors[channel].latest[0] * COUNT_MK; }

// One reading that is off makes no rise: it is in one of the two alone, or lowers it.
extern "C" uint16_t my1016_sensors_rising_mK(uint8_t channel) {
    const Sensor *const sensor = &my1016_sensors[channel];
    if (!my1016_sensors_plausible(channel) || sensor->agreed < CONFIRMATIONS) {
        return 0;
    }
    const int16_t last = (int16_t)(sensor->latest[0] - sensor->latest[2]), before = (int16_t)(sensor->latest[1] - sensor->latest[3]);
    const int16_t rise = (int16_t)((last < before ? last : before) - (int16_t)NOISE);
    return rise <= 0 ? 0 : (uint16_t)((uint16_t)(rise < MOST_RISING ? rise : MOST_RISING) * (uint16_t)COUNT_MK);
}
